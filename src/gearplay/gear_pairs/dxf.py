"""`export_dxf`: the gears of a case with their teeth, at their places, as a drawing in DXF."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from gearplay.files.atomic import check_new, write_with
from gearplay.parts.mesh.train import geometry
from gearplay.pictures.gears import phases
from gearplay.results.mechanism import placed
from gearplay.results.simulate import case_of
from gearplay.toothing.outline import teeth_at
from gearplay.vocabulary.errors import InputError
from gearplay.vocabulary.optional import load_optional

if TYPE_CHECKING:
    from gearplay.model.case import Case
    from gearplay.model.reading import Source
    from gearplay.toothing.gear import DrawnGear

ENDING: Final = ".dxf"
MM: Final = 1e3
POINTS: Final = 40
"""Points of a flank and of a fillet: their chords are within 0.5 um of the curve at module 4 mm."""
MILLIMETRES, METRIC = 4, 1
"""Codes of ``$INSUNITS`` and ``$MEASUREMENT``."""
CIRCLES, CLEARANCE = " (circles)", " (clearance)"
"""Endings of the layers of a rotor."""
COLORS: Final = (4, 30, 3, 6, 140, 1)
"""Colour numbers of the rotors, one after the other."""
GREY: Final = 8
SAME: Final = 1e-12
"""Distance [m] of points that are one."""


def export_dxf(case: Source, path: str | os.PathLike[str], *, overwrite: bool = False) -> Path:
    """Write the gears of a case at their nominal centres as a drawing in DXF, in mm.

    Each rotor has three layers. ``NAME``: its centre, the closed outline of each of its gears, a bore. ``NAME (circles)``:
    reference, base, tip and root circles. ``NAME (clearance)``: the circle that its centre may reach in its bearing.
    Outlines are polylines with fillets as the rack cuts them, arcs at tip and root; a ring's is that of its spaces. Teeth stand
    in the middle of the spaces they mesh with, with the transverse section of helical gears, thicknesses in the middle of
    their allowances. Of a backlash that the case gives beyond that of the thicknesses, each gear takes half; a gear in several
    meshes the smallest.

    Parameters
    ----------
    case
        A `Case`, a bundled name, a path or a mapping.
    path
        The file, ``gears.dxf``.
    overwrite
        Whether an existing file is replaced.

    Returns
    -------
    pathlib.Path
        The file.

    Raises
    ------
    InputError
        For a case without meshes, gears that cannot mesh at their centres, a file that cannot be written, and without ``ezdxf``.

    Examples
    --------
    >>> import tempfile, gearplay as gp
    >>> gp.export_dxf("han2021", tempfile.mkdtemp() + "/gears.dxf").name
    'gears.dxf'

    """
    file = Path(path)
    if file.suffix.lower() != ENDING:
        raise InputError.of(
            "out", file.name, f"must end in {ENDING}", f"Write {file.stem or 'gears'}{ENDING}"
        )
    check_new(file, overwrite=overwrite)
    given = case_of(case)
    if not given.meshes:
        rule = "must have a mesh, by which its gears have a module"
        raise InputError.of("meshes", "none", rule, "Add one")
    drawing = _drawing(given)
    write_with(file, drawing.saveas, overwrite=overwrite)
    return file


def _drawing(case: Case) -> Any:
    """Return the drawing of a case at its temperature, an `ezdxf.document.Drawing`."""
    ezdxf = load_optional("ezdxf", "dxf")
    document = ezdxf.new("R2010", units=MILLIMETRES)
    document.header["$MEASUREMENT"] = METRIC
    space, mechanism = document.modelspace(), placed(case)
    turned, case = phases(mechanism["gears"], mechanism["meshes"]), case.operating
    gears = drawn_gears(case)
    for i, (rotor, (x, y)) in enumerate(geometry.centres(case).items()):
        centre = (MM * x, MM * y)
        _layer(document, rotor, COLORS[i % len(COLORS)])
        space.add_point(centre, dxfattribs={"layer": rotor})
        for name, toothing in geometry.toothings(case, rotor).items():
            if name not in gears:
                continue
            gear, circles = gears[name], rotor + CIRCLES
            points = [(MM * (x + a), MM * (y + b), bulge) for a, b, bulge in outline(gear, turned[name])]
            space.add_lwpolyline(points, format="xyb", close=True, dxfattribs={"layer": rotor})
            if toothing.bore is not None:
                space.add_circle(centre, 0.5 * MM * toothing.bore, dxfattribs={"layer": rotor})
            _layer(document, circles, GREY)
            for radius in (gear.reference_radius, gear.base_radius, gear.tip, gear.root):
                space.add_circle(centre, MM * radius, dxfattribs={"layer": circles})
        clearance = geometry.clearance_of(case, rotor)
        if clearance:
            _layer(document, rotor + CLEARANCE, GREY)
            space.add_circle(centre, MM * clearance, dxfattribs={"layer": rotor + CLEARANCE})
    return document


def _layer(document: Any, name: str, color: int) -> None:
    """Add a layer where there is none; names of layers are case-insensitive."""
    if name not in document.layers:
        document.layers.add(name, color=color)


def drawn_gears(case: Case) -> Mapping[str, DrawnGear]:
    """Return the gears in meshes by their full names, with teeth as thick as the backlashes of the case leave them."""
    gears: dict[str, DrawnGear] = {}
    thinner: dict[str, float] = {}
    for j in range(len(case.meshes)):
        pair = geometry.installed_pair(case, j)
        if math.isnan(pair.working_angle):
            rule = f"must be above {MM * pair.least_distance:.6g} mm for these teeth to mesh"
            raise InputError.of(
                case.settable_path(f"meshes.{j}"),
                f"{MM * pair.distance:.6g} mm",
                rule,
                "Correct the positions",
            )
        arc = (
            0.5
            * (geometry.installed_backlash(case, j) - pair.backlash)
            / math.cos(pair.first.transverse_angle)
        )
        for called, gear in zip(geometry.gears_of_pair(case, j), (pair.first, pair.second), strict=True):
            name, change = geometry.full_name(case, called), arc * math.cos(gear.helix_angle)
            gears[name], thinner[name] = gear, min(change, thinner.get(name, math.inf))
    return {
        name: replace(gear, thickness_change=gear.thickness_change - thinner[name])
        for name, gear in gears.items()
    }


def outline(gear: DrawnGear, middle: float) -> list[tuple[float, float, float]]:
    """Return the closed outline of all teeth of a gear about its centre, of a ring of its spaces: x, y [m] and bulges.

    A tooth, of a ring a space, lies at ``middle`` [rad]. The bulge is tan(angle / 4) of the arc to the next point, 0 of a
    straight line; lands at tip and root are arcs.
    """
    points = teeth_at(gear, middle, range(gear.teeth), POINTS)
    angle = np.arctan2(points[:, 1], points[:, 0])
    ahead = np.mod(np.roll(angle, -1) - angle + math.pi, 2.0 * math.pi) - math.pi
    flank = len(points) // (2 * gear.teeth)
    bulges = np.zeros(len(points))
    bulges[flank - 1 :: flank] = np.tan(0.25 * ahead[flank - 1 :: flank])
    kept = np.hypot(*(np.roll(points, -1, axis=0) - points).T) > SAME
    return [(x, y, bulge) for x, y, bulge in np.column_stack([points, bulges])[kept].tolist()]
