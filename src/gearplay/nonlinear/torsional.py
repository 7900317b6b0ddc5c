"""The torsional gear pair of the literature, one degree of freedom, as a case of the same machinery.

With x the penetration over half the backlash b, measured from the middle of the gap, and time in 1/omega_n,

    x'' + 2 zeta x' + kappa(tau) f(x) = F_m + F_a cos(Omega tau + phi),    f(x) = x - 1 above 1, x + 1 below -1, else 0:

A. Kahraman, R. Singh, J. Sound Vib. 142 (1990) 49, eq. (10). Here the pinion's speed is prescribed, so that the mesh phase is
Omega tau; the wheel turns about a fixed centre with a drag, which acts in and out of contact; F_a is made by a transmission
error. The equation holds exactly.
"""

import math

from gearplay.model.case import Case
from gearplay.model.reading import load_case
from gearplay.vocabulary.errors import Fault, InputError

STIFFNESS, MASS, HALF_BACKLASH = (
    1e8,
    1.0,
    50e-6,
)  # N/m, kg, m: what the dimensionless numbers are multiplied with
TEETH, MODULE = 20, 0.01
BASE_RADIUS = 0.5 * TEETH * MODULE * math.cos(math.radians(20.0))
NATURAL_FREQUENCY = math.sqrt(STIFFNESS / MASS)
"""omega_n [rad/s] of the pair that `torsional_pair` returns."""


def torsional_pair(
    frequency: float,
    *,
    damping_ratio: float = 0.05,
    mean_force: float = 0.1,
    force: float = 0.0,
    force_phase: float = 0.0,
    stiffness_amplitude: float = 0.0,
    square: bool = False,
    duty: float = 0.5,
    backlash: bool = True,
    tolerance: float = 1e-10,
) -> Case:
    """Return the torsional pair as a case, from dimensionless numbers.

    ``frequency`` is Omega, mesh over natural frequency; ``mean_force`` F_m and ``force`` F_a are over ``k_m b``;
    ``stiffness_amplitude`` is that of kappa = 1 + a cos(Omega tau), or with ``square`` of a wave 1 + a over ``duty`` of the
    period, then 1 - a. Without ``backlash`` the mesh is linear, in contact to both sides.

    Parameters
    ----------
    frequency
        Omega, mesh over natural frequency [1].
    damping_ratio
        Of critical [1].
    mean_force, force
        F_m and F_a over ``k_m b`` [1].
    force_phase
        Of the alternating force [rad].
    stiffness_amplitude
        a of kappa = 1 + a cos(Omega tau) [1].
    square, duty
        Whether kappa is 1 + a over ``duty`` of the period, then 1 - a.
    backlash
        Whether there is any; without, the mesh is linear, in contact to both sides.
    tolerance
        Error tolerance on scaled states [1].

    Returns
    -------
    Case
        A driver and a driven wheel, ready to simulate.

    Raises
    ------
    InputError
        For numbers outside their range.

    Examples
    --------
    >>> case = torsional_pair(0.5, mean_force=0.2)
    >>> round(case.rotors["pinion"].drive.speed * TEETH / NATURAL_FREQUENCY, 6), case.meshes[0].backlash
    (0.5, 0.0001)

    """
    for name, value, low, high in (
        ("frequency", frequency, 1e-3, 1e3),
        ("damping_ratio", damping_ratio, 0.0, 10.0),
        ("mean_force", mean_force, -1e3, 1e3),
        ("force", force, 0.0, 1e3),
        ("stiffness_amplitude", stiffness_amplitude, 0.0, 0.999),
        ("duty", duty, 0.001, 0.999),
    ):
        if not low <= value <= high:
            raise InputError(Fault(name, value, f"must lie between {low:g} and {high:g}", "Correct it"))
    omega = frequency * NATURAL_FREQUENCY
    damping = 2.0 * damping_ratio * MASS * NATURAL_FREQUENCY  # N s/m along the line of action
    unit = STIFFNESS * HALF_BACKLASH
    rotor = {"teeth": TEETH, "mass": 1.0, "inertia": MASS * BASE_RADIUS**2}
    drag = damping * BASE_RADIUS**2
    # The drag at the nominal speed is no load: the drive's torque takes it off.
    torque = mean_force * unit * BASE_RADIUS - drag * omega / TEETH
    stiffness: dict[str, object] = {
        "kind": "harmonic",
        "mean": STIFFNESS,
        "amplitude": stiffness_amplitude * STIFFNESS,
    }
    if square:
        stiffness = {
            "kind": "square",
            "single": (1.0 - stiffness_amplitude) * STIFFNESS,
            "double": (1.0 + stiffness_amplitude) * STIFFNESS,
            "contact_ratio": 1.0 + duty,
        }
    # m e'' + c e' of e = A sin(psi + alpha) is A omega sqrt((m omega)^2 + c^2) cos(psi + alpha + atan2(m omega, c)).
    amplitude = force * unit / (omega * math.hypot(MASS * omega, damping))
    phase = force_phase - math.atan2(MASS * omega, damping)
    return load_case(
        {
            "title": f"Torsional pair, frequency {frequency:g}",
            "rotors": {
                "pinion": {**rotor, "drive": {"kind": "speed", "speed": omega / TEETH}},
                "wheel": {**rotor, "drive": {"kind": "torque", "torque": torque}, "load": {"drag": drag}},
            },
            "meshes": [
                {
                    "driver": "pinion",
                    "driven": "wheel",
                    "module": MODULE,
                    "pressure_angle": math.radians(20.0),
                    "backlash": 2.0 * HALF_BACKLASH if backlash else 0.0,
                    "stiffness": stiffness,
                    "transmission_error": [{"order": 1, "amplitude": amplitude, "phase": phase}]
                    if force
                    else [],
                }
            ],
            "run": {
                "duration": 200.0 * math.pi / omega,
                "transient": 0.0,
                "sampling": 100.0 * omega / (2.0 * math.pi),
                "tolerance": tolerance,
            },
        }
    )
