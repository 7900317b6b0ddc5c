"""Findings about a run: its start, and undamped motion."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from gearplay.parts.mesh.train import geometry, rolling
from gearplay.parts.rotor.schema import Initial
from gearplay.schema.finding import Finding

if TYPE_CHECKING:
    from gearplay.model.case import Case

SETTLED = 0.25
"""Share of a record that is proposed as the time before it."""


def run_findings(case: Case) -> Iterator[Finding]:
    """Yield findings about sampling and start of a valid case's run, and about teeth without losses."""
    yield from _sampling(case)
    if any(
        rolling.mesh_frequency(case, j) > 0.0 for j in range(len(case.meshes))
    ):  # else there is nothing to settle to
        yield from _transient(case)
        yield from _undamped(case)
        yield from _undamped_centres(case)
        yield from _start_shock(case)


def _sampling(case: Case) -> Iterator[Finding]:
    """Compare the sampling with the lines that the case excites (Nyquist: f < sampling / 2)."""
    lines = [(frequency, what) for frequency, what in _lines(case) if frequency >= 0.5 * case.run.sampling]
    if not lines:
        return
    shown = [f"{what}, {frequency:.6g} Hz" for frequency, what in sorted(dict.fromkeys(lines))[:3]]
    more = ", ..." if len(lines) > 3 else ""
    yield Finding(
        "warning",
        "run.sampling",
        f"{case.run.sampling:g} Hz shows frequencies below {0.5 * case.run.sampling:g} Hz. Beyond it, and so at wrong places "
        f"of a spectrum, are: {'; '.join(shown)}{more}. Choose more than {2.0 * max(lines)[0]:.6g} Hz.",
    )


def _lines(case: Case) -> Iterator[tuple[float, str]]:
    """Yield lines [Hz] with their names: mesh frequencies and their doubles, ripples, terms of torques."""
    speeds = dict(zip(case.rotors, rolling.nominal_speeds(case).tolist(), strict=True))
    for j in range(len(case.meshes)):
        frequency = rolling.mesh_frequency(case, j)
        if frequency > 0.0:
            yield frequency, "the mesh frequency"
            yield 2.0 * frequency, "twice the mesh frequency"
    for name, rotor in case.rotors.items():
        turns = abs(speeds[name]) / (2.0 * math.pi)
        for ripple in getattr(rotor.drive, "ripple", ()):
            yield ripple.order * turns, f"the ripple of {name}"
        for term in (*rotor.load.terms, *getattr(rotor.drive, "terms", ())):
            yield term.frequency or (term.order or 0.0) * turns, f"the torque on {name}"


def _transient(case: Case) -> Iterator[Finding]:
    run = case.run
    meant = case.base is not None or any(
        rotor.initial != Initial() or (rotor.drive and rotor.drive.run_up()[1] > 0.0)
        for rotor in case.rotors.values()
    )
    if run.transient > 0.0 or meant:
        return
    sources = [each for rotor in case.rotors.values() for each in (rotor.load, rotor.drive) if each]
    largest = max(each.largest_torque() for each in sources)
    applied = (
        f": torques of up to {largest:.4g} N m act at once, which may double what they press with"
        if largest > 0.0
        else ""
    )
    yield Finding(
        "warning",
        "run.transient",
        f"recording starts at t = 0, so the {run.duration:g} s of the record begin with the start{applied}. Give a transient, "
        f"{SETTLED * run.duration:.2g} s for example, and see whether a longer one changes anything.",
    )


def _undamped(case: Case) -> Iterator[Finding]:
    bare = [j for j, mesh in enumerate(case.meshes) if not (mesh.damping.maximum or mesh.damping.ratio)]
    if not bare or case.torsional_pair is not None:  # the pair's damping is the drag of its wheel
        return
    labels = ", ".join(case.meshes[j].label for j in bare[:3]) + (", ..." if len(bare) > 3 else "")
    yield Finding(
        "warning",
        f"meshes.{bare[0]}.damping",
        f"the damping is 0 N s/m in {len(bare)} of {len(case.meshes)} meshes ({labels}): their teeth rebound "
        "without loss, and a resonance grows without a bound. Give damping = { ratio = 0.07 }, for example.",
    )


def _undamped_centres(case: Case) -> Iterator[Finding]:
    """Name rotors whose centres lose energy in meshes only: those damp motion along their lines of action."""
    bare = [
        name
        for name, rotor in case.rotors.items()
        if (parts := list(case.holders(name)))
        and rotor.mass > 0.0
        and rotor.radial_damping == 0.0
        and not geometry.is_held(case, name)
        and not any(part.dissipates() for part in parts)
    ]
    if not bare:
        return
    shown = ", ".join(bare[:3]) + (", ..." if len(bare) > 3 else "")
    nouns = dict.fromkeys(part.noun for name in bare for part in case.holders(name))
    yield Finding(
        "warning",
        case.field_path(bare[0], "radial_damping"),
        f"only meshes damp the motion of the centre of {shown}, along their lines of action: vibration across them, of the start "
        f"for example, does not decay. Give radial_damping, or a damping of its {' and its '.join(nouns)}.",
    )


def _start_shock(case: Case) -> Iterator[Finding]:
    """Compare the torque that a ramp of the driving speed requires with the steady load, both at the driving rotor."""
    names = list(case.rotors)
    _, ratios = rolling.rolling_ratios(case)
    for name, drive in ((name, rotor.drive) for name, rotor in case.rotors.items() if rotor.drive):
        change, time = drive.run_up()
        if case.run.transient >= time:
            continue
        speed, own = abs(drive.nominal_speed() or 0.0), ratios[names.index(name)]
        if own == 0.0:
            continue
        share = np.abs(ratios / own)
        turning = [(share[i], each) for i, each in enumerate(case.rotors.values()) if names[i] != name]
        inertia = sum(each.inertia * ratio**2 for ratio, each in turning)
        steady = sum(
            ratio * (each.load.torque + each.load.friction + each.load.drag * ratio * speed)
            for ratio, each in turning
        )
        shock = inertia * abs(change) / time
        if shock > steady > 0.0:
            least = inertia * abs(change) / steady
            yield Finding(
                "warning",
                f"rotors.{name}.drive.ramp",
                f"the start requires {shock:.4g} N m, {shock / steady:.3g} times the steady {steady:.4g} N m of the load: the "
                f"largest forces are those of the start. Make the ramp longer than {least:.3g} s, or give a transient beyond it.",
            )
