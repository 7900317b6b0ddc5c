"""The torsional gear pair of the literature, one degree of freedom, from dimensionless numbers.

With x the displacement over half the backlash b, measured from the middle of the gap, and time in 1/omega_n,

    x'' + 2 zeta x' + kappa(tau) f(x) = F_m + F_a cos(Omega tau + phi),    f(x) = x - 1 above 1, x + 1 below -1, else 0:

A. Kahraman, R. Singh, J. Sound Vib. 142 (1990) 49, eq. (10). Here the pinion's speed is prescribed, so that the mesh phase is
Omega tau; the wheel turns about a fixed centre with a drag, which acts in and out of contact; F_a is made by a transmission
error. The equation holds exactly, with x = 1 + drive_penetration / (b / 2).
"""

import math
from typing import Annotated, Any, Final

from pydantic import Field

from gearplay.schema.fields import Measure, Part
from gearplay.vocabulary import quantities as q
from gearplay.vocabulary.errors import Fault

STIFFNESS: Final = 1e8
MASS: Final = 1.0
HALF_BACKLASH: Final = 50e-6
"""N/m, kg and m by which the dimensionless numbers are multiplied."""
TEETH: Final = 20
MODULE: Final = 0.01
BASE_RADIUS: Final = 0.5 * TEETH * MODULE * math.cos(math.radians(20.0))
NATURAL_FREQUENCY: Final = math.sqrt(STIFFNESS / MASS)
"""omega_n of the pair [rad/s]."""
FIELD: Final = "torsional_pair"
PARTS: Final = ("rotors", "meshes")
"""Fields of a case that follow from the pair."""


class TorsionalPair(Part):
    """The torsional pair of the literature: a case of a pinion and a wheel from dimensionless numbers.

    x'' + 2 zeta x' + kappa f(x) = F_m + F_a cos(Omega tau + phi), Kahraman and Singh 1990. It stands for the rotors ``pinion``
    and ``wheel`` and their mesh.
    """

    frequency: Annotated[float, Measure(None, "Omega, mesh over natural frequency", ge=1e-3, le=1e3)]
    mean_force: Annotated[
        float, Measure(None, "F_m, mean force over stiffness and half backlash", ge=-1e3, le=1e3)
    ] = 0.1
    force: Annotated[
        float, Measure(None, "F_a, alternating force over stiffness and half backlash", ge=0.0, le=1e3)
    ] = 0.0
    force_phase: Annotated[float, Measure(q.ANGLE, "phi of the alternating force")] = 0.0
    damping_ratio: Annotated[float, Measure(None, "zeta", ge=0.0, le=10.0)] = 0.05
    stiffness_amplitude: Annotated[
        float, Measure(None, "a of kappa = 1 + a cos(Omega tau)", ge=0.0, le=0.999)
    ] = 0.0
    square: Annotated[
        bool, Field(description="whether kappa is 1 + a over the duty of the period, then 1 - a")
    ] = False
    duty: Annotated[float, Measure(None, "part of the period with 1 + a", ge=0.001, le=0.999)] = 0.5
    backlash: Annotated[bool, Field(description="without it the mesh is linear")] = True

    def parts(self) -> dict[str, Any]:
        """Return rotors and meshes of the case, as a file has them."""
        omega = self.frequency * NATURAL_FREQUENCY
        damping = 2.0 * self.damping_ratio * MASS * NATURAL_FREQUENCY  # N s/m along the line of action
        unit = STIFFNESS * HALF_BACKLASH
        rotor = {"teeth": TEETH, "mass": 1.0, "inertia": MASS * BASE_RADIUS**2}
        drag = damping * BASE_RADIUS**2
        # The drag at the nominal speed is no load: the drive's torque takes it off.
        torque = self.mean_force * unit * BASE_RADIUS - drag * omega / TEETH
        amplitude = self.stiffness_amplitude * STIFFNESS
        stiffness: dict[str, Any] = {"kind": "harmonic", "mean": STIFFNESS, "amplitude": amplitude}
        if self.square:
            stiffness = {
                "kind": "square",
                "single": STIFFNESS - amplitude,
                "double": STIFFNESS + amplitude,
                "contact_ratio": 1.0 + self.duty,
            }
        # m e'' + c e' of e = A sin(psi + alpha) is A omega sqrt((m omega)^2 + c^2) cos(psi + alpha + atan2(m omega, c)).
        error = {
            "order": 1,
            "amplitude": self.force * unit / (omega * math.hypot(MASS * omega, damping)),
            "phase": self.force_phase - math.atan2(MASS * omega, damping),
        }
        mesh = {
            "driver": "pinion",
            "driven": "wheel",
            "module": MODULE,
            "pressure_angle": math.radians(20.0),
            "backlash": 2.0 * HALF_BACKLASH if self.backlash else 0.0,
            "stiffness": stiffness,
            "transmission_error": [error] if self.force else [],
        }
        return {
            "rotors": {
                "pinion": {**rotor, "drive": {"kind": "speed", "speed": omega / TEETH}},
                "wheel": {**rotor, "drive": {"kind": "torque", "torque": torque}, "load": {"drag": drag}},
            },
            "meshes": [mesh],
        }


def speed_fault(path: str, value: Any) -> Fault:
    """Return the refusal of another speed of a pair whose torque and error belong to one speed."""
    rule = "must stay, since torque and error of the torsional pair belong to one speed"
    return Fault(path, value, rule, f"Change {FIELD}.frequency, Omega, which changes all three")
