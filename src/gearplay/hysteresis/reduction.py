"""`reduce`: a train as one elastic joint with backlash, for robot simulators and system models."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from gearplay.hysteresis.balance_path import Train
from gearplay.hysteresis.clearances import design_of, drawn_cases
from gearplay.hysteresis.cycle import ARCMIN, LINEAR, half_width_of
from gearplay.hysteresis.held import Held, held
from gearplay.hysteresis.snippets import modelica_text, mujoco_text, urdf_text
from gearplay.hysteresis.torques import positive_of
from gearplay.model.reading import Source
from gearplay.parts.mesh.train import geometry
from gearplay.results.base import OfDataset
from gearplay.results.provenance import provenance
from gearplay.results.simulate import case_of
from gearplay.vocabulary import quantities as q
from gearplay.vocabulary.errors import NO_VALUE, InputError

if TYPE_CHECKING:
    from matplotlib.figure import Figure


QUANTITIES = {
    "inertia": ("kg m^2", "inertia behind the spring, seen at the output"),
    "input_inertia": (
        "kg m^2",
        "inertia ahead of the spring, seen at the output: of the rolling train less that behind the spring",
    ),
    "half_width": ("rad", "half of the backlash"),
    "stiffness": ("N m/rad", "torsional stiffness"),
    "damping": ("N m s/rad", "torsional damping in contact"),
    "friction": ("N m", "Coulomb friction of the turning train, seen at the output"),
}
"""Unit and long name of each number."""
ROUNDING = 1e-9
"""Spread over members, of the value, that is rounding and not shown."""


@dataclass(frozen=True, repr=False)
class Reduction(OfDataset):
    """One joint in place of a train: two inertias, backlash with stiffness and damping between them, friction.

    ``ds``: ``inertia``, ``input_inertia`` [kg m^2], ``half_width`` [rad], ``stiffness`` [N m/rad], ``damping`` [N m s/rad],
    ``friction`` [N m], all at the output; with members also ``..._by_member`` (member) and ``..._spread``, the standard
    deviation.
    """

    result_kind = "reduction"

    def value(self, name: str) -> float:
        """Return a number of the nominal train [SI]."""
        return float(self.dataset[name])

    @property
    def message(self) -> str:
        """The numbers of the joint as text."""
        return "; ".join(f"{name.replace('_', ' ')} {text}" for name, text in self.rows())

    def rows(self) -> Sequence[tuple[str, str]]:
        """Return each number with its spread over members."""
        found = []
        for name, (unit, _) in QUANTITIES.items():
            value = self.value(name)
            scatter = float(self.dataset.get(f"{name}_spread", 0.0))
            spread = f" ± {scatter:.3g}" if scatter > ROUNDING * abs(value) else ""
            more = f" = {value * ARCMIN:.4g} arcmin" if unit == "rad" else ""
            found.append((name, f"{value:.6g}{spread} {unit}{more}"))
        return found

    def mujoco(self, name: str = "joint") -> str:
        """Return an MJCF snippet: a hinge with the input's inertia, and a second one whose soft limits are the play."""
        return mujoco_text(self._numbers(), name)

    def urdf(self, name: str = "joint") -> str:
        """Return a URDF snippet with the joint's friction; URDF has neither play nor stiffness, which are a comment."""
        return urdf_text(self._numbers(), name)

    def modelica(self, name: str = "Joint") -> str:
        """Return a Modelica model of two inertias with ``ElastoBacklash`` between them."""
        return modelica_text(self._numbers(), name)

    def _numbers(self) -> dict[str, float]:
        return {name: self.value(name) for name in QUANTITIES}

    def plot(self) -> Figure:
        """Draw the joint's torque over its rotation, and the drawn members; return the figure."""
        from gearplay.hysteresis.figures import reduction_drawing

        drawn: Figure = reduction_drawing(self.dataset)
        return drawn


