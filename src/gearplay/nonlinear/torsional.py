"""The torsional gear pair of the literature as a case."""

import math

from gearplay.model.case import Case
from gearplay.model.reading import load_case
from gearplay.model.torsional_pair import FIELD, NATURAL_FREQUENCY


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

    They are fields of the case, ``torsional_pair.frequency`` and so on, over which sweeps and diagrams run; the speed of
    the drive alone cannot be changed, since torque and error depend on it. The signal ``x`` is the displacement in half
    backlashes.

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
        Whether kappa is a square wave: 1 + a over ``duty`` of the period, then 1 - a.
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
    >>> round(case.rotors["pinion"].drive.speed * 20 / NATURAL_FREQUENCY, 6), case.meshes[0].backlash
    (0.5, 0.0001)

    """
    numbers = {
        "frequency": frequency,
        "mean_force": mean_force,
        "force": force,
        "force_phase": force_phase,
        "damping_ratio": damping_ratio,
        "stiffness_amplitude": stiffness_amplitude,
        "square": square,
        "duty": duty,
        "backlash": backlash,
    }
    omega = frequency * NATURAL_FREQUENCY
    period = 2.0 * math.pi / omega if omega > 0.0 else 1.0
    return load_case(
        {
            "title": "Torsional pair",
            FIELD: numbers,
            "run": {
                "duration": 100.0 * period,
                "transient": 0.0,
                "sampling": 100.0 / period,
                "tolerance": tolerance,
            },
        }
    )
