"""Independent reference simulator: the equations of the conventions page, written out plainly.

The reference shares no code with the package.  It favours readability and accuracy over speed: the
eighth-order Dormand-Prince method with a relative tolerance of 1e-13, and every change of a contact (or of
any other branch of a formula) is a located event at which the integration stops and starts again.

All quantities are SI: m, kg, s, N, rad.  The state vector is ``x, y, theta_rel`` of all rotors (rotor by
rotor), then ``vx, vy, omega_rel`` of all rotors, then one integral (rad) per servo.  ``theta_rel`` is
``theta - Omega t`` with the constant nominal speed ``Omega``.

The case dictionary
-------------------
``rotors``
    name -> ``mass``, ``inertia``, optional ``teeth``, ``internal``, ``position`` [x, y], ``floating``,
    ``radial_damping``, ``initial`` {x, y, theta, vx, vy, omega}, ``runout`` {amplitude, phase},
    ``drive``, ``load`` {torque, drag, friction, friction_speed, terms}, ``unbalance`` {amount, phase}.
    Drives: ``{kind: speed, speed, ramp, ripple: [{order, amplitude, phase}]}``,
    ``{kind: torque, torque, terms}``,
    ``{kind: servo, speed, proportional_gain, integral_gain, torque_limit, ramp}`` (``torque_limit`` and
    ``ramp`` optional) and ``{kind: position, angle, proportional_gain, derivative_gain, integral_gain,
    torque_limit, sensor, sample_time}`` (the first two are needed).
    Terms: ``[{frequency or order, amplitude, phase}]``.
``sleeves``
    name of the journal's rotor -> ``radial_clearance``, ``law``, ``stiffness``, ``exponent``,
    ``restitution``, ``minimum_impact_speed``, optional ``on``, ``offset``, ``friction_coefficient``,
    ``friction_speed``, ``shaft_radius``, ``rotor_side``, ``bed_exponent``, ``bed_reference_penetration``.
``supports``
    name of the rotor -> ``stiffness`` [kx, ky], ``damping`` [cx, cy], ``torsional_stiffness``,
    ``torsional_damping``, ``on``, ``offset``; all optional.  A stiffness frees the centre.
``bearings``
    name of the rotor -> the table of a rolling bearing (`cross.reference_bearings`).
``couplings``
    list of ``between`` [one, two], ``torsional_stiffness`` and, optional, ``torsional_damping``, ``play``,
    ``ratio``, ``lateral_stiffness``, ``lateral_damping``.
``base``
    ``acceleration`` {kind: harmonic, amplitude, frequency, phase, direction} or {kind: half-sine, amplitude,
    duration, start, direction}, or any object with a method ``at(t)`` that returns (ax, ay).
``meshes``
    list of ``driver``, ``driven``, ``module``, ``pressure_angle``, ``backlash``, ``stiffness``,
    ``damping`` {maximum, depth}, ``transmission_error`` [{order, amplitude, phase}] and, optional,
    ``phase``, ``friction_coefficient``, ``friction_phase``, ``friction_speed`` (`cross.reference_friction`).
    Stiffness: ``{kind: harmonic, mean, amplitude, phase}``,
    ``{kind: square, single, double, contact_ratio, phase}``,
    ``{kind: fourier, mean, terms: [{order, amplitude, phase}]}``,
    ``{kind: table, phase: [...], stiffness: [...]}`` (points inside one period of 2 pi).
``gravity``, ``formulation``, ``backlash_model``, ``mesh_phases``
    as in the case file; the phases by position are those of `cross.reference_planets`.

An object with these names as attributes is taken too (`cross.reference_laws.plain`).

Choices where the conventions leave room
----------------------------------------
* *Transmission error and the driver's torque.*  ``e`` depends on the driver's rotation.  "-F dp/dq" read to
  the letter gives the driver the additional torque ``-(F_d - F_b) z e'(psi)``; the torques printed as
  ``r_b (F_d - F_b)`` do not have it.  It is left out (``e`` is treated like ``K(psi)``, as a parametric
  excitation: linear and angular momentum of a free pair are conserved, the energy is not).  ``dp/dt`` always
  contains ``de/dt``.
* *Square stiffness*: the double-contact value holds for ``0 <= psi + phase < 2 pi (contact_ratio - 1)``
  (modulo 2 pi), the single-contact value for the rest.
* *Runout* displaces the centre of the toothing everywhere a mesh uses centres: ``A``, ``phi``, and ``d`` of
  ``uncoupled`` and ``as_published``.
* *as_published*: the damping force is ``C(|f_g|) dg/dt`` (the rate of ``g``, also on the back branch, where
  ``f_g`` also changes with ``b_t``).  The force is not clipped, it may pull.  It is reported as ``F_d = F_t``
  on the drive branch and ``F_b = -F_t`` on the back branch; ``p_d = g`` and ``p_b = -g - b_t``.
* *Senses* are those of the nominal speeds; where these are all 0, the sense that the first torque or angle of
  a drive, or else the first ``initial.omega``, gives the train by rolling.  *load.torque* and *load.terms*
  need one and are refused without; flanks take +1 then.  Gears on a carrier that has a nominal speed take the
  sense of turning against it.
* *A sample* of a servo at a time of output counts before the output: its accelerations are those just after.
* *Prescribed speed*: ``initial.theta`` adds to the prescribed angle, ``initial.omega`` is ignored.
* *Ripple*: the prescribed angular acceleration is integrated like any other; the run starts at the speed
  of the ripple's phases, all other rotors at their nominal speed.
* *Ramps*: with a positive ramp in any drive all rotors start at rest unless ``initial`` says otherwise.
* A sleeve that is already closed at the start latches the speed it then has.
* *Gears on a carrier* roll in its frame, whatever its speed.  The one line of action of ``uncoupled`` and
  ``as_published`` is fixed in the carrier, and each flank turns the carrier by ``-F dp/dtheta_c``.
* *Radial damping* of a rotor on a carrier acts between its centre and its pin, the reaction at the pin.
* *Tangential friction* acts at one point, on the surface of the journal, which with ``rotor_side`` "bush" is that of
  the carrier or the ground.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.integrate import DOP853
from scipy.interpolate import CubicHermiteSpline
from scipy.optimize import brentq, minimize_scalar

from cross.reference_bearings import Bearing, bearing_of
from cross.reference_friction import ToothFriction, about, pitch_point, sliding, tooth_friction_of
from cross.reference_laws import (
    Base,
    Body,
    Coupling,
    Pair,
    PositionServo,
    Support,
    Term,
    accelerations,
    base_of,
    coupling_of,
    pair,
    plain,
    position_servo_of,
    terms_of,
    turned,
)
from cross.reference_laws import number as _number
from cross.reference_planets import Condition, Teeth, phases_by_position, speeds_on_carriers

Key = tuple[str, int, str]
TWO_PI = 2.0 * math.pi
MIN_TIME_STEP = 1e-16  # s: a shorter way to a stop is taken in one linear step
LENGTH_TOLERANCE = 1e-16  # m: an indicator of length has left zero beyond this
ANGLE_TOLERANCE = 1e-15  # rad: same, for the ends of a coupling's play
SLIDING_TOLERANCE = 1e-9  # of the sliding of teeth over its speed, a difference of much larger velocities
RATIO_TOLERANCE = 1e-12  # same, for the dimensionless indicators
PUSH_TOLERANCE = 1e-9  # same, for F / (K p) of a flank: the rounding of p (1e-17 m) over p


def involute(angle: float) -> float:
    """Return inv(angle) = tan(angle) - angle (rad)."""
    return math.tan(angle) - angle


def law_factor(law: str, restitution: float) -> float:
    """Return the dimensionless damping factor ``a`` of a contact law for a coefficient of restitution."""
    e = restitution
    if law in ("lankarani-nikravesh", "conformal"):
        return 3.0 * (1.0 - e**2) / 4.0
    if law == "hunt-crossley":
        return 3.0 * (1.0 - e) / 2.0
    if law == "flores":
        return 8.0 * (1.0 - e) / (5.0 * e)
    if law == "gonthier":
        return (1.0 - e**2) / e
    raise ValueError(f"unknown contact law {law!r}")


class WinklerBed:
    """Conformal contact: radial springs over the contact angle of a bush and a journal.

    ``radius`` (m) is the shaft's radius and ``clearance`` (m) the radius difference.  ``scale`` is chosen
    such that the force at the penetration ``reference`` (m) is ``stiffness * reference ** exponent`` (N).
    """

    def __init__(
        self,
        radius: float,
        clearance: float,
        bed_exponent: float,
        stiffness: float,
        exponent: float,
        reference: float,
        points: int = 40,
    ) -> None:
        self.radius = radius
        self.clearance = clearance
        self.bed_exponent = bed_exponent
        # theta = theta0 sin(xi), 0 <= xi <= pi/2: smooth although delta(theta)^n has a branch at theta0
        nodes, weights = np.polynomial.legendre.leggauss(points)
        xi = 0.25 * math.pi * (nodes + 1.0)
        self._angle_ratio = np.sin(xi)
        self._weight = 0.25 * math.pi * weights * np.cos(xi)
        self.scale = 1.0
        self.scale = stiffness * reference**exponent / self.elastic(reference)

    def contact_angle(self, penetration: float) -> float:
        """Return the half contact angle theta0 (rad) where the penetration vanishes."""
        big = self.radius + self.clearance
        offset = self.clearance + penetration
        cosine = (big**2 + offset**2 - self.radius**2) / (2.0 * big * offset)
        return math.acos(min(1.0, max(-1.0, cosine)))

    def depth(self, theta: NDArray[np.float64], penetration: float) -> NDArray[np.float64]:
        """Return the local penetration delta(theta) (m), never negative."""
        big = self.radius + self.clearance
        offset = self.clearance + penetration
        distance = np.sqrt(big**2 + offset**2 - 2.0 * big * offset * np.cos(theta))
        return np.maximum(self.radius - distance, 0.0)

    def elastic(self, penetration: float) -> float:
        """Return the elastic force (N) at the largest penetration (m)."""
        if penetration <= 0.0:
            return 0.0
        theta0 = self.contact_angle(penetration)
        theta = theta0 * self._angle_ratio
        values = self.depth(theta, penetration) ** self.bed_exponent * np.cos(theta)
        return 2.0 * self.scale * theta0 * float(self._weight @ values)


@dataclass(slots=True)
class _Rotor:
    name: str
    mass: float
    inertia: float
    position: tuple[float, float]
    nominal_speed: float  # rad/s
    movable: bool  # the centre may move
    radial_damping: float  # N s/m
    drive: str  # "", "speed", "torque", "servo", "position"
    speed: float  # rad/s, prescribed or target
    ramp: float  # s
    torque: float  # N m, constant: drive torque and -load torque
    drag: float  # N m s/rad
    friction: float  # N m
    friction_speed: float  # rad/s
    kp: float = 0.0  # N m s/rad
    ki: float = 0.0  # N m/rad
    limit: float = math.inf  # N m
    servo: int = -1  # number of the servo's integral in the state
    ripple: tuple[tuple[float, float, float], ...] = ()  # order, relative amplitude, phase
    terms: tuple[Term, ...] = ()  # of drive and load, counter-clockwise positive
    unbalance: float = 0.0  # kg m
    unbalance_phase: float = 0.0  # rad
    position_servo: PositionServo | None = None


@dataclass(slots=True)
class _Sleeve:
    name: str
    journal: int
    carrier: int  # -1: ground
    clearance: float  # m
    law: str
    stiffness: float
    exponent: float
    factor: float  # dimensionless a
    minimum_speed: float  # m/s
    bush: tuple[float, float]  # bush centre relative to the carrier's centre at its rotation 0, m
    offset: tuple[float, float]  # bush centre beside the journal's nominal centre at that rotation, m
    friction: float
    friction_speed: float  # m/s
    shaft_radius: float  # m
    outside: bool  # the rotor is the bush around a journal of the carrier
    bed: WinklerBed | None


def _monotone_slopes(x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the slopes of a periodic shape-preserving cubic at its points, the last of which is the first (T8a)."""
    h, rise = np.diff(x), np.diff(y) / np.diff(x)
    before, after = np.roll(h, 1), h
    d_1, d_2 = np.roll(rise, 1), rise
    slopes = np.zeros_like(h)
    on = d_1 * d_2 > 0.0
    w_1, w_2 = 2.0 * after[on] + before[on], after[on] + 2.0 * before[on]
    slopes[on] = (w_1 + w_2) / (w_1 / d_1[on] + w_2 / d_2[on])
    return np.append(slopes, slopes[0])


