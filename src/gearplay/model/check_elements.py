"""Findings about supports, couplings, excitation and housing: parts without effect, or with an unexpected one."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Final

from gearplay.model import geometry
from gearplay.model.finding import Finding

if TYPE_CHECKING:
    from gearplay.model.case import Case
    from gearplay.model.rotor import Rotor

FEWEST_SAMPLES: Final = 10
"""Samples of a control that a run should hold at least."""


def element_findings(case: Case) -> Iterator[Finding]:
    """Yield findings about the elements of a valid case."""
    yield from _supports(case)
    for index, coupling in enumerate(case.couplings):
        bends = coupling.lateral_stiffness > 0.0 or coupling.lateral_damping > 0.0
        if bends and all(geometry.is_held(case, name) for name in coupling.between):
            text = "it does nothing, since both centres are held: give one a support with a stiffness or a sleeve"
            yield Finding("warning", f"couplings.{index}.lateral_stiffness", f"{text}.")
    for name, rotor in case.rotors.items():
        yield from _rotor(case, name, rotor)
    yield from _base(case)


def _supports(case: Case) -> Iterator[Finding]:
    for name, support in case.supports.items():
        if any(support.damping) and geometry.is_held(case, name):
            text = "it does nothing, since the centre is held: give the support a stiffness, or the rotor a sleeve"
            yield Finding("warning", f"supports.{name}.damping", f"{text}.")
        if support.stiffness is not None and name not in case.sleeves:
            for axis, stiffness in zip("xy", support.stiffness, strict=True):
                if stiffness == 0.0:
                    text = f"the centre is free along {axis}: without a stiffness there any force moves it away for good"
                    yield Finding("warning", f"supports.{name}.stiffness", f"{text}.")


def _rotor(case: Case, name: str, rotor: Rotor) -> Iterator[Finding]:
    drive = rotor.drive
    prescribed = drive is not None and drive.kind == "speed"
    if rotor.unbalance is not None and prescribed and geometry.is_held(case, name):
        text = "it does nothing, since centre and rotation are held; its force on the bearing is in no signal"
        yield Finding("warning", f"rotors.{name}.unbalance", f"{text}.")
    if drive is not None and drive.kind == "position" and drive.sample_time > 0.0:
        samples = (case.run.transient + case.run.duration) / drive.sample_time
        if samples < FEWEST_SAMPLES:
            text = f"the whole run holds {samples:.3g} samples of the control: the torque is held in between"
            yield Finding("warning", f"rotors.{name}.drive.sample_time", f"{text}.")


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
