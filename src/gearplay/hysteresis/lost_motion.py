"""`lost_motion` of a case, or of a measured hysteresis curve."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gearplay.hysteresis.balance_path import Train
from gearplay.hysteresis.clearances import check_count, design_of, drawn_cases, parts_of
from gearplay.hysteresis.cycle import Numbers, numbers_of, torque_cycle
from gearplay.hysteresis.held import Held, held
from gearplay.hysteresis.result import LostMotion, dataset_of
from gearplay.hysteresis.slow_run import slow_cycle
from gearplay.hysteresis.torques import positive_of, stages_of
from gearplay.model.case import Case
from gearplay.model.reading import Source, replace
from gearplay.results.provenance import provenance
from gearplay.results.simulate import case_of
from gearplay.vocabulary import quantities as q
from gearplay.vocabulary.errors import NO_VALUE, InputError

if TYPE_CHECKING:
    from collections.abc import Callable

Floats = NDArray[np.float64]

FEW = 2
"""Points of each sign of the torque besides those that the numbers need, where no curve is requested."""


def lost_motion(
    case: Source,
    *,
    at: str | None = None,
    hold: str | Sequence[str] | None = None,
    torque: float | str | None = None,
    stages: Sequence[float | str] | None = None,
    positions: int | None = None,
    members: int | None = None,
    tolerances: Any = None,
    temperatures: Sequence[float | str] | None = None,
    cycles: int = 2,
    quasi_static: bool = True,
    period: float | str = 100.0,
    columns: Sequence[str] | None = None,
    progress: Callable[[str, int, int], None] | None = None,
) -> LostMotion:
    """Return lost motion, backlash and torsional stiffness of a train whose input is held, or of a measured curve.

    The torque on the output goes 0, T_r, -T_r, T_r, so slowly that nothing but springs, contacts and Coulomb friction acts.
    Lost motion is the rotation between the middles of both branches at +3 % and -3 % of T_r, backlash that between the branches
    at no torque.

    Parameters
    ----------
    case
        A `Case`, a bundled name, a path or a mapping; or the path of a measured curve, ``.csv``.
    at
        Rotor that the torque acts on, the output.
    hold
        Rotor that is held, the input, or several. Rotors with a prescribed speed of 0 are held too.
    torque
        Rated torque T_r [N m], or with a unit. Of a measured curve its largest torque, unless given.
    stages
        Torques that end the stages K1 and K2 of the stiffness; 0.14 T_r and 0.48 T_r by default.
    positions
        Number of positions over a turn of the output at which the numbers are computed too.
    members
        Number of drawn members.
    tolerances
        What scatters: a sweep plan with a ``[design]``, or such a table with ``parameters``. By default each clearance, uniform
        within 20 % of its value.
    temperatures
        Temperatures of the environment [K], or with a unit.
    cycles
        Cycles of the torque, of which the last one counts.
    quasi_static
        Whether equilibria are computed; else a motion is simulated under a sinusoidal torque, with damping and inertia.
    period
        Period of that torque [s].
    columns
        Of a measured curve the names of the columns of torque and rotation, each perhaps with a unit: ``"T [N m]", "phi [deg]"``.
    progress
        Called with what is computed, how many are done, and of how many.

    Returns
    -------
    LostMotion
        ``.ds`` with ``lost_motion`` and ``backlash`` [rad] and [arcmin], ``stiffness`` (stage), ``torsional_stiffness``,
        ``hysteresis_loss``, the curve ``angle`` (branch, torque), ``lost_motion_part`` (clearance); the numbers over positions,
        members and temperatures; of a measured curve with intervals.

    Raises
    ------
    InputError
        For rotors that do not hold the train, invalid torques, or an invalid file.
    SimulationError
        Where no equilibrium is found.

    Examples
    --------
    >>> import gearplay as gp
    >>> found = gp.lost_motion("two-stage-reducer", at="output", hold="input", torque="50 N m")
    >>> round(float(found.ds["lost_motion_arcmin"]), 3)
    7.077

    """
    if columns is not None or _is_record(case):
        from gearplay.hysteresis.measured import measured_lost_motion

        return measured_lost_motion(case, columns, torque=torque, stages=stages)
    for field, given in (("at", at), ("hold", hold), ("torque", torque)):
        if given is None:
            rule = "is required of a case"
            raise InputError.of(field, NO_VALUE, rule, "Name output and input, and give the rated torque")
    assert at is not None
    assert hold is not None
    base = case_of(case)
    rated = positive_of("torque", torque, q.TORQUE)
    ends = stages_of(stages, rated)
    whole = held(base, at, hold)
    _check_friction(whole, ends[0])
    check_count("positions", positions)
    study = _Study(at, hold, rated, ends, cycles, progress)
    if quasi_static:
        curve = torque_cycle(Train(whole), rated, ends, cycles=cycles)
        parts = parts_of(Train(whole), rated)
    else:
        curve, parts = slow_cycle(whole, rated, cycles, positive_of("period", period, q.TIME)), {}
    found = numbers_of(curve, rated, ends)
    more: dict[str, tuple[Any, list[Numbers]]] = {}
    if positions is not None:
        more["position"] = study.over_turn(whole, positions)
    design = design_of(tolerances, base, members)
    if design is not None:
        more["member"] = study.over_cases("members", drawn_cases(design, base))
    if temperatures is not None:
        kelvin = [
            positive_of(f"temperatures.{k}", each, q.TEMPERATURE) for k, each in enumerate(temperatures)
        ]
        _, rows = study.over_cases("temperatures", [_at_temperature(base, each) for each in kelvin])
        more["temperature"] = np.array(kelvin), rows
    scatter = "" if design is None else _scatter_words(tolerances)
    attributes = provenance(
        base, at=at, hold=" ".join(whole.hold), rated_torque=rated, quasi_static=int(quasi_static), scatter=scatter
    )  # fmt: skip
    return LostMotion(dataset_of(curve, found, ends, rated, parts, more, attributes))


class _Study:
    """The same numbers of several systems."""

    def __init__(
        self,
        at: str,
        hold: str | Sequence[str],
        rated: float,
        ends: Sequence[float],
        cycles: int,
        progress: Any,
    ) -> None:
        self.at, self.hold, self.rated, self.ends, self.cycles = at, hold, rated, ends, cycles
        self.progress = progress or (lambda *_: None)

    def _numbers(self, whole: Held, turn: float = 0.0) -> Numbers:
        curve = torque_cycle(Train(whole, turn), self.rated, self.ends, cycles=self.cycles, points=FEW)
        return numbers_of(curve, self.rated, self.ends)

    def over_turn(self, whole: Held, count: int) -> tuple[Floats, list[Numbers]]:
        if not np.any(whole.ratios):
            rule = f"must be left out, since {self.at} does not turn: a torsional spring or a held rotor keeps it"
            raise InputError.of("positions", count, rule, "Leave it out, or let the output turn")
        turns, rows = 2.0 * np.pi * np.arange(count) / count, []
        for k, turn in enumerate(turns.tolist()):
            rows.append(self._numbers(whole, turn))
            self.progress("positions", k + 1, count)
        return turns, rows

    def over_cases(self, what: str, cases: Sequence[Case]) -> tuple[Floats, list[Numbers]]:
        rows = []
        for k, each in enumerate(cases):
            rows.append(self._numbers(held(each, self.at, self.hold)))
            self.progress(what, k + 1, len(cases))
        return np.arange(float(len(cases))), rows


def _check_friction(whole: Held, first: float) -> None:
    """Refuse stages that begin within the friction of the train, where play and springs cannot be separated."""
    places = {name: i for i, name in enumerate(whole.source.rotors)}
    mine = [i for name, i in places.items() if name not in whole.hold]
    friction = float(np.sum(whole.friction[mine] * np.abs(whole.ratios[mine])))
    if friction >= first:
        rule = f"must be above the friction of the train at {whole.at}, {friction:.4g} N m"
        cure = "Raise the first stage or the rated torque, or lower the friction"
        raise InputError.of("stages.0", f"{first:.4g} N m", rule, cure)


def _at_temperature(case: Case, kelvin: float) -> Case:
    if case.environment is None:
        return replace(case, {"environment": {"temperature": kelvin}})
    return replace(case, {"environment.temperature": kelvin})


def _scatter_words(tolerances: Any) -> str:
    return "each clearance within 20 % of its value" if tolerances is None else "the given tolerances"


def _is_record(case: Any) -> bool:
    return (
        isinstance(case, (str, os.PathLike))
        and not isinstance(case, Mapping)
        and str(case).lower().endswith(".csv")
    )