@dataclass(slots=True)
class _Mesh:
    label: str
    a: int  # rotor at the foot of the vector of centres
    b: int  # rotor at its tip
    driver: int
    teeth: int  # of the driver
    arm_a: tuple[float, float]  # eccentricity of the toothing, m, and where it points at theta = 0, rad
    arm_b: tuple[float, float]
    s: float
    sigma: float
    rho_a: float  # signed base (as_published: pitch) radii, m
    rho_b: float
    c0: float  # m
    alpha0: float
    inv0: float
    u0: tuple[float, float]
    v0: tuple[float, float]  # nominal vector of centres, m
    backlash: float
    damping: float  # N s/m
    depth: float  # m
    error: tuple[tuple[float, float, float], ...]  # order, amplitude, phase
    kind: str
    mean: float  # N/m, also the scale of the separation indicator
    terms: tuple[tuple[float, float, float], ...]  # cosine terms: order, amplitude, phase
    single: float = 0.0
    double: float = 0.0
    share: float = 0.0  # angle of double contact, rad
    phase: float = 0.0
    spline: CubicHermiteSpline | None = None
    frame: int | None = None  # carrier of either gear
    psi0: float = 0.0  # phase where nothing has turned yet, rad


@dataclass(slots=True)
class _MeshMotion:
    psi: float
    p_d: float  # m; g of as_published
    rate_d: float  # m/s
    p_b: float
    rate_b: float
    b_t: float
    rate_b_t: float
    distance: float
    alpha: float
    grad_d: tuple[float, float]  # dp_d / d(centre of b); minus this for the centre of a
    grad_b: tuple[float, float]
    arm_a: tuple[float, float]  # toothing's centre relative to the shaft's centre
    arm_b: tuple[float, float]
    by_frame: float = 0.0  # dp_d / d(theta of the carrier) = -dp_b / d(theta of the carrier), m


@dataclass(slots=True)
class _SleeveMotion:
    ux: float
    uy: float
    delta: float
    rate: float
    slip: float  # tangential speed of the rotor's surface against the other at the contact, m/s
    levers: tuple[float, float]  # of the contact along u about the centres of rotor and seat, m
    arm: tuple[float, float]  # bush centre relative to the carrier's centre
    velocity: tuple[float, float]  # of the journal's centre against the bush's, m/s


def _rotor_name(gear: str) -> str:
    return gear.partition(".")[0]


def _gear(rotors: Mapping[str, Any], name: str) -> Mapping[str, Any]:
    """Table of a gear called ``rotor`` or ``rotor.gear``."""
    rotor, _, gear = name.partition(".")
    gears = rotors[rotor].get("gears") or {}
    found: Mapping[str, Any] = gears[gear] if gear else next(iter(gears.values()), rotors[rotor])
    return found


def _runout(gear: Mapping[str, Any]) -> tuple[float, float]:
    runout = gear.get("runout") or {}
    return _number(runout, "amplitude"), _number(runout, "phase")


def _root(function: Callable[[float], float], begin: float, end: float) -> float:
    """Return where a function that is positive at ``begin`` and negative at ``end`` crosses zero."""
    if function(begin) <= 0.0:
        return begin
    if function(end) >= 0.0:
        return end
    return float(brentq(function, begin, end, xtol=1e-20))


