"""Load-sharing factors of the planets of a set from the forces of their meshes with the sun."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gearplay.model.case import Case
from gearplay.vocabulary.errors import NO_VALUE, InputError

Floats = NDArray[np.float64]

FACTORS = {
    "factor": "mean load-sharing factor of the most loaded planet",
    "peak": "largest force of a planet over the mean share",
}
"""Numbers of a set over a motion, both 1 where the planets always share alike."""


class LoadFactors(NamedTuple):
    """Load-sharing factors of N planets over a motion.

    ``history``, shape [planet, time], is N times a planet's part of the force on the sun, NaN without a force; ``mean`` and
    ``spread``, shape [planet], are its mean and standard deviation weighted by the force; ``peak``, shape [planet], is a
    planet's largest force over the mean of all.
    """

    history: Floats
    mean: Floats
    spread: Floats
    peak: Floats


def set_of(case: Case, name: str | None, *, field: str = "name") -> str:
    """Return the name of a planetary set of a case, which may be left out where there is one.

    Raises `InputError`, of ``field``, where there is none, or several and no ``name``.
    """
    names = list(case.planetary)
    if not names:
        raise InputError.of("planetary", NO_VALUE, "must have a set", "Add a table [planetary.NAME]")
    if name is None and len(names) > 1:
        rule = "is required, since there are several sets"
        raise InputError.of(field, NO_VALUE, rule, f"Sets: {', '.join(names)}")
    if name is not None and name not in names:
        raise InputError.of(field, name, "must be a planetary set of the case", f"Sets: {', '.join(names)}")
    return name or names[0]


def planets_of(case: Case, name: str) -> list[str]:
    """Return the rotors of the planets of a set."""
    return [f"{name}.planet{k}" for k in range(1, case.planetary[name].planets.count + 1)]


def mesh_of(case: Case, name: str, planet: str, other: str) -> int:
    """Return the place of the mesh of a planet with the ``sun`` or ``ring`` of its set."""
    both = {planet, f"{name}.{other}"}
    return next(j for j, mesh in enumerate(case.meshes) if set(mesh.rotors) == both)


def load_factors(forces: Floats) -> LoadFactors:
    """Return the factors from the forces of the planets on the sun [N], signed, shape [planet, time].

    >>> load_factors(np.array([[30.0, 60.0], [10.0, 0.0]])).mean.tolist()
    [1.8, 0.2]
    """
    total, count = forces.sum(axis=0), len(forces)
    with np.errstate(invalid="ignore", divide="ignore"):
        factor = count * forces / np.where(total == 0.0, np.nan, total)
    # Weighted by the load: the share of a zero load is meaningless.
    weight = np.abs(total) / max(float(np.sum(np.abs(total))), 1e-300)
    mean = np.nansum(factor * weight, axis=1)
    spread = np.sqrt(np.nansum(weight * (factor - mean[:, None]) ** 2, axis=1))
    peak = count * np.max(np.abs(forces), axis=1) / max(float(np.mean(np.abs(total))), 1e-300)
    return LoadFactors(factor, mean, spread, peak)
