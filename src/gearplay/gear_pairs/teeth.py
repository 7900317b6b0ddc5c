"""`teeth`: a gear pair as drawn, its path of contact, stiffness and load sharing, over the clearance circle too."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from gearplay.gear_pairs.drawing_table import drawing_rows, gear_tables, pair_values
from gearplay.model.reading import Source
from gearplay.parts.mesh.mesh_stiffness import pack_stiffness
from gearplay.parts.mesh.stiffness import TeethStiffness
from gearplay.parts.mesh.teeth_stiffness import forwards, stiffness_over_path
from gearplay.parts.mesh.tooth_loads import tooth_loads
from gearplay.parts.mesh.train import geometry
from gearplay.results.base import OfDataset
from gearplay.results.provenance import provenance
from gearplay.results.simulate import case_of
from gearplay.toothing.load_sharing import static_sharing, tip_gaps
from gearplay.toothing.outline import closed_teeth
from gearplay.vocabulary.errors import InputError
from gearplay.vocabulary.suggestions import listed

if TYPE_CHECKING:
    import xarray as xr

    from gearplay.model.case import Case
    from gearplay.toothing.pair import GearPair

PLACES, PHASES, DISTANCES, DIRECTIONS = 401, 361, 81, 73
"""Numbers of places on the path, phases of a mesh period, centre distances, directions of the clearance circle."""
AROUND = 0.05
"""Modules by which the centre distance is varied where there are no clearances."""
DRAWN_TEETH = 3
"""Teeth either side of the mesh in `outline`."""


class Teeth(OfDataset):
    """A gear pair: geometry, path of contact, stiffness.

    ``ds`` has over ``place`` [m] along the path, from the base tangent point of the first gear, ``base_gap`` and
    ``sliding_speed``; over ``phase`` in base pitches ``mesh_stiffness``, and of stiffness from the teeth ``pairs_in_contact``,
    ``pair_stiffness``, ``load_sharing_ratio`` and ``static_transmission_error``; over ``center_distance`` and over the
    ``direction`` of the centres on their clearance circle the contact ratio, the working pressure angle and the backlash; the
    outlines of both gears in mesh.
    """

    result_kind: ClassVar[str] = "teeth"

    @property
    def message(self) -> str:
        """Working angle, contact ratio, backlash and mean stiffness as text."""
        values = self.values
        ratio = f"contact ratio {values['contact_ratio']:.4g}"
        if values["overlap_ratio"]:
            ratio += f" + {values['overlap_ratio']:.4g}"
        stiffness = self.ds["mesh_stiffness"].values
        return (
            f"{self.ds.attrs['mesh']}: {ratio}, working pressure angle {math.degrees(values['working_pressure_angle']):.4f} deg "
            f"at {1e3 * values['center_distance']:.6g} mm, backlash {1e6 * values['backlash']:.4g} um, stiffness "
            f"{1e-6 * values['mean_stiffness']:.4g} N/um ({1e-6 * stiffness.min():.4g} to {1e-6 * stiffness.max():.4g})."
        )

    @property
    def values(self) -> dict[str, Any]:
        """Numbers of the pair [SI] by name."""
        return dict(json.loads(self.ds.attrs["pair"]))

    @property
    def gears(self) -> dict[str, dict[str, Any]]:
        """Numbers of both gears [SI] by name of the gear."""
        return dict(json.loads(self.ds.attrs["gears"]))

    def rows(self) -> Sequence[tuple[str, str]]:
        """Return the table of the drawing: names and values as text."""
        return drawing_rows(self.gears, self.values)

    def plot(self) -> Any:
        """Return a figure: teeth in mesh with the path of contact, stiffness, load sharing, contact ratio over the centres."""
        from gearplay.gear_pairs.figures import teeth_drawing

        return teeth_drawing(self)


def teeth(source: Source, mesh: str | int | None = None) -> Teeth:
    """Return the geometry of a gear pair as drawn, its path of contact and its stiffness.

    Everything at the nominal centres of the case; tooth thicknesses in the middle of their allowances.

    Parameters
    ----------
    source
        A `Case`, a bundled name, a path or a mapping.
    mesh
        Name of the mesh, ``driver-driven``, or its place in the case; may be left out where there is one.

    Returns
    -------
    Teeth
        ``.ds``, ``.values`` of the pair and ``.gears`` [SI], ``.rows()`` of a drawing's table, ``.plot()``.

    Raises
    ------
    InputError
        For a case without that mesh, or centres at which it cannot mesh.

    Examples
    --------
    >>> import gearplay as gp
    >>> found = gp.teeth("han2021")
    >>> round(found.values["contact_ratio"], 4), round(found.values["working_pressure_angle"], 4)
    (1.937, 0.3491)

    """
    case = case_of(source)
    return Teeth(_dataset(case, mesh_number(case, mesh)))


def mesh_number(case: Case, mesh: str | int | None) -> int:
    """Return the index of a mesh given by name or number, by default of the only one."""
    labels = [each.label for each in case.meshes]
    if isinstance(mesh, str) and mesh in labels:
        return labels.index(mesh)
    if isinstance(mesh, str) and mesh.isdecimal():
        mesh = int(mesh)
    if isinstance(mesh, int) and 0 <= mesh < len(labels):
        return mesh
    if mesh is None and len(labels) == 1:
        return 0
    rule = "must name a mesh" if labels else "must have a mesh"
    cure = f"Meshes: {listed(labels)}" if labels else "Add one"
    raise InputError.of("mesh", "none" if mesh is None else mesh, rule, cure)


def _dataset(case: Case, j: int) -> xr.Dataset:
    import xarray as xr

    pair = geometry.installed_pair(case, j)
    if math.isnan(pair.working_angle):
        rule = f"must be above {1e3 * pair.least_distance:.6g} mm for these teeth to mesh"
        raise InputError.of(
            case.settable_path(f"meshes.{j}"), f"{1e3 * pair.distance:.6g} mm", rule, "Correct the positions"
        )
    pitch, path = pair.first.base_pitch, pair.path
    places = np.linspace(path.start - 0.25 * pitch, path.end + 0.25 * pitch, PLACES)
    phases = np.linspace(0.0, 1.0, PHASES)
    variables: dict[str, Any] = {
        "base_gap": _of(
            "place", tip_gaps(pair, places), "m", "gap without load, that of tips beyond the path"
        ),
        "sliding_speed": _of(
            "place", pair.sliding(places), "m", "sliding speed of the flanks over the first gear's speed"
        ),
    }
    coordinates = {
        "place": _of(
            "place", places, "m", "place on the line of action, from the first gear's base tangent point"
        ),
        "phase": _of("phase", phases, "1", "phase in base pitches, 0 where a pair passes the pitch point"),
        "gear": ("gear", list(geometry.gears_of_pair(case, j)), {"long_name": "gear"}),
    }
    coordinates |= _stiffness_variables(case, j, variables, phases)
    coordinates |= _distance_variables(case, j, pair, variables)
    for name, outline in zip(("first", "second"), closed_teeth(pair, DRAWN_TEETH), strict=True):
        words = f"outline of teeth of the {name} gear in mesh, the first gear's centre at 0"
        variables[f"outline_{name}"] = (
            (f"point_{name}", "axis"),
            outline,
            {"units": "m", "long_name": words},
        )
    values = pair_values(case, j) | {"mean_stiffness": pack_stiffness(case, j).average}
    attributes = provenance(
        case,
        mesh=case.meshes[j].label,
        pair=json.dumps(values),
        gears=json.dumps(gear_tables(case, j)),
    )
    return xr.Dataset(variables, coords=coordinates, attrs=attributes)


def _of(dims: str | tuple[str, ...], values: Any, unit: str, words: str) -> tuple[Any, Any, dict[str, str]]:
    return dims, values, {"units": unit, "long_name": words}


def _stiffness_variables(case: Case, j: int, variables: dict[str, Any], phases: Any) -> dict[str, Any]:
    """Add stiffness over a mesh period, and of stiffness from the teeth that of each pair; return their coordinates."""
    if not isinstance(case.meshes[j].stiffness, TeethStiffness):
        sense = 1.0 if forwards(case, j) else -1.0
        psi = 2.0 * np.pi * sense * phases - case.meshes[j].friction_phase
        total = pack_stiffness(case, j).at(psi)
        variables["mesh_stiffness"] = _of("phase", total, "N/m", "mesh stiffness over a mesh period")
        return {}
    found = stiffness_over_path(case, j)
    variables["mesh_stiffness"] = _of(
        "phase", found.total(phases), "N/m", "mesh stiffness over a mesh period"
    )
    variables["pairs_in_contact"] = _of(
        "phase", found.pairs_in_contact(phases), "1", "pairs of teeth in contact"
    )
    force = float(tooth_loads(case)[j])
    nominal = force or found.peak * LIGHTEST
    deflection, forces, numbers = static_sharing(found, nominal, phases)
    places = found.pair.pitch_place + (phases[:, None] + numbers) * found.pair.first.base_pitch
    both = ("phase", "pair")
    variables["pair_stiffness"] = _of(both, found.single(places), "N/m", "stiffness of each pair of teeth")
    variables["load_sharing_ratio"] = _of(
        both, forces / nominal, "1", "share of each pair of teeth in the force at rest"
    )
    if force:
        words = "static transmission error under the load of the case"
        variables["static_transmission_error"] = _of("phase", deflection, "m", words)
    return {"pair": ("pair", numbers, {"long_name": "pair of teeth, 0 passes the pitch point at phase 0"})}


LIGHTEST = 1e-9
"""Deflection [m] at which load is shared where a case has no load: only the pairs on the path carry."""


def _distance_variables(case: Case, j: int, pair: GearPair, variables: dict[str, Any]) -> dict[str, Any]:
    """Add the variables over centre distance and over the clearance circle; return their coordinates."""
    play = sum(geometry.clearance_of(case, name) or 0.0 for name in case.meshes[j].rotors)
    around = 1.2 * play or AROUND * pair.first.module
    low, high = pair.range_of_distances
    distances = np.linspace(max(pair.distance - around, low), min(pair.distance + around, high), DISTANCES)
    directions = np.linspace(0.0, 2.0 * np.pi, DIRECTIONS)
    circle = np.hypot(pair.distance + play * np.cos(directions), play * np.sin(directions))
    apart = geometry.installed_backlash(case, j) - pair.backlash
    for dim, ending, values in (("center_distance", "", distances), ("direction", "_on_circle", circle)):
        where = "centre distance" if not ending else "direction of the centres on their clearance circle"
        at = [pair.at(float(distance)) for distance in values]
        normal = math.cos(pair.first.base_helix)
        variables |= {
            f"contact_ratio{ending}": _of(
                dim, [each.contact_ratio for each in at], "1", f"contact ratio over the {where}"
            ),
            f"working_pressure_angle{ending}": _of(
                dim, [each.working_angle for each in at], "rad", f"working pressure angle over the {where}"
            ),
            f"backlash{ending}": _of(
                dim,
                [(each.backlash + apart) * normal for each in at],
                "m",
                f"normal backlash over the {where}",
            ),
        }
    return {
        "center_distance": _of("center_distance", distances, "m", "centre distance"),
        "direction": _of(
            "direction", directions, "rad", "direction of the displacement of the centres, 0 apart"
        ),
    }
