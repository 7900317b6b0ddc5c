"""Findings about supports, couplings, excitation and housing: parts without effect, or with an unexpected one."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from gearplay.parts.mesh.train import geometry
from gearplay.parts.mesh.train.rolling import nominal_speeds
from gearplay.schema.finding import Finding

if TYPE_CHECKING:
    from gearplay.model.case import Case
    from gearplay.parts.rotor.schema import Rotor


def element_findings(case: Case) -> Iterator[Finding]:
    """Yield findings about the elements of a valid case."""
    for table, name, part in case.every_holder():
        held, alone = geometry.is_held(case, name), len(case.holders(name)) == 1
        yield from part.findings(f"{table}.{name}", held=held, alone=alone)
    for path, _, joint in case.named_joints():
        held = all(geometry.is_held(case, name) for name in joint.named_rotors().values())
        yield from joint.findings(path, held=held)
    if case.faults:
        speeds = dict(zip(case.rotors, nominal_speeds(case).tolist(), strict=True))
        for index, fault in enumerate(case.faults):
            part = fault.part(getattr(case, fault.table))
            carrier = getattr(part, "on", None)
            speed = speeds.get(fault.at, 0.0) - (0.0 if carrier is None else speeds[carrier])
            yield from fault.findings(f"faults.{index}", part, speed)
    for name, rotor in case.rotors.items():
        yield from _rotor(case, name, rotor)
    yield from _base(case)


def _rotor(case: Case, name: str, rotor: Rotor) -> Iterator[Finding]:
    if rotor.unbalance is not None and rotor.is_prescribed and geometry.is_held(case, name):
        text = "it does nothing, since centre and rotation are held; its force on the bearing is in no signal"
        yield Finding("warning", f"rotors.{name}.unbalance", f"{text}.")
    if rotor.drive is not None:
        yield from rotor.drive.findings(f"rotors.{name}.drive", case.run.transient + case.run.duration)


def _base(case: Case) -> Iterator[Finding]:
    if case.base is None or case.base.acceleration.kind != "record":
        return
    record, span = case.base.acceleration, case.run.transient + case.run.duration
    end = record.start + (len(record.values) - 1) / record.sampling
    if end < span:
        text = f"it ends at {end:.4g} s, the run at {span:.4g} s: from then on the housing is not accelerated"
        jump = abs(record.values[-1])
        if jump > 0.0:
            text += f"; it ends with {jump:.3g} m/s^2, which then stop at once"
        yield Finding("note", "base.acceleration.values", f"{text}.")