def reduce(
    case: Source,
    *,
    at: str,
    hold: str | Sequence[str],
    torque: float | str | None = None,
    members: int | None = None,
    tolerances: Any = None,
) -> Reduction:
    """Return a train as one joint: inertias, half width of its play, stiffness, damping and friction, at the output.

    Stiffness is the secant from 15 % to 100 % of the torque, both signs; the inertia behind the spring that of the static
    deflection (Rayleigh), that ahead of it what the rolling train has besides, so that both together are the train's; the
    damping that of the same deflection at the full torque; friction that of all rotors as the train
    rolls, without the held ones.

    Parameters
    ----------
    case
        A `Case`, a bundled name, a path or a mapping.
    at
        The output, whose coordinate the joint has.
    hold
        The input, or several rotors that are held.
    torque
        Rated torque [N m], or with a unit; the load torque of the output if not given.
    members, tolerances
        Drawn members for the spread, as of `lost_motion`.

    Returns
    -------
    Reduction
        ``.ds``, and ``mujoco()``, ``urdf()``, ``modelica()``.

    Raises
    ------
    InputError
        For rotors that do not hold the train, or without a torque.
    SimulationError
        Where no equilibrium is found.

    Examples
    --------
    >>> import gearplay as gp
    >>> joint = gp.reduce("two-stage-reducer", at="output", hold="input")
    >>> round(joint.value("half_width") * 60 * 180 / 3.141592653589793, 3)
    3.505
    >>> "range=" in joint.mujoco()
    True

    """
    base = case_of(case)
    whole = held(base, at, hold)
    given = base.rotors[at].load.torque if torque is None else torque
    if given == 0.0:
        rule = "is required, since the output has no load torque"
        raise InputError.of("torque", NO_VALUE, rule, "Give the rated torque")
    rated = positive_of("torque", given, q.TORQUE)
    found = _joint(whole, rated)
    design = design_of(tolerances, base, members)
    rows = (
        [] if design is None else [_joint(held(each, at, hold), rated) for each in drawn_cases(design, base)]
    )
    attributes = provenance(base, at=at, hold=" ".join(whole.hold), rated_torque=rated)
    return Reduction(_dataset(found, rows, attributes))


def _joint(whole: Held, rated: float) -> dict[str, float]:
    train = Train(whole)
    half = half_width_of(train, rated)
    train.friction = {}
    twist, damping, inertia = 0.0, [], []
    for sign in (1.0, -1.0):
        train.reset()
        high = train.load(sign * rated)
        shape = train.shape()
        shape = shape / shape[train.out]
        matrix = train.linear.matrix()
        damping.append(float(shape @ train.linear.damping(matrix) @ shape))
        inertia.append(float(shape @ (train.linear.mass * shape)))
        twist += sign * (high - train.load(sign * LINEAR * rated))
    names = list(whole.source.rotors)
    ratios = np.abs(whole.ratios)
    inputs = [names.index(name) for name in whole.hold]
    others = [i for i in range(len(names)) if i not in inputs]
    return {
        "inertia": float(np.mean(inertia)),
        "input_inertia": max(0.0, _rolling_inertia(whole) - float(np.mean(inertia))),
        "half_width": half,
        "stiffness": 2.0 * (1.0 - LINEAR) * rated / twist,
        "damping": float(np.mean(damping)),
        "friction": float(np.sum(whole.friction[others] * ratios[others])),
    }


def _rolling_inertia(whole: Held) -> float:
    """Return the inertia of the train as it rolls, input and output included, seen at the output [kg m^2].

    Rotors that a carrier holds move with it, too.
    """
    hot, ratios = whole.source.operating, whole.ratios
    names, centres, total = list(hot.rotors), geometry.centres(hot), 0.0
    for i, (name, rotor) in enumerate(hot.rotors.items()):
        total += rotor.inertia * float(ratios[i]) ** 2
        carrier = geometry.carrier_of(hot, name)
        if carrier is not None:
            arm = math.dist(centres[name], centres[carrier])
            total += rotor.mass * (arm * float(ratios[names.index(carrier)])) ** 2
    return total


def _dataset(found: dict[str, float], rows: list[dict[str, float]], attributes: dict[str, Any]) -> Any:
    import xarray as xr

    variables: dict[str, Any] = {}
    for name, (unit, words) in QUANTITIES.items():
        variables[name] = ((), found[name], {"units": unit, "long_name": words})
        if rows:
            values = np.array([row[name] for row in rows])
            spread = float(np.std(values, ddof=1)) if values.size > 1 else 0.0
            variables[f"{name}_by_member"] = (
                ("member",),
                values,
                {"units": unit, "long_name": f"{words}, by member"},
            )
            variables[f"{name}_spread"] = (
                (),
                spread,
                {"units": unit, "long_name": f"{words}, standard deviation"},
            )
    return xr.Dataset(variables, attrs=attributes)
