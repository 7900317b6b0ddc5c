"""Characteristic frequencies of a pair of gears: mesh, rotation of both gears, sidebands, hunting tooth."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from gearplay.parts.mesh.train import rolling
from gearplay.parts.mesh.train.geometry import full_name, mesh_frame, rotor_of, teeth_of

if TYPE_CHECKING:
    from gearplay.parts.mesh.train.train import Train


@dataclass(frozen=True)
class MeshFrequencies:
    """Frequencies [Hz] of a pair of gears at nominal speed.

    Parameters
    ----------
    mesh
        f_m, teeth in mesh per second; 0 where the pair does not roll.
    shafts
        |f| of both gears by their full names, driver first: turns per second against the ground.
    rotations
        f_m / z of both gears: turns per second in the frame in which the pair rolls, the carrier's of a planet mesh. An
        error that a gear carries comes with it and modulates f_m by it.
    hunting_tooth
        f_m gcd(z_1, z_2) / (z_1 z_2), at which the same two teeth meet again.
    mesh_periods
        z_1 z_2 / gcd(z_1, z_2), mesh periods until the same two teeth meet again.

    R. B. Randall, Vibration-based Condition Monitoring, 2nd ed., Wiley 2021, section 2.2.2.

    """

    mesh: float
    shafts: dict[str, float]
    rotations: dict[str, float]
    hunting_tooth: float
    mesh_periods: int

    @property
    def common_period(self) -> float:
        """Time [s] after which the same two teeth meet again; infinite where the pair does not roll."""
        return 1.0 / self.hunting_tooth if self.hunting_tooth > 0.0 else math.inf

    @property
    def sidebands(self) -> dict[str, tuple[float, float]]:
        """First pair of sidebands of f_m [Hz] of each gear, below and above, by its name."""
        return {name: (self.mesh - f, self.mesh + f) for name, f in self.rotations.items()}


def mesh_frequencies(case: Train, j: int) -> MeshFrequencies:
    """Return the characteristic frequencies of mesh j; `InputError` where prescribed speeds contradict each other."""
    mesh, names = case.meshes[j], list(case.rotors)
    speeds, f_m = rolling.nominal_speeds(case), rolling.mesh_frequency(case, j)
    gears = {full_name(case, name): teeth_of(case, name) for name in (mesh.driver, mesh.driven)}
    turns = {
        full_name(case, name): abs(float(speeds[names.index(rotor_of(case, name))])) / (2.0 * math.pi)
        for name in (mesh.driver, mesh.driven)
    }
    periods = math.lcm(*gears.values())
    return MeshFrequencies(f_m, turns, {name: f_m / z for name, z in gears.items()}, f_m / periods, periods)


def rolling_frame(case: Train, j: int) -> str | None:
    """Return the carrier in whose frame mesh j rolls where it turns, else None."""
    frame = mesh_frame(case, j)
    if frame is None or rolling.nominal_speeds(case)[list(case.rotors).index(frame)] == 0.0:
        return None
    return frame
