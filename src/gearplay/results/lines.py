"""Expected frequencies of a case: meshes, orders of planetary sets, shafts, rolling bearings."""

import math

from gearplay.model.case import Case
from gearplay.parts.mesh.train.rolling import mesh_frequency, nominal_speeds
from gearplay.parts.planetary.frequencies import set_frequencies

MOST_HARMONICS = 12


def spectrum_lines(case: Case) -> dict[str, float]:
    """Return the expected lines [Hz]: mesh frequencies and their doubles, orders of planetary sets, shafts, rolling bearings.

    >>> from gearplay.model.reading import load_case
    >>> list(spectrum_lines(load_case("two-stage-reducer")))[:4]
    ['f_m1', 'f_m2', '2 f_m1', '2 f_m2']
    """
    meshes = _named_meshes(case)
    return meshes | {f"2 {name}": 2.0 * line for name, line in meshes.items()} | _other_lines(case)


def _other_lines(case: Case) -> dict[str, float]:
    """Return the lines [Hz] of planetary sets, shafts and rolling bearings, of equal bearings once."""
    found: dict[str, float] = {}
    for name in case.planetary:
        orders = set_frequencies(case, name).orders()
        others = {order: line for order, line in orders.items() if order not in ("mesh", "carrier")}
        found |= {f"{order} of {name}": line for order, line in others.items()}
    speeds = dict(zip(case.rotors, nominal_speeds(case).tolist(), strict=True))
    for name, speed in speeds.items():
        if speed != 0.0 and ".planet" not in name:
            found[f"shaft of {name}"] = abs(speed) / (2.0 * math.pi)
    for name, bearing in case.bearings.items():
        carrier = speeds[bearing.on] if bearing.on is not None else 0.0
        turn = abs(speeds[name] - carrier) / (2.0 * math.pi)
        for line, order in (("BPFO", bearing.orders.outer), ("BPFI", bearing.orders.inner)):
            frequency = round(order * turn, 9)
            if frequency not in (0.0, *found.values()):
                found[f"{line} of {name}"] = frequency
    return found


def mesh_lines(case: Case) -> dict[str, float]:
    """Return the frequency [Hz] of each mesh that turns, by name; of meshes with one frequency the first.

    >>> from gearplay.model.reading import load_case
    >>> mesh_lines(load_case("two-stage-reducer"))
    {'input-layshaft.wheel': 960.0, 'layshaft.pinion-output': 480.0}
    """
    found: dict[str, float] = {}
    for j, mesh in enumerate(case.meshes):
        line = round(abs(mesh_frequency(case, j)), 9)
        if line > 0.0 and line not in found.values():
            found[mesh.label] = line
    return found


def line_marks(case: Case) -> dict[str, float]:
    """Return the marked lines of a spectrum [Hz] in order of priority: mesh, planetary orders, shafts, bearings, harmonics."""
    meshes = _named_meshes(case)
    orders = range(2, MOST_HARMONICS + 1)
    harmonics = {f"{order} {name}": order * line for order in orders for name, line in meshes.items()}
    return meshes | _other_lines(case) | harmonics


def _named_meshes(case: Case) -> dict[str, float]:
    """Return the mesh frequencies [Hz] by their names in marks."""
    return dict(zip(mesh_names(case), mesh_lines(case).values(), strict=True))


def mesh_names(case: Case) -> dict[str, str]:
    """Return the mesh of each mesh frequency by its name in marks: ``f_m``, of several ``f_m1``, ``f_m2``.

    >>> from gearplay.model.reading import load_case
    >>> mesh_names(load_case("two-stage-reducer"))
    {'f_m1': 'input-layshaft.wheel', 'f_m2': 'layshaft.pinion-output'}
    """
    names = list(mesh_lines(case))
    return {f"f_m{k}" if len(names) > 1 else "f_m": name for k, name in enumerate(names, 1)}