class Reference:
    """Simulate one resolved case (see the module's docstring for its form).

    ``relative_tolerance`` (the absolute ones go with it) and ``max_step`` (s) govern the integration.
    ``events`` lists (time, indicator, new sign) of the last trajectory.
    """

    def __init__(
        self,
        case: Any,
        *,
        relative_tolerance: float = 1e-13,
        max_step: float = 2e-5,
    ) -> None:
        case = plain(case)
        self.case = case
        self.formulation = case.get("formulation", "geometric")
        self.coupled = case.get("backlash_model", "coupled") == "coupled"
        self.published = self.formulation == "as_published"
        self.relative_tolerance = relative_tolerance
        self.max_step = max_step
        gravity = case.get("gravity") or (0.0, 0.0)
        self.gravity = (float(gravity[0]), float(gravity[1]))
        self.names: list[str] = list(case["rotors"])
        self.index = {name: i for i, name in enumerate(self.names)}
        mesh_tables: Sequence[Mapping[str, Any]] = case.get("meshes") or []
        sleeve_tables: Mapping[str, Mapping[str, Any]] = case.get("sleeves") or {}
        positions = self._place(case["rotors"], mesh_tables)
        self.carriers = self._carriers()
        speeds = self._nominal_speeds(case["rotors"])
        self.senses = self._senses(case["rotors"], speeds)
        self.rotors = self._build_rotors(case["rotors"], sleeve_tables, positions, speeds)
        self.servos = [i for i, r in enumerate(self.rotors) if r.servo >= 0]
        self.meshes = [self._build_mesh(table) for table in mesh_tables]
        self.sleeves = [self._build_sleeve(name, table) for name, table in sleeve_tables.items()]
        self.supports = [self._build_support(name, table) for name, table in self._tables("supports").items()]
        self.bearings = [self._build_bearing(name, table) for name, table in self._tables("bearings").items()]
        self.couplings = [coupling_of(table, self.index) for table in case.get("couplings") or ()]
        self.base: Base | None = base_of(case.get("base"))
        self._set_phases(case["rotors"], mesh_tables)
        self.tooth_friction = [
            self._build_tooth_friction(table, mesh)
            for table, mesh in zip(mesh_tables, self.meshes, strict=True)
        ]
        self.n = len(self.rotors)
        size = 6 * self.n + len(self.servos)
        tolerance = np.empty(size)
        for i in range(self.n):
            tolerance[3 * i : 3 * i + 3] = (1e-17, 1e-17, 1e-16)
            tolerance[3 * (self.n + i) : 3 * (self.n + i) + 3] = (1e-13, 1e-13, 1e-12)
        tolerance[6 * self.n :] = 1e-16
        self.absolute_tolerance = tolerance * (relative_tolerance / 1e-13)
        self.signs: dict[Key, float] = {}
        self.impact_speeds = [s.minimum_speed for s in self.sleeves]
        self.events: list[tuple[float, Key, float]] = []
        self.steps = 0
        self._armed: set[Key] = set()
        self._step_size = 1e-7
        self._segment_start = 0.0
        self.held: dict[int, float] = {}  # torque of a sampled servo until its next sample, N m
        self._pending: dict[int, float] = {}  # what its integral gains by then, rad

    # ------------------------------------------------------------------ building

    def _tables(self, name: str) -> Mapping[str, Any]:
        found: Mapping[str, Any] = self.case.get(name) or {}
        return found

    @staticmethod
    def _is_internal(rotors: Mapping[str, Any], mesh: Mapping[str, Any]) -> bool:
        return any(_gear(rotors, mesh[role]).get("internal") for role in ("driver", "driven"))

    def _ends(self, rotors: Mapping[str, Any], mesh: Mapping[str, Any]) -> tuple[str, str]:
        """Names of the gears at the foot and at the tip of the vector of centres."""
        driver, driven = mesh["driver"], mesh["driven"]
        if _gear(rotors, driven).get("internal"):
            return driven, driver
        return driver, driven

    def _place(
        self, rotors: Mapping[str, Any], meshes: Sequence[Mapping[str, Any]]
    ) -> dict[str, tuple[float, float]]:
        placed: dict[str, tuple[float, float]] = {}
        for name, table in rotors.items():
            if table.get("position") is not None:
                placed[name] = (float(table["position"][0]), float(table["position"][1]))
        self._share_axes(placed)
        if meshes and not {_rotor_name(meshes[0][role]) for role in ("driver", "driven")} & placed.keys():
            placed[_rotor_name(self._ends(rotors, meshes[0])[0])] = (0.0, 0.0)
        for _ in meshes:
            for mesh in meshes:
                self._share_axes(placed)
                foot, tip = map(_rotor_name, self._ends(rotors, mesh))
                distance = self._nominal_distance(rotors, mesh)
                inner = self._is_internal(rotors, mesh)
                if mesh.get("angle") is not None:
                    one, two = _rotor_name(mesh["driver"]), _rotor_name(mesh["driven"])
                    way = (distance * math.cos(mesh["angle"]), distance * math.sin(mesh["angle"]))
                    if one in placed and two not in placed:
                        placed[two] = (placed[one][0] + way[0], placed[one][1] + way[1])
                    elif two in placed and one not in placed:
                        placed[one] = (placed[two][0] - way[0], placed[two][1] - way[1])
                elif foot in placed and tip not in placed:
                    placed[tip] = (placed[foot][0] + distance, placed[foot][1])
                elif tip in placed and foot not in placed:
                    step = -distance if inner else distance
                    placed[foot] = (placed[tip][0] + step, placed[tip][1])
        for name in rotors:
            self._share_axes(placed)
            parts = [self._tables(table).get(name) or {} for table in ("supports", "bearings")]
            on = next((part["on"] for part in parts if part.get("on")), None)
            placed.setdefault(name, placed.get(on, (0.0, 0.0)))
        return placed

    def _share_axes(self, placed: dict[str, Pair]) -> None:
        """Give the place of a rotor to those that a coupling of ratio 1 puts on its axis."""
        links = [c["between"] for c in self.case.get("couplings") or () if _number(c, "ratio", 1.0) == 1.0]
        for _ in links:
            for one, two in links:
                for known, other in ((one, two), (two, one)):
                    if known in placed:
                        placed.setdefault(other, placed[known])

    def _nominal_distance(self, rotors: Mapping[str, Any], mesh: Mapping[str, Any]) -> float:
        foot, tip = self._ends(rotors, mesh)
        z_foot, z_tip = _gear(rotors, foot)["teeth"], _gear(rotors, tip)["teeth"]
        total = z_foot - z_tip if self._is_internal(rotors, mesh) else z_foot + z_tip
        return float(mesh["module"] * total / 2.0)

    def _ratios(self, rotors: Mapping[str, Any]) -> list[tuple[str, str, float]]:
        """Return pairs that roll, and the turns of the second per turn of the first, carriers at rest."""
        found = []
        for mesh in self.case.get("meshes") or ():
            ratio = _gear(rotors, mesh["driver"])["teeth"] / _gear(rotors, mesh["driven"])["teeth"]
            sign = 1.0 if self._is_internal(rotors, mesh) else -1.0
            found.append((_rotor_name(mesh["driver"]), _rotor_name(mesh["driven"]), sign * ratio))
        for table in self.case.get("couplings") or ():
            one, two = table["between"]
            found.append((one, two, 1.0 / _number(table, "ratio", 1.0)))
        return found

    @staticmethod
    def _rolled(known: Mapping[str, float], ratios: Sequence[tuple[str, str, float]]) -> dict[str, float]:
        """Return the speeds that follow from the known ones by rolling."""
        speeds = dict(known)
        for _ in ratios:
            for one, two, ratio in ratios:
                if one in speeds and two not in speeds:
                    speeds[two] = speeds[one] * ratio
                elif two in speeds and one not in speeds:
                    speeds[one] = speeds[two] / ratio
                elif one in speeds and abs(speeds[two] - speeds[one] * ratio) > 1e-9 * abs(speeds[two]):
                    raise ValueError(f"the nominal speeds of {one!r} and {two!r} do not roll")
        return speeds

    def _nominal_speeds(self, rotors: Mapping[str, Any]) -> dict[str, float]:
        known: dict[str, float] = {}
        ratios = self._ratios(rotors)
        for name, table in rotors.items():
            drive = table.get("drive") or {}
            if drive.get("kind") in ("speed", "servo"):
                known[name] = float(drive["speed"])
            elif drive.get("kind") == "position":
                known[name] = 0.0
        for name, support in self._tables("supports").items():
            if _number(support, "torsional_stiffness") == 0.0:
                continue
            if support.get("on"):
                ratios.append((support["on"], name, 1.0))
            elif known.setdefault(name, 0.0) != 0.0:
                raise ValueError(f"a spring to the ground holds the driven rotor {name!r}")
        if any(self._frame(mesh) for mesh in self.case.get("meshes") or ()):
            return speeds_on_carriers(list(rotors), self._conditions(rotors), known, self.carriers.values())
        speeds = self._rolled(known, ratios)
        return {name: speeds.get(name, 0.0) for name in rotors}

    def _carriers(self) -> dict[str, str]:
        """Return the carrier of every rotor that has one."""
        tables = (self._tables("sleeves"), self._tables("bearings"), self._tables("supports"))
        return {name: part["on"] for table in tables for name, part in table.items() if part.get("on")}

    def _frame(self, mesh: Mapping[str, Any]) -> str | None:
        """Return the carrier in whose frame a mesh rolls."""
        ends = [_rotor_name(mesh[role]) for role in ("driver", "driven")]
        found = {self.carriers[name] for name in ends if name in self.carriers} - set(ends)
        if len(found) > 1:
            raise ValueError("the gears of a mesh are on two carriers")
        return found.pop() if found else None

    def _conditions(self, rotors: Mapping[str, Any]) -> list[Condition]:
        """Return what the speeds of rotors fulfil that roll at every mesh and joint, and are held by springs."""
        found: list[Condition] = []
        for mesh in self.case.get("meshes") or ():
            one, two = (_gear(rotors, mesh[role])["teeth"] for role in ("driver", "driven"))
            two = -two if self._is_internal(rotors, mesh) else two
            line = {_rotor_name(mesh["driver"]): one / abs(two), _rotor_name(mesh["driven"]): two / abs(two)}
            frame = self._frame(mesh)
            found.append(line if frame is None else {**line, frame: -sum(line.values())})
        for table in self.case.get("couplings") or ():
            one, two = table["between"]
            found.append({one: 1.0, two: -_number(table, "ratio", 1.0)})
        for name, support in self._tables("supports").items():
            if _number(support, "torsional_stiffness") > 0.0:
                found.append({name: 1.0, support["on"]: -1.0} if support.get("on") else {name: 1.0})
        return found

    def _senses(self, rotors: Mapping[str, Any], speeds: Mapping[str, float]) -> dict[str, float]:
        """Return speeds that say which way the rotors turn: nominal ones, or what torques or starts give."""
        if any(speeds.values()):
            return dict(speeds)
        pushes = []
        for name, table in rotors.items():
            drive = table.get("drive") or {}
            if drive.get("kind") == "torque":
                pushes.append((name, _number(drive, "torque")))
            elif drive.get("kind") == "position":  # towards the angle that the sensor's rotor shall have
                pushes.append((drive.get("sensor") or name, _number(drive, "angle")))
        starts = [(name, _number(r.get("initial") or {}, "omega")) for name, r in rotors.items()]
        given = [each for each in pushes[:1] if each[1]] or [each for each in starts if each[1]][:1]
        pushed = {name: math.copysign(1.0, value) for name, value in given}
        if any(self._frame(mesh) for mesh in self.case.get("meshes") or ()):
            held = {n: 0.0 for n, r in rotors.items() if (r.get("drive") or {}).get("kind") == "speed"}
            return speeds_on_carriers(
                list(rotors), self._conditions(rotors), held | pushed, self.carriers.values()
            )
        senses = self._rolled(pushed, self._ratios(rotors))
        return {name: senses.get(name, 0.0) for name in rotors}

    def _build_rotors(
        self,
        rotors: Mapping[str, Any],
        sleeves: Mapping[str, Any],
        positions: Mapping[str, tuple[float, float]],
        speeds: Mapping[str, float],
    ) -> list[_Rotor]:
        built: list[_Rotor] = []
        servos = 0
        for name, table in rotors.items():
            drive = table.get("drive") or {}
            load = table.get("load") or {}
            kind = drive.get("kind", "")
            load_torque = _number(load, "torque")
            sense = math.copysign(1.0, self.senses[name])
            if (load_torque or load.get("terms")) and self.senses[name] == 0.0:
                raise ValueError(f"load.torque of {name!r} needs a nominal sense of rotation")
            torque = -sense * load_torque
            if kind == "torque":
                torque += float(drive["torque"])
            rotor = _Rotor(
                name=name,
                mass=float(table["mass"]),
                inertia=float(table["inertia"]),
                position=positions[name],
                nominal_speed=speeds[name],
                movable=name in sleeves
                or name in self._tables("bearings")
                or bool(table.get("floating"))
                or self._is_sprung(name),
                radial_damping=_number(table, "radial_damping"),
                drive=kind,
                speed=_number(drive, "speed"),
                ramp=_number(drive, "ramp"),
                torque=torque,
                drag=_number(load, "drag"),
                friction=_number(load, "friction"),
                friction_speed=_number(load, "friction_speed"),
                terms=(*terms_of(drive, 1.0), *terms_of(load, -sense)),
            )
            unbalance = table.get("unbalance") or {}
            rotor.unbalance, rotor.unbalance_phase = _number(unbalance, "amount"), _number(unbalance, "phase")
            if rotor.unbalance**2 >= rotor.mass * rotor.inertia:
                raise ValueError(f"the unbalance of {name!r} is more than its mass and inertia allow")
            rotor.ripple = tuple(
                (float(r["order"]), float(r["amplitude"]), _number(r, "phase"))
                for r in drive.get("ripple") or []
            )
            if kind == "servo":
                rotor.kp = float(drive["proportional_gain"])
                rotor.ki = _number(drive, "integral_gain")
                rotor.limit = _number(drive, "torque_limit", math.inf)
                rotor.servo = servos
                servos += 1
            if kind == "position":
                rotor.position_servo = self._build_position_servo(name, drive)
                rotor.servo = servos
                servos += 1
            built.append(rotor)
        return built

    def _is_sprung(self, name: str) -> bool:
        """Return whether a support's stiffness frees the centre of a rotor."""
        return (self._tables("supports").get(name) or {}).get("stiffness") is not None

    def _build_position_servo(self, name: str, drive: Mapping[str, Any]) -> PositionServo:
        sensor = drive.get("sensor") or name
        ratio = self._rolled({name: 1.0}, self._ratios(self.case["rotors"])).get(sensor, 1.0)
        return position_servo_of(drive, self.index[name], self.index[sensor], -1.0 if ratio < 0.0 else 1.0)

    def _build_support(self, name: str, table: Mapping[str, Any]) -> Support:
        carrier = self.index[table["on"]] if table.get("on") else -1
        own, base = self.rotors[self.index[name]].position, (0.0, 0.0)
        damping = pair(table, "damping")
        if carrier >= 0:
            base = self.rotors[carrier].position
            if not any(name in self._tables(table) for table in ("sleeves", "bearings")):  # an elastic pin
                beside = self.rotors[self.index[name]].radial_damping
                damping = damping[0] + beside, damping[1] + beside
        return Support(
            rotor=self.index[name],
            carrier=carrier,
            stiffness=pair(table, "stiffness"),
            damping=damping,
            torsional_stiffness=_number(table, "torsional_stiffness"),
            torsional_damping=_number(table, "torsional_damping"),
            pin=(own[0] - base[0], own[1] - base[1]) if carrier >= 0 else (0.0, 0.0),
            unstressed=pair(table, "offset"),
        )

    def _build_bearing(self, name: str, table: Mapping[str, Any]) -> Bearing:
        carrier = self.index[table["on"]] if table.get("on") else -1
        own, base = self.rotors[self.index[name]], (0.0, 0.0)
        if carrier >= 0:
            base = self.rotors[carrier].position
        arm = own.position[0] - base[0], own.position[1] - base[1]
        return bearing_of(
            table, self.index[name], carrier, arm if carrier >= 0 else (0.0, 0.0), own.radial_damping
        )

    def _set_phases(self, rotors: Mapping[str, Any], tables: Sequence[Mapping[str, Any]]) -> None:
        """Give the meshes their phases at the start and, of gears on a carrier, what turns against it."""
        by_position = self.case.get("mesh_phases", "by_position") == "by_position"
        starts = phases_by_position([self._teeth(rotors, table) for table in tables])
        for mesh, table, start in zip(self.meshes, tables, starts, strict=True):
            mesh.psi0 = _number(table, "phase") + (math.remainder(start, TWO_PI) if by_position else 0.0)
            frame = self._frame(table)
            if frame is None:
                continue
            mesh.frame = self.index[frame]
            turning = self.senses[self.names[mesh.driver]] - self.senses[frame]
            mesh.sigma = -1.0 if (turning < -1e-9) != self._ring_drives(mesh) else 1.0

    def _teeth(self, rotors: Mapping[str, Any], table: Mapping[str, Any]) -> Teeth:
        one, two = (self._gear_name(rotors, table[role]) for role in ("driver", "driven"))
        inner = [name for name in (one, two) if _gear(rotors, name).get("internal")]
        at = [self.rotors[self.index[_rotor_name(name)]].position for name in (one, two)]
        z = [int(_gear(rotors, name)["teeth"]) for name in (one, two)]
        return Teeth(one, two, z[0], z[1], inner[0] if inner else "", at[0], at[1])

    @staticmethod
    def _gear_name(rotors: Mapping[str, Any], name: str) -> str:
        """Return the name of a gear with that of its table's only entry, where a mesh leaves it out."""
        only = next(iter(rotors[_rotor_name(name)].get("gears") or {}), "")
        return f"{name}.{only}" if only and "." not in name else name

    @staticmethod
    def _ring_drives(mesh: _Mesh) -> bool:
        return mesh.s > 0.0 and mesh.driver == mesh.a

    def _build_mesh(self, table: Mapping[str, Any]) -> _Mesh:
        tables = self.case["rotors"]
        foot, tip = self._ends(tables, table)
        a, b = self.index[_rotor_name(foot)], self.index[_rotor_name(tip)]
        driver = self.index[_rotor_name(table["driver"])]
        gear_a, gear_b, driving = (_gear(tables, name) for name in (foot, tip, table["driver"]))
        inner = self._is_internal(tables, table)
        module, alpha0 = float(table["module"]), float(table["pressure_angle"])
        radius_a = module * gear_a["teeth"] / 2.0
        radius_b = module * gear_b["teeth"] / 2.0
        distance = radius_a - radius_b if inner else radius_a + radius_b
        if distance <= 0.0:
            raise ValueError("the ring must have more teeth than its partner")
        scale = 1.0 if self.published else math.cos(alpha0)
        pa, pb = self.rotors[a].position, self.rotors[b].position
        v0 = (pb[0] - pa[0], pb[1] - pa[1])
        length = math.hypot(*v0)
        if abs(length - distance) > 1e-9 * distance:
            raise ValueError(f"positions {length} m apart, the teeth need {distance} m")
        sigma = -1.0 if self.senses[_rotor_name(table["driver"])] < 0.0 else 1.0
        if driving.get("internal"):
            sigma = -sigma
        damping = table.get("damping") or {}
        stiffness = table["stiffness"]
        kind = stiffness["kind"]
        mesh = _Mesh(
            label=f"{table['driver']}-{table['driven']}",
            a=a,
            b=b,
            driver=driver,
            teeth=int(driving["teeth"]),
            arm_a=_runout(gear_a),
            arm_b=_runout(gear_b),
            s=1.0 if inner else -1.0,
            sigma=sigma,
            rho_a=(-radius_a if inner else radius_a) * scale,
            rho_b=radius_b * scale,
            c0=distance * math.cos(alpha0),
            alpha0=alpha0,
            inv0=involute(alpha0),
            u0=(v0[0] / length, v0[1] / length),
            v0=v0,
            backlash=float(table["backlash"]),
            damping=_number(damping, "maximum"),
            depth=_number(damping, "depth", 1.0),
            error=tuple(
                (float(e["order"]), float(e["amplitude"]), _number(e, "phase"))
                for e in table.get("transmission_error") or []
            ),
            kind=kind,
            mean=_number(stiffness, "mean"),
            terms=(),
        )
        if kind == "harmonic":
            mesh.terms = ((1.0, _number(stiffness, "amplitude"), _number(stiffness, "phase")),)
        elif kind == "fourier":
            mesh.terms = tuple(
                (float(t["order"]), float(t["amplitude"]), _number(t, "phase")) for t in stiffness["terms"]
            )
        elif kind == "square":
            mesh.single, mesh.double = float(stiffness["single"]), float(stiffness["double"])
            mesh.share = TWO_PI * (float(stiffness["contact_ratio"]) - 1.0)
            mesh.phase = _number(stiffness, "phase")
            mesh.mean = mesh.single
        elif kind == "table":
            psi = np.append(np.asarray(stiffness["phase"], float), stiffness["phase"][0] + TWO_PI)
            values = np.append(np.asarray(stiffness["stiffness"], float), stiffness["stiffness"][0])
            mesh.spline = CubicHermiteSpline(
                psi, values, _monotone_slopes(psi, values), extrapolate="periodic"
            )
            mesh.mean = float(np.mean(values[:-1]))
        else:
            raise ValueError(f"unknown stiffness kind {kind!r}")
        return mesh

    def _build_tooth_friction(self, table: Mapping[str, Any], mesh: _Mesh) -> ToothFriction | None:
        friction = tooth_friction_of(table, mesh.rho_a, mesh.rho_b, mesh.sigma, mesh.driver == mesh.a)
        if friction is not None and self.published:
            raise ValueError("the teeth of as_published have no friction")
        return friction

    def _build_sleeve(self, name: str, table: Mapping[str, Any]) -> _Sleeve:
        journal = self.index[name]
        carrier = self.index[table["on"]] if table.get("on") else -1
        offset = bush = pair(table, "offset")
        if carrier >= 0:
            p_j, p_c = self.rotors[journal].position, self.rotors[carrier].position
            bush = (p_j[0] - p_c[0] + offset[0], p_j[1] - p_c[1] + offset[1])
        law = table["law"]
        clearance, stiffness = float(table["radial_clearance"]), float(table["stiffness"])
        exponent = _number(table, "exponent", 1.5)
        radius = _number(table, "shaft_radius")
        bed = None
        if law == "conformal":
            bed = WinklerBed(
                radius,
                clearance,
                float(table["bed_exponent"]),
                stiffness,
                exponent,
                float(table["bed_reference_penetration"]),
            )
        return _Sleeve(
            name=name,
            journal=journal,
            carrier=carrier,
            clearance=clearance,
            law=law,
            stiffness=stiffness,
            exponent=exponent,
            factor=law_factor(law, float(table["restitution"])),
            minimum_speed=float(table["minimum_impact_speed"]),
            bush=bush,
            offset=offset,
            friction=_number(table, "friction_coefficient"),
            friction_speed=_number(table, "friction_speed", 1.0),
            shaft_radius=radius,
            outside=table.get("rotor_side") == "bush",
            bed=bed,
        )

    # ------------------------------------------------------------------ state

    def initial_state(self) -> NDArray[np.float64]:
        """Return the state vector at t = 0 (SI)."""
        state = np.zeros(6 * self.n + len(self.servos))
        at_rest = any(r.ramp > 0.0 for r in self.rotors)
        for i, rotor in enumerate(self.rotors):
            start = self.case["rotors"][rotor.name].get("initial") or {}
            speed = 0.0 if at_rest else rotor.nominal_speed
            if rotor.drive != "speed":
                speed = _number(start, "omega", speed)
            j = 3 * (self.n + i)
            for _, amplitude, phase in rotor.ripple:
                speed += rotor.speed * amplitude * math.sin(phase)
            state[3 * i + 2] = _number(start, "theta")
            state[j + 2] = speed - rotor.nominal_speed
            if rotor.movable:
                state[3 * i : 3 * i + 2] = _number(start, "x"), _number(start, "y")
                state[j : j + 2] = _number(start, "vx"), _number(start, "vy")
        return state

    def stop_times(self, end: float) -> list[tuple[float, int]]:
        """Return the times (s) up to ``end`` at which integration stops; the sampled servo's rotor or -1."""
        stops = [(r.ramp, -1) for r in self.rotors if r.ramp > 0.0]
        stops += [(t, -1) for t in (self.base.kinks if self.base is not None else ()) if t > 0.0]
        for i, servo in self._sampled():
            stops += [(k * servo.sample_time, i) for k in range(1, int(end / servo.sample_time) + 2)]
        return sorted(stop for stop in set(stops) if stop[0] <= end)

    def _sampled(self) -> list[tuple[int, PositionServo]]:
        servos = [(i, r.position_servo) for i, r in enumerate(self.rotors)]
        return [(i, servo) for i, servo in servos if servo is not None and servo.sample_time > 0.0]

    def _sample(self, i: int, t: float, state: NDArray[np.float64]) -> NDArray[np.float64]:
        """Let the sampled servo of a rotor update its integral and set the torque that it holds next."""
        rotor, servo = self.rotors[i], self.rotors[i].position_servo
        assert servo is not None
        state = state.copy()
        state[6 * self.n + rotor.servo] += self._pending.get(i, 0.0)
        z = state.tolist()
        sensor = self.body(servo.sensor, t, z)
        raw = servo.raw(sensor, z[6 * self.n + rotor.servo])
        self.held[i] = servo.clipped(raw)
        self._pending[i] = servo.sample_time * servo.integral_rate(sensor, raw, self.held[i])
        self._step_size = 2e-7
        return state

    # ------------------------------------------------------------------ kinematics

    def body(self, i: int, t: float, z: Sequence[float]) -> Body:
        """Return the motion of a rotor in a state at a time (s), with its full rotation and speed."""
        j, nominal = 3 * (self.n + i), self.rotors[i].nominal_speed
        x, y, theta = z[3 * i : 3 * i + 3]
        vx, vy, omega = z[j : j + 3]
        return Body(x, y, nominal * t + theta, vx, vy, nominal + omega)

    def _twist(self, coupling: Coupling, z: Sequence[float]) -> tuple[float, float]:
        """Return a coupling's twist (rad) and its rate; the nominal motion rolls and does not twist it."""
        a, b, n3 = 3 * coupling.a + 2, 3 * coupling.b + 2, 3 * self.n
        return z[a] - coupling.ratio * z[b], z[n3 + a] - coupling.ratio * z[n3 + b]

    def _support_motion(
        self, support: Support | Bearing, t: float, z: Sequence[float]
    ) -> tuple[Body, Body | None]:
        carrier = self.body(support.carrier, t, z) if support.carrier >= 0 else None
        return self.body(support.rotor, t, z), carrier

    def _field(self, t: float) -> Pair:
        """Return what acts on every mass (m/s^2): gravity less the acceleration of the housing."""
        if self.base is None:
            return self.gravity
        ax, ay = self.base.at(t)
        return self.gravity[0] - ax, self.gravity[1] - ay

    def _moment(self, i: int, theta: float) -> Pair:
        """Return mass times the centre of mass from the axis (kg m) of a rotor at its full rotation."""
        rotor = self.rotors[i]
        angle = theta + rotor.unbalance_phase
        return rotor.unbalance * math.cos(angle), rotor.unbalance * math.sin(angle)

    def _mesh_motion(self, mesh: _Mesh, t: float, z: list[float]) -> _MeshMotion:
        n3 = 3 * self.n
        ia, ib = 3 * mesh.a, 3 * mesh.b
        rotor_a, rotor_b = self.rotors[mesh.a], self.rotors[mesh.b]
        rel_a, rel_b = z[ia + 2], z[ib + 2]
        rel_omega_a, rel_omega_b = z[n3 + ia + 2], z[n3 + ib + 2]

        # centres of the two toothings: shaft displacement plus runout
        arm_a, arm_b = (0.0, 0.0), (0.0, 0.0)
        vx = z[n3 + ib] - z[n3 + ia]
        vy = z[n3 + ib + 1] - z[n3 + ia + 1]
        if mesh.arm_a[0]:
            angle = rotor_a.nominal_speed * t + rel_a + mesh.arm_a[1]
            omega = rotor_a.nominal_speed + rel_omega_a
            arm_a = (mesh.arm_a[0] * math.cos(angle), mesh.arm_a[0] * math.sin(angle))
            vx += omega * arm_a[1]
            vy -= omega * arm_a[0]
        if mesh.arm_b[0]:
            angle = rotor_b.nominal_speed * t + rel_b + mesh.arm_b[1]
            omega = rotor_b.nominal_speed + rel_omega_b
            arm_b = (mesh.arm_b[0] * math.cos(angle), mesh.arm_b[0] * math.sin(angle))
            vx -= omega * arm_b[1]
            vy += omega * arm_b[0]
        dx = z[ib] + arm_b[0] - z[ia] - arm_a[0]
        dy = z[ib + 1] + arm_b[1] - z[ia + 1] - arm_a[1]

        # mesh phase and transmission error
        driver = self.rotors[mesh.driver]
        kd = 3 * mesh.driver + 2
        psi = mesh.psi0 + mesh.teeth * (driver.nominal_speed * t + z[kd])
        psi_rate = mesh.teeth * (driver.nominal_speed + z[n3 + kd])
        if mesh.frame is not None:  # the phase as the carrier sees it
            frame, kf = self.rotors[mesh.frame], 3 * mesh.frame + 2
            psi -= mesh.teeth * (frame.nominal_speed * t + z[kf])
            psi_rate -= mesh.teeth * (frame.nominal_speed + z[n3 + kf])
        error = slope = 0.0
        for order, amplitude, phase in mesh.error:
            error += amplitude * math.sin(order * psi + phase)
            slope += amplitude * order * math.cos(order * psi + phase)

        # the nominal motion rolls, so that relative rotations are enough
        rolling = mesh.sigma * (mesh.rho_a * rel_a + mesh.rho_b * rel_b)
        rolling_rate = mesh.sigma * (mesh.rho_a * rel_omega_a + mesh.rho_b * rel_omega_b)

        # the nominal direction u0 and vector v0, which turn with the carrier
        turn, spin = 0.0, 0.0  # of the carrier
        (u0x, u0y), (nominal_x, nominal_y) = mesh.u0, mesh.v0
        if mesh.frame is not None:
            frame, kf = self.rotors[mesh.frame], 3 * mesh.frame + 2
            turn = frame.nominal_speed * t + z[kf]
            spin = frame.nominal_speed + z[n3 + kf]
            (u0x, u0y), (nominal_x, nominal_y) = turned(turn, *mesh.u0), turned(turn, *mesh.v0)
            carried = mesh.sigma * (mesh.rho_a + mesh.rho_b)
            rolling -= carried * z[kf]
            rolling_rate -= carried * z[n3 + kf]

        cx, cy = mesh.v0[0] + dx, mesh.v0[1] + dy
        distance = math.hypot(cx, cy)
        if distance <= mesh.c0:
            raise ValueError(f"mesh {mesh.label}: centre distance {distance} m, base radii need {mesh.c0} m")
        ux, uy = cx / distance, cy / distance
        distance_rate = ux * vx + uy * vy
        alpha = math.acos(mesh.c0 / distance)
        opening = mesh.c0 * (involute(alpha) - mesh.inv0)  # D
        opening_rate = math.sin(alpha) * distance_rate  # dD/dA = sin(alpha_w)
        s, sigma = mesh.s, mesh.sigma

        if self.published or not self.coupled:
            sin0, cos0 = math.sin(mesh.alpha0), math.cos(mesh.alpha0)
            gx = s * (sin0 * u0x - sigma * cos0 * u0y)
            gy = s * (sin0 * u0y + sigma * cos0 * u0x)
            w = rolling + error + gx * (cx - nominal_x) + gy * (cy - nominal_y)
            sweep = gx * cy - gy * cx  # the line of action turns about the foot of the vector of centres
            rate = rolling_rate + slope * psi_rate + gx * vx + gy * vy + spin * sweep
            by_frame = sweep - sigma * (mesh.rho_a + mesh.rho_b) if mesh.frame is not None else 0.0
            b_t, b_rate = mesh.backlash, 0.0
            if self.published and self.coupled:
                b_t += 2.0 * opening
                b_rate = 2.0 * opening_rate
            return _MeshMotion(
                psi, w, rate, -w - b_t, -rate - b_rate, b_t, b_rate, distance, alpha,
                (gx, gy), (-gx, -gy), arm_a, arm_b, by_frame,
            )  # fmt: skip

        cross = u0x * cy - u0y * cx
        along = u0x * cx + u0y * cy
        phi = math.atan2(cross, along)  # beside the carrier's rotation
        phi_rate = (ux * vy - uy * vx) / distance - spin
        rho = mesh.rho_a + mesh.rho_b
        w = rolling - sigma * rho * phi + error
        rate = rolling_rate - sigma * rho * phi_rate + slope * psi_rate
        sin_a, cos_a = math.sin(alpha), math.cos(alpha)
        p_d = w + s * opening
        p_b = -w + s * opening - mesh.backlash
        rate_d = rate + s * opening_rate
        rate_b = -rate + s * opening_rate
        # d(phi)/d(centre of b) = n / A and -(rho_a + rho_b) / A = s cos(alpha_w)
        across_x, across_y = -uy * sigma * cos_a, ux * sigma * cos_a
        return _MeshMotion(
            psi, p_d, rate_d, p_b, rate_b, mesh.backlash - 2.0 * s * opening, -2.0 * s * opening_rate,
            distance, alpha,
            (s * (sin_a * ux + across_x), s * (sin_a * uy + across_y)),
            (s * (sin_a * ux - across_x), s * (sin_a * uy - across_y)),
            arm_a, arm_b,
        )  # fmt: skip

    def _stiffness(self, k: int, psi: float) -> float:
        mesh = self.meshes[k]
        if mesh.kind == "square":
            return mesh.double if self.signs[("mesh", k, "double")] > 0.0 else mesh.single
        if mesh.spline is not None:
            return float(mesh.spline(psi))
        value = mesh.mean
        for order, amplitude, phase in mesh.terms:
            value += amplitude * math.cos(order * psi + phase)
        return value

    def _sleeve_motion(self, sleeve: _Sleeve, t: float, z: list[float]) -> _SleeveMotion:
        n3 = 3 * self.n
        i = 3 * sleeve.journal
        ex, ey = z[i], z[i + 1]
        vx, vy = z[n3 + i], z[n3 + i + 1]
        omega_j = self.rotors[sleeve.journal].nominal_speed + z[n3 + i + 2]
        omega_b = 0.0
        arm = (0.0, 0.0)
        ex -= sleeve.offset[0]
        ey -= sleeve.offset[1]
        if sleeve.carrier >= 0:
            c = 3 * sleeve.carrier
            theta = self.rotors[sleeve.carrier].nominal_speed * t + z[c + 2]
            omega_b = self.rotors[sleeve.carrier].nominal_speed + z[n3 + c + 2]
            bx, by = sleeve.bush
            sine, versine = math.sin(theta), 2.0 * math.sin(0.5 * theta) ** 2  # versine = 1 - cos
            shift_x, shift_y = -versine * bx - sine * by, sine * bx - versine * by
            arm = (bx + shift_x, by + shift_y)  # of the bush, its offset included
            ex -= z[c] + shift_x
            ey -= z[c + 1] + shift_y
            vx -= z[n3 + c] - omega_b * arm[1]
            vy -= z[n3 + c + 1] + omega_b * arm[0]
        length = math.hypot(ex, ey)
        if length == 0.0:
            return _SleeveMotion(1.0, 0.0, -sleeve.clearance, 0.0, 0.0, (0.0, 0.0), arm, (vx, vy))
        ux, uy = ex / length, ey / length
        inner = sleeve.shaft_radius
        levers = (-length - inner, -inner) if sleeve.outside else (inner, length + inner)
        slip = -uy * vx + ux * vy + omega_j * levers[0] - omega_b * levers[1]
        return _SleeveMotion(
            ux, uy, length - sleeve.clearance, ux * vx + uy * vy, slip, levers, arm, (vx, vy)
        )

    # ------------------------------------------------------------------ forces

    def _damping(self, k: int, flank: str, p: float) -> float:
        """C(p) / p (N s/m^2); the branch is the stored one, the ramp is continued through p = 0."""
        mesh = self.meshes[k]
        if self.signs[("mesh", k, "full " + flank)] > 0.0:
            return mesh.damping / p
        u = p / mesh.depth
        return mesh.damping * u * (3.0 - 2.0 * u) / mesh.depth

    def _flank_force(self, k: int, flank: str, p: float, rate: float, stiffness: float) -> float:
        signs = self.signs
        if signs[("mesh", k, flank)] < 0.0:
            return 0.0
        if self.meshes[k].damping == 0.0:
            return stiffness * p
        if signs[("mesh", k, "push " + flank)] < 0.0:
            return 0.0
        return p * (stiffness + self._damping(k, flank, p) * rate)

    def _mesh_forces(self, k: int, motion: _MeshMotion) -> tuple[float, float]:
        """Return the forces (N) on the drive and on the back flank."""
        stiffness = self._stiffness(k, motion.psi)
        if not self.published:
            return (
                self._flank_force(k, "drive", motion.p_d, motion.rate_d, stiffness),
                self._flank_force(k, "back", motion.p_b, motion.rate_b, stiffness),
            )
        damped = self.meshes[k].damping > 0.0
        g, rate = motion.p_d, motion.rate_d
        if self.signs[("mesh", k, "drive")] > 0.0:
            force = stiffness * g
            if damped:
                force += g * self._damping(k, "drive", g) * rate
            return force, 0.0
        if self.signs[("mesh", k, "back")] > 0.0:
            depth = motion.p_b  # -f_g
            force = -stiffness * depth
            if damped:
                force += depth * self._damping(k, "back", depth) * rate
            return 0.0, -force
        return 0.0, 0.0

    def _pitch_point(self, mesh: _Mesh, motion: _MeshMotion, z: Sequence[float]) -> Pair:
        (ax, ay), (bx, by) = self._centre(mesh.a, z), self._centre(mesh.b, z)
        one = ax + motion.arm_a[0], ay + motion.arm_a[1]
        two = bx + motion.arm_b[0], by + motion.arm_b[1]
        return pitch_point(one, two, mesh.rho_a, mesh.rho_b)

    def _centre(self, i: int, z: Sequence[float]) -> Pair:
        """Return where the centre of a rotor is (m)."""
        x, y = self.rotors[i].position
        return x + z[3 * i], y + z[3 * i + 1]

    def tooth_frictions(
        self, k: int, z: Sequence[float], motion: _MeshMotion, normal: Pair
    ) -> list[tuple[Pair, Pair]]:
        """Return where (m) and how (N, on b) friction acts on the flanks of a mesh that carry a normal force."""
        friction = self.tooth_friction[k]
        if friction is None or normal == (0.0, 0.0):
            return []
        found = []
        for flank, force in zip(("drive", "back"), normal, strict=True):
            if force != 0.0:
                point, gradient, slip = self._tooth_slip(k, flank, motion, z)
                smooth = self._smooth_sign("mesh", (k, flank), slip)
                found.append((point, friction.force(force, smooth, gradient)))
        return found

    def _tooth_slip(
        self, k: int, flank: str, motion: _MeshMotion, z: Sequence[float]
    ) -> tuple[Pair, Pair, float]:
        """Return where a flank touches (m), its gradient, and its sliding speed over the speed of full friction."""
        friction, mesh = self.tooth_friction[k], self.meshes[k]
        assert friction is not None
        sense, gradient = (1.0, motion.grad_d) if flank == "drive" else (-1.0, motion.grad_b)
        pitch, parity = self._pitch_point(mesh, motion, z), self.signs[("mesh", k, "parity")]
        point = friction.point(sense, parity, motion.psi, gradient, pitch)
        one, two = self.body(mesh.a, 0.0, z), self.body(mesh.b, 0.0, z)
        velocities, spins = ((one.vx, one.vy), (two.vx, two.vy)), (one.omega, two.omega)
        slip = sliding(self._centre(mesh.a, z), self._centre(mesh.b, z), velocities, spins, point, gradient)
        return point, gradient, slip / friction.speed

    def _sleeve_force(self, k: int, motion: _SleeveMotion) -> tuple[float, float]:
        """Return the normal (along -u) and tangential force (N) of a sleeve on its journal."""
        sleeve = self.sleeves[k]
        if self.signs[("sleeve", k, "contact")] < 0.0 or motion.delta <= 0.0:
            return 0.0, 0.0
        if sleeve.factor and self.signs[("sleeve", k, "push")] < 0.0:
            return 0.0, 0.0
        if sleeve.bed is not None:
            elastic = sleeve.bed.elastic(motion.delta)
        else:
            elastic = sleeve.stiffness * motion.delta**sleeve.exponent
        normal = elastic * (1.0 + sleeve.factor * motion.rate / self.impact_speeds[k])
        tangential = 0.0
        if sleeve.friction:
            relative = motion.slip / sleeve.friction_speed
            tangential = -sleeve.friction * normal * self._smooth_sign("sleeve", k, relative)
        return normal, tangential

    def _smooth_sign(self, kind: str, k: int | tuple[int, str], u: float) -> float:
        if self.signs[(kind, k, "above")] > 0.0:
            return 1.0
        if self.signs[(kind, k, "below")] < 0.0:
            return -1.0
        return 1.5 * u - 0.5 * u**3

    def _servo(self, rotor: _Rotor, t: float, z: list[float], omega: float) -> tuple[float, float]:
        """Target speed (rad/s) and unlimited torque (N m)."""
        target = rotor.speed
        if rotor.ramp > 0.0 and t < rotor.ramp:
            target *= t / rotor.ramp
        return target, rotor.kp * (target - omega) + rotor.ki * z[6 * self.n + rotor.servo]

    def _limited(self, i: int, raw: float, limit: float) -> float:
        """Return a servo's torque on its present branch (N m)."""
        if limit == math.inf:
            return raw
        if self.signs[("servo", i, "upper")] > 0.0:
            return limit
        return -limit if self.signs[("servo", i, "lower")] < 0.0 else raw

    def _servo_action(self, i: int, t: float, z: list[float]) -> tuple[float, float]:
        """Return the torque (N m) of a rotor's servo and the rate of its integral."""
        rotor = self.rotors[i]
        servo = rotor.position_servo
        if servo is None:
            omega = rotor.nominal_speed + z[3 * (self.n + i) + 2]
            target, raw = self._servo(rotor, t, z, omega)
            limited = self._limited(i, raw, rotor.limit)
            return limited, (target - omega) + (limited - raw) / rotor.kp
        if servo.sample_time > 0.0:
            return self.held.get(i, 0.0), 0.0
        sensor = self.body(servo.sensor, t, z)
        raw = servo.raw(sensor, z[6 * self.n + rotor.servo])
        limited = self._limited(i, raw, servo.limit)
        return limited, servo.integral_rate(sensor, raw, limited)

    def _coupling_torque(self, k: int, phi: float, rate: float) -> float:
        """Return a coupling's T (N m): -T acts on its first rotor, ratio T on the second."""
        coupling = self.couplings[k]
        if coupling.half_play == 0.0:
            return coupling.stiffness * phi + coupling.damping * rate
        for side, name in ((1.0, "forward"), (-1.0, "backward")):
            if self.signs[("coupling", k, name)] < 0.0:
                continue
            if coupling.damping and self.signs[("coupling", k, "push " + name)] < 0.0:
                continue
            depth, depth_rate = coupling.depth(side, phi, rate)
            return side * (coupling.stiffness * depth + coupling.damping * depth_rate)
        return 0.0

    @staticmethod
    def _push(force: list[float], i: int, wrench: Sequence[float]) -> None:
        for k in range(3):
            force[3 * i + k] += wrench[k]

    def _add_supports(self, force: list[float], t: float, z: list[float]) -> None:
        for support in self.supports:
            own, reaction = support.loads(*self._support_motion(support, t, z))
            self._push(force, support.rotor, own)
            if support.carrier >= 0:
                self._push(force, support.carrier, reaction)

    def _add_bearings(self, force: list[float], t: float, z: list[float]) -> None:
        for k, bearing in enumerate(self.bearings):
            own, carrier = self._support_motion(bearing, t, z)
            pressed = [self._is_pressed(k, at) for at in range(bearing.count)]
            wrench, reaction = bearing.loads(own, carrier, pressed)
            self._push(force, bearing.rotor, wrench)
            if bearing.carrier >= 0:
                self._push(force, bearing.carrier, reaction)

    def _is_pressed(self, k: int, at: int) -> bool:
        touches = self.signs.get(("bearing", k, f"contact {at}"), -1.0) > 0.0
        return touches and self.signs.get(("bearing", k, f"push {at}"), 1.0) > 0.0

    def _bearing_indicators(self, t: float, z: list[float]) -> dict[Key, float]:
        """Return the depth (m) of every element, and its damping factor where it is pressed."""
        values: dict[Key, float] = {}
        for k, bearing in enumerate(self.bearings):
            for at, element in enumerate(bearing.elements(*self._support_motion(bearing, t, z))):
                key = ("bearing", k, f"contact {at}")
                values[key] = element.depth
                if bearing.chi and self.signs.get(key, element.depth) > 0.0:
                    values[("bearing", k, f"push {at}")] = 1.0 + bearing.chi * element.rate
        return values

    def _add_couplings(self, force: list[float], t: float, z: list[float]) -> None:
        for k, coupling in enumerate(self.couplings):
            torque = self._coupling_torque(k, *self._twist(coupling, z))
            fx, fy = coupling.lateral(self.body(coupling.a, t, z), self.body(coupling.b, t, z))
            self._push(force, coupling.a, (fx, fy, -torque))
            self._push(force, coupling.b, (-fx, -fy, coupling.ratio * torque))

    def _prescribed(self, rotor: _Rotor, t: float) -> float | None:
        """Return the angular acceleration (rad/s^2) of a rotor whose rotation is prescribed."""
        if rotor.drive != "speed":
            return None
        alpha = 0.0
        if self._segment_start < rotor.ramp:  # the end of a ramp is never inside a segment
            alpha = rotor.speed / rotor.ramp
        for order, amplitude, phase in rotor.ripple:
            swing = order * rotor.speed * amplitude * math.cos(order * rotor.speed * t + phase)
            alpha += rotor.speed * swing
        return alpha

    def _right_hand_side(self, t: float, state: NDArray[np.float64]) -> list[float]:
        z: list[float] = state.tolist()
        n3 = 3 * self.n
        force = [0.0] * n3  # Fx, Fy, torque of each rotor
        for k, mesh in enumerate(self.meshes):
            motion = self._mesh_motion(mesh, t, z)
            f_d, f_b = self._mesh_forces(k, motion)
            if f_d == 0.0 and f_b == 0.0:
                continue
            fx = -f_d * motion.grad_d[0] - f_b * motion.grad_b[0]  # on the toothing of b
            fy = -f_d * motion.grad_d[1] - f_b * motion.grad_b[1]
            along = mesh.sigma * (f_d - f_b)
            ia, ib = 3 * mesh.a, 3 * mesh.b
            force[ib] += fx
            force[ib + 1] += fy
            force[ib + 2] += -mesh.rho_b * along + motion.arm_b[0] * fy - motion.arm_b[1] * fx
            force[ia] -= fx
            force[ia + 1] -= fy
            force[ia + 2] += -mesh.rho_a * along - motion.arm_a[0] * fy + motion.arm_a[1] * fx
            for point, (px, py) in self.tooth_frictions(k, z, motion, (f_d, f_b)):
                self._push(force, mesh.b, about(self._centre(mesh.b, z), point, (px, py)))
                self._push(force, mesh.a, about(self._centre(mesh.a, z), point, (-px, -py)))
            if mesh.frame is not None:
                force[3 * mesh.frame + 2] -= (f_d - f_b) * motion.by_frame
        for k, sleeve in enumerate(self.sleeves):
            damping = self.rotors[sleeve.journal].radial_damping if sleeve.carrier >= 0 else 0.0
            if self.signs[("sleeve", k, "contact")] < 0.0 and damping == 0.0:
                continue
            touch = self._sleeve_motion(sleeve, t, z)
            normal, tangential = self._sleeve_force(k, touch)
            fx = -normal * touch.ux - tangential * touch.uy - damping * touch.velocity[0]
            fy = -normal * touch.uy + tangential * touch.ux - damping * touch.velocity[1]
            i = 3 * sleeve.journal
            force[i] += fx
            force[i + 1] += fy
            force[i + 2] += touch.levers[0] * tangential
            if sleeve.carrier >= 0:
                c = 3 * sleeve.carrier
                force[c] -= fx
                force[c + 1] -= fy
                force[c + 2] -= touch.arm[0] * fy - touch.arm[1] * fx
                force[c + 2] -= touch.levers[1] * tangential
        self._add_supports(force, t, z)
        self._add_bearings(force, t, z)
        self._add_couplings(force, t, z)
        result = z[n3 : 2 * n3] + [0.0] * (n3 + len(self.servos))
        field = self._field(t)
        for i, rotor in enumerate(self.rotors):
            j = n3 + 3 * i
            fx, fy, torque = force[3 * i : 3 * i + 3]
            if rotor.name not in self.carriers:
                fx -= rotor.radial_damping * z[j]
                fy -= rotor.radial_damping * z[j + 1]
            theta, omega = rotor.nominal_speed * t + z[3 * i + 2], rotor.nominal_speed + z[j + 2]
            torque += rotor.torque - rotor.drag * omega
            torque += sum(term.torque(t, theta) for term in rotor.terms)
            if rotor.friction and rotor.drive != "speed":
                torque -= rotor.friction * self._smooth_sign("load", i, omega / rotor.friction_speed)
            if rotor.servo >= 0:
                push, result[6 * self.n + rotor.servo] = self._servo_action(i, t, z)
                torque += push
            result[j : j + 3] = accelerations(
                rotor.mass, rotor.inertia, self._moment(i, theta), omega,
                (fx, fy, torque), field, rotor.movable, self._prescribed(rotor, t),
            )  # fmt: skip
        return result

    # ------------------------------------------------------------------ events

    def _indicators(self, t: float, state: NDArray[np.float64]) -> dict[Key, float]:
        """Return the functions whose sign selects a branch now.

        Lengths (m) are the penetrations "drive", "back", "full ..." (beyond the ramp) and "contact"; all
        others are dimensionless.  Which of them count depends on the stored signs.
        """
        z: list[float] = state.tolist()
        signs = self.signs
        values: dict[Key, float] = {}
        for k, mesh in enumerate(self.meshes):
            motion = self._mesh_motion(mesh, t, z)
            if mesh.kind == "square":
                x = motion.psi + mesh.phase
                values[("mesh", k, "double")] = -math.sin(0.5 * x) * math.sin(0.5 * (x - mesh.share))
            if self.published:
                key = ("mesh", k, "drive")
                values[key] = motion.p_d
                flank = "drive"
                closed = signs.get(key, motion.p_d) >= 0.0
                if not closed:
                    key = ("mesh", k, "back")
                    values[key] = motion.p_b
                    flank = "back"
                    closed = signs.get(key, motion.p_b) >= 0.0
                if closed and mesh.damping:
                    values[("mesh", k, "full " + flank)] = values[key] - mesh.depth
                continue
            for flank, p, rate in (
                ("drive", motion.p_d, motion.rate_d),
                ("back", motion.p_b, motion.rate_b),
            ):
                key = ("mesh", k, flank)
                values[key] = p
                if mesh.damping and signs.get(key, p) > 0.0:
                    full = ("mesh", k, "full " + flank)
                    values[full] = p - mesh.depth
                    if full not in signs:
                        signs[full] = 1.0 if p > mesh.depth else -1.0
                    if ("mesh", k, "double") not in signs and mesh.kind == "square":
                        signs[("mesh", k, "double")] = 1.0 if values[("mesh", k, "double")] >= 0.0 else -1.0
                    slope = self._stiffness(k, motion.psi) + self._damping(k, flank, p) * rate  # F / p
                    values[("mesh", k, "push " + flank)] = slope / mesh.mean
            friction = self.tooth_friction[k]
            depths = ("drive", motion.p_d), ("back", motion.p_b)
            if friction is not None and any(signs.get(("mesh", k, flank), p) > 0.0 for flank, p in depths):
                values[("mesh", k, "parity")] = friction.wave(motion.psi)
                if ("mesh", k, "parity") not in signs:
                    signs[("mesh", k, "parity")] = 1.0 if friction.wave(motion.psi) >= 0.0 else -1.0
                for flank, p in depths:
                    if signs.get(("mesh", k, flank), p) > 0.0:
                        _, _, slip = self._tooth_slip(k, flank, motion, z)
                        values[("mesh", (k, flank), "above")] = slip - 1.0
                        values[("mesh", (k, flank), "below")] = slip + 1.0
        for k, sleeve in enumerate(self.sleeves):
            touch = self._sleeve_motion(sleeve, t, z)
            key = ("sleeve", k, "contact")
            values[key] = touch.delta
            if signs.get(key, touch.delta) > 0.0:
                if key not in signs:
                    self.impact_speeds[k] = max(touch.rate, sleeve.minimum_speed)
                if sleeve.factor:
                    values[("sleeve", k, "push")] = 1.0 + sleeve.factor * touch.rate / self.impact_speeds[k]
                if sleeve.friction:
                    values[("sleeve", k, "above")] = touch.slip / sleeve.friction_speed - 1.0
                    values[("sleeve", k, "below")] = touch.slip / sleeve.friction_speed + 1.0
        for i, rotor in enumerate(self.rotors):
            if rotor.drive == "speed":
                continue
            omega = rotor.nominal_speed + z[3 * self.n + 3 * i + 2]
            if rotor.friction:
                values[("load", i, "above")] = omega / rotor.friction_speed - 1.0
                values[("load", i, "below")] = omega / rotor.friction_speed + 1.0
            if rotor.drive == "servo" and rotor.limit < math.inf:
                raw = self._servo(rotor, t, z, omega)[1]
                values[("servo", i, "upper")] = raw / rotor.limit - 1.0
                values[("servo", i, "lower")] = raw / rotor.limit + 1.0
            servo = rotor.position_servo
            if servo is not None and servo.sample_time == 0.0 and servo.limit < math.inf:
                raw = servo.raw(self.body(servo.sensor, t, z), z[6 * self.n + rotor.servo])
                values[("servo", i, "upper")] = raw / servo.limit - 1.0
                values[("servo", i, "lower")] = raw / servo.limit + 1.0
        values.update(self._coupling_indicators(z))
        values.update(self._bearing_indicators(t, z))
        return values

    def _coupling_indicators(self, z: list[float]) -> dict[Key, float]:
        """Return the penetrations (rad) at both ends of every play, and F / k (rad) of an end that damps."""
        values: dict[Key, float] = {}
        for k, coupling in enumerate(self.couplings):
            if coupling.half_play == 0.0:
                continue
            phi, rate = self._twist(coupling, z)
            for side, name in ((1.0, "forward"), (-1.0, "backward")):
                depth, depth_rate = coupling.depth(side, phi, rate)
                key = ("coupling", k, name)
                values[key] = depth
                if coupling.damping and self.signs.get(key, depth) > 0.0:
                    push = depth + coupling.damping / coupling.stiffness * depth_rate
                    values[("coupling", k, "push " + name)] = push
        return values

    def _signed(self, dense: Callable[[float], NDArray[np.float64]], key: Key, t: float) -> float:
        """One indicator along a step's dense output, times its stored sign."""
        return self.signs[key] * self._indicators(t, dense(t))[key]

    @staticmethod
    def _tolerance(key: Key) -> float:
        name = key[2]
        if key[0] == "coupling":
            return ANGLE_TOLERANCE
        if name in ("drive", "back", "contact") or name.startswith(("full", "contact ")):
            return LENGTH_TOLERANCE
        if key[0] == "mesh" and name.startswith("push"):
            return PUSH_TOLERANCE
        if key[0] == "mesh" and name in ("above", "below"):
            return SLIDING_TOLERANCE
        return RATIO_TOLERANCE

    def _refresh(self, t: float, state: NDArray[np.float64]) -> None:
        """Drop the signs that no longer count and give a sign to the indicators that now do."""
        values = self._indicators(t, state)
        kept: dict[Key, float] = {}
        for key, value in values.items():
            if key in self.signs:
                kept[key] = self.signs[key]
            elif key[2] == "parity" or (self.published and key[2] == "drive"):
                kept[key] = 1.0 if value >= 0.0 else -1.0
            else:
                kept[key] = 1.0 if value > 0.0 else -1.0
        self.signs = kept
        self._armed &= set(kept)

    def _flip(self, key: Key, t: float, state: NDArray[np.float64]) -> None:
        sign = -self.signs[key]
        self.signs[key] = sign
        self._armed.discard(key)
        self.events.append((t, key, sign))
        kind, k, name = key
        if name == "parity":  # the sliding of the next pair has a sense of its own
            self.signs = {
                other: s for other, s in self.signs.items() if other[1] not in ((k, "drive"), (k, "back"))
            }
        if kind == "sleeve" and name == "contact" and sign > 0.0:
            touch = self._sleeve_motion(self.sleeves[k], t, state.tolist())
            self.impact_speeds[k] = max(touch.rate, self.sleeves[k].minimum_speed)
        self._refresh(t, state)

    def _find_event(
        self,
        times: list[float],
        values: list[dict[Key, float]],
        signed: Callable[[Key, float], float],
    ) -> tuple[float, Key] | None:
        """Earliest change of sign within one step, or None.

        ``values`` holds the indicators at ``times``; ``signed(key, t)`` evaluates one of them, times its
        stored sign.  An indicator that starts at zero (just after its own event) counts only once it has
        left zero.
        """
        found: list[tuple[float, Key]] = []
        last = len(times) - 1
        for key, sign in self.signs.items():
            tolerance = self._tolerance(key)
            a = [sign * v[key] for v in values]
            armed = a[0] > tolerance or (key in self._armed and a[0] > 0.0)
            if not armed and a[0] < -tolerance:
                found.append((times[0], key))
                continue
            first = 0 if armed else -1
            hit: float | None = None
            end = last
            for j in range(1, last + 1):
                if first >= 0:
                    if a[j] <= 0.0:
                        hit = _root(partial(signed, key), times[j - 1], times[j])
                        end = j - 1
                        break
                elif a[j] > tolerance:
                    first = j
                elif a[j] < -tolerance:
                    hit = self._short_visit(key, signed, times[j - 1], times[j], tolerance)
                    if hit is None:
                        hit = times[0]
                    end = j - 1
                    break
            if 0 <= first < end:
                grazing = self._graze(key, signed, times[first : end + 1], a[first : end + 1])
                if grazing is not None:
                    hit = grazing
            if hit is not None:
                found.append((hit, key))
        return min(found) if found else None

    @staticmethod
    def _short_visit(
        key: Key, signed: Callable[[Key, float], float], begin: float, end: float, tolerance: float
    ) -> float | None:
        """Return when an unarmed indicator came back from its side, if it went there within an interval."""
        best = minimize_scalar(
            lambda tau: -signed(key, tau), bounds=(begin, end), method="bounded", options={"xatol": 1e-13}
        )
        if -best.fun <= tolerance:
            return None
        return _root(lambda tau: signed(key, tau), best.x, end)

    @staticmethod
    def _graze(
        key: Key, signed: Callable[[Key, float], float], times: list[float], a: list[float]
    ) -> float | None:
        """Look for a visit to the other side between two samples: fit parabolas, then minimise."""
        for j in range(1, len(times) - 1):
            h0, h1 = times[j] - times[j - 1], times[j + 1] - times[j]
            if h0 <= 0.0 or h1 <= 0.0:
                continue
            d0, d1 = (a[j] - a[j - 1]) / h0, (a[j + 1] - a[j]) / h1
            curvature = (d1 - d0) / (h0 + h1)
            if curvature <= 0.0:
                continue
            slope = (d0 * h1 + d1 * h0) / (h0 + h1)
            offset = -slope / (2.0 * curvature)
            lowest = a[j] - slope**2 / (4.0 * curvature)
            if not -h0 <= offset <= h1 or lowest > 0.2 * min(a[j - 1 : j + 2]):
                continue
            best = minimize_scalar(
                lambda tau: signed(key, tau),
                bounds=(times[j - 1], times[j + 1]),
                method="bounded",
                options={"xatol": 1e-12},
            )
            if best.fun < 0.0:
                return _root(lambda tau: signed(key, tau), times[j - 1], best.x)
        return None

    # ------------------------------------------------------------------ integration

    def _integrate(
        self, t: float, state: NDArray[np.float64], end: float, first_step: float
    ) -> NDArray[np.float64]:
        """Integrate without looking for events."""
        if end - t < MIN_TIME_STEP:
            return state + (end - t) * np.asarray(self._right_hand_side(t, state))
        solver = DOP853(
            self._right_hand_side, t, state, end,
            first_step=min(first_step, end - t), max_step=self.max_step,
            rtol=self.relative_tolerance, atol=self.absolute_tolerance,
        )  # fmt: skip
        while solver.status == "running":
            message = solver.step()
        if solver.status == "failed":
            raise RuntimeError(message)
        return np.asarray(solver.y, float)

    def _settle(self, key: Key, t: float, state: NDArray[np.float64]) -> tuple[float, NDArray[np.float64]]:
        """Newton steps onto the zero of one indicator, from a state that is already within rounding of it."""
        for _ in range(3):
            value = self._indicators(t, state)[key]
            rate = np.asarray(self._right_hand_side(t, state))
            eps = 1e-9
            ahead = self._indicators(t + eps, state + eps * rate)[key]
            behind = self._indicators(t - eps, state - eps * rate)[key]
            slope = (ahead - behind) / (2.0 * eps)
            if slope == 0.0 or abs(value / slope) > 1e-11:
                break
            t = t - value / slope
            state = state - value / slope * rate
        residual = abs(self._indicators(t, state)[key])
        allowed = {LENGTH_TOLERANCE: 1e-15, ANGLE_TOLERANCE: 1e-14}.get(self._tolerance(key), 1e-8)
        if residual > allowed:
            raise RuntimeError(f"event {key} at {t} s: residual {residual}")
        return t, state

    def _advance(
        self, t: float, state: NDArray[np.float64], stop: float
    ) -> tuple[float, NDArray[np.float64]]:
        """Integrate from t to stop (s) through all events on the way."""
        burst = 0
        while stop - t >= MIN_TIME_STEP:
            self._segment_start = t
            solver = DOP853(
                self._right_hand_side, t, state, stop,
                first_step=min(self._step_size, stop - t), max_step=self.max_step,
                rtol=self.relative_tolerance, atol=self.absolute_tolerance,
            )  # fmt: skip
            begin_values = self._indicators(t, state)
            hit: tuple[float, Key] | None = None
            while solver.status == "running":
                planned = solver.h_abs
                before = solver.y
                message = solver.step()
                if solver.status == "failed":
                    raise RuntimeError(f"{message} at {solver.t} s")
                self.steps += 1
                t0, t1 = solver.t_old, solver.t
                dense = solver.dense_output()
                times = [t0 + f * (t1 - t0) for f in (0.0, 0.25, 0.5, 0.75)] + [t1]
                values = [begin_values]
                values += [self._indicators(tau, dense(tau)) for tau in times[1:-1]]
                values.append(self._indicators(t1, solver.y))
                hit = self._find_event(
                    times,
                    values,
                    partial(self._signed, dense),
                )
                if hit is not None:
                    break
                begin_values = values[-1]
                for key, sign in self.signs.items():
                    if sign * begin_values[key] > self._tolerance(key):
                        self._armed.add(key)
                self._step_size = max(solver.h_abs, planned) if t1 == stop else solver.h_abs
            if hit is None:
                t, state = solver.t, solver.y
                continue
            time, key = hit
            if time > t0:
                state = self._integrate(t0, before, time, time - t0)
                time, state = self._settle(key, time, state)
            else:
                state = before
            burst = burst + 1 if time - t < 1e-12 else 0
            if burst > 50:
                raise RuntimeError(f"events without end at {time} s: {self.events[-4:]}")
            t = time
            self._flip(key, t, state)
            self._step_size = 2e-7
        return stop, state

    def start(self) -> NDArray[np.float64]:
        """Set all branches for t = 0 and return the initial state."""
        state = self.initial_state()
        self.signs = {}
        self.events = []
        self.steps = 0
        self._armed = set()
        self._step_size = 1e-7
        self._segment_start = 0.0
        self.held, self._pending = {}, {}
        self._refresh(0.0, state)
        for i, _ in self._sampled():
            state = self._sample(i, 0.0, state)
        return state

    def trajectory(self, t_eval: ArrayLike) -> dict[str, NDArray[np.float64]]:
        """Return the motion at the increasing times ``t_eval`` (s, from 0 on).

        ``x``, ``y`` (m), ``theta`` (rad, full), ``vx``, ``vy`` (m/s), ``omega`` (rad/s, full),
        ``ax``, ``ay`` (m/s^2) and ``alpha`` (rad/s^2) have the shape (time, rotor).  ``state`` (time, n) are
        the state vectors and ``impact_speed`` (time, sleeve; m/s) the latched speeds, as ``forces`` takes
        them.
        """
        times = np.asarray(t_eval, float)
        if times.size and (times[0] < 0.0 or np.any(np.diff(times) <= 0.0)):
            raise ValueError("t_eval must increase from t >= 0")
        stops = self.stop_times(float(times[-1]) if times.size else 0.0)
        t, state = 0.0, self.start()
        rows, rates, speeds = [], [], []
        for time in times:
            while stops and stops[0][0] <= time:
                stop, sampled = stops.pop(0)
                t, state = self._advance(t, state, stop)
                state = self._sample(sampled, t, state) if sampled >= 0 else state
            t, state = self._advance(t, state, float(time)) if time > t else (t, state)
            rows.append(state.copy())
            self._segment_start = t
            rates.append(self._right_hand_side(t, state)[3 * self.n : 6 * self.n])
            speeds.append(list(self.impact_speeds))
        table = np.array(rows).reshape(times.size, -1)
        motion = table[:, : 6 * self.n].reshape(times.size, 2, self.n, 3)
        rate = np.array(rates).reshape(times.size, self.n, 3)
        nominal = np.array([r.nominal_speed for r in self.rotors])
        return {
            "t": times,
            "x": motion[:, 0, :, 0],
            "y": motion[:, 0, :, 1],
            "theta": motion[:, 0, :, 2] + nominal * times[:, None],
            "vx": motion[:, 1, :, 0],
            "vy": motion[:, 1, :, 1],
            "omega": motion[:, 1, :, 2] + nominal,
            "ax": rate[:, :, 0],
            "ay": rate[:, :, 1],
            "alpha": rate[:, :, 2],
            "state": table,
            "impact_speed": np.array(speeds).reshape(times.size, len(self.sleeves)),
        }

    # ------------------------------------------------------------------ outputs

    def forces(
        self, t: float, y: ArrayLike, impact_speed: Sequence[float] | None = None
    ) -> dict[str, dict[str, dict[str, float]]]:
        """Return the contact forces in a state ``y`` at the time ``t`` (s).

        The branches are chosen by the state alone.  ``mesh`` -> label -> ``p_d``, ``p_b``, ``b_t``, ``A``
        (m), ``F_d``, ``F_b`` (N), ``alpha_w`` (rad), ``K`` (N/m); ``sleeve`` -> journal -> ``delta`` (m),
        ``delta_rate`` (m/s), ``F_n``, ``F_t``, ``force_x``, ``force_y`` (N, on the journal).
        ``impact_speed`` (m/s) gives the latched speeds of the sleeves; without it those of the
        simulation's present moment count.
        """
        state = np.asarray(y, float)
        saved = self.signs, list(self.impact_speeds), set(self._armed)
        try:
            self.signs = {}
            self._refresh(t, state)
            self.impact_speeds = saved[1] if impact_speed is None else [float(v) for v in impact_speed]
            # the sign of the sleeves' damping factor depends on the latched speed
            values = self._indicators(t, state)
            for key, value in values.items():
                if key[0] == "sleeve" and key[2] == "push":
                    self.signs[key] = 1.0 if value > 0.0 else -1.0
            z = state.tolist()
            meshes, sleeves = {}, {}
            for k, mesh in enumerate(self.meshes):
                motion = self._mesh_motion(mesh, t, z)
                f_d, f_b = self._mesh_forces(k, motion)
                meshes[mesh.label] = {
                    "p_d": motion.p_d,
                    "p_b": motion.p_b,
                    "F_d": f_d,
                    "F_b": f_b,
                    "b_t": motion.b_t,
                    "A": motion.distance,
                    "alpha_w": motion.alpha,
                    "K": self._stiffness(k, motion.psi),
                }
            for k, sleeve in enumerate(self.sleeves):
                touch = self._sleeve_motion(sleeve, t, z)
                normal, tangential = self._sleeve_force(k, touch)
                sleeves[sleeve.name] = {
                    "delta": touch.delta,
                    "delta_rate": touch.rate,
                    "F_n": normal,
                    "F_t": tangential,
                    "force_x": -normal * touch.ux - tangential * touch.uy,
                    "force_y": -normal * touch.uy + tangential * touch.ux,
                }
        finally:
            self.signs, self.impact_speeds, self._armed = saved
        return {"mesh": meshes, "sleeve": sleeves}
