"""Figures of portraits: orbits in the clearance circles and phase portraits, with sections."""

import json
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gearplay.model.case import Case
from gearplay.model.reading import load_case
from gearplay.pictures.canvas import SMALL, legend_mark, make_figure, set_legend, set_title
from gearplay.pictures.extremes import thinned_path
from gearplay.pictures.style import CLEARANCE, COUPLED, MOST_POINTS, draw_circle, is_still, note_still
from gearplay.pictures.words import plain, shown_in
from gearplay.results.titles import words_of
from gearplay.vocabulary.errors import InputError

if TYPE_CHECKING:
    import xarray as xr

Floats = NDArray[np.float64]
SECTION, ONSET = "#b02a4c", "#e0a100"
PLANES = (("x", "y"), ("x", "vx"), ("y", "vy"), ("theta", "omega"))
SYMBOLS = {
    "x": "x",
    "y": "y",
    "vx": "dx/dt",
    "vy": "dy/dt",
    "theta": "rotation relative\nto the nominal one",
    "omega": "speed relative\nto the nominal one",
}
MOST_ROTORS, MOST_ONSETS = 12, 600


def portrait_drawing(portrait: "xr.Dataset", *, rotors: tuple[str, ...] = (), title: str = "") -> Any:
    """Return the figure of a portrait: for each rotor its orbit and the phase portraits of all that is free to move.

    ``portrait`` is that of `gearplay.portrait`; ``rotors`` chooses among its rotors. Sections are dots, onsets of contacts
    crosses. A rotor in a sleeve on the ground is shown in its clearance circle.

    Raises `InputError` where nothing of the chosen rotors is free to move.
    """
    case = load_case(json.loads(portrait.attrs["case"]))
    chosen = tuple(dict.fromkeys(rotors)) or tuple(case.rotors)
    panels = [
        (rotor, *plane)
        for rotor in chosen[:MOST_ROTORS]
        for plane in PLANES
        if all(f"path.{rotor}.{name}" in portrait for name in plane)
    ]
    if not panels:
        rule = "must name a rotor that is free to move or turn"
        raise InputError.of("rotor", ", ".join(chosen), rule, "Leave it out to see all that are")
    shown = list(dict.fromkeys(rotor for rotor, _, _ in panels))
    alone = len(shown) == 1  # in two columns, else each rotor in its row
    columns = min(2, len(panels)) if alone else len(PLANES)
    rows = -(-len(panels) // columns) if alone else len(shown)
    figure, axes = make_figure(rows, columns, 0.8 + rows * (3.6 if alone else 2.4))
    places = list(axes.flat)
    if not alone:
        places = [axes[shown.index(rotor), PLANES.index((across, up))] for rotor, across, up in panels]
    for ax in axes.flat:
        ax.set_visible(ax in places[: len(panels)])
    for ax, (rotor, across, up) in zip(places, panels, strict=False):
        _plane(ax, portrait, case, rotor, across, up)
    handles = {
        "path": legend_mark(COUPLED, line="-"),
        "once per period": legend_mark(SECTION, marker="o"),
    }
    if portrait.sizes["onset_time"]:
        handles["a contact begins"] = legend_mark(ONSET, marker="x")
    if any(_clearance(case, rotor) for rotor in chosen):
        handles["clearance circle"] = legend_mark(CLEARANCE, line="--")
    set_legend(figure, handles)
    more = f" (the first {MOST_ROTORS} of {len(chosen)} rotors)" if len(chosen) > MOST_ROTORS else ""
    set_title(figure, (title or f"{words_of(portrait, 'Portrait')}: portrait") + more)
    return figure


def _clearance(case: Case, rotor: str) -> float:
    """Return the radial clearance [m] of a rotor's sleeve on the ground, 0 without one."""
    sleeve = case.operating.sleeves.get(rotor)
    return sleeve.radial_clearance if sleeve is not None and sleeve.on is None else 0.0


def _contacts(case: Case, rotor: str) -> list[str]:
    """Return the names of the contacts that touch a rotor: its sleeve, those on it, the flanks of its meshes."""
    sleeves = [name for name, sleeve in case.sleeves.items() if rotor in (name, sleeve.on)]
    meshes = [mesh.label for mesh in case.meshes if rotor in mesh.rotors]
    return sleeves + [f"{label}:{flank}" for label in meshes for flank in ("drive", "back")]


def _plane(ax: Any, portrait: "xr.Dataset", case: Case, rotor: str, across: str, up: str) -> None:
    """Draw one plane: path, section, onsets."""
    scales = []
    for name in (across, up):
        variable = portrait[f"path.{rotor}.{name}"]
        scales.append(shown_in(variable.attrs["units"], float(np.abs(variable.values).max())))
    clearance = _clearance(case, rotor) if (across, up) == ("x", "y") else 0.0
    if (across, up) == ("x", "y"):
        scales = [max(scales, key=lambda s: -s[1])] * 2  # one unit for both
        ax.set_aspect("equal", adjustable="datalim")
    factors = [factor for _, factor in scales]
    if clearance > 0.0:
        draw_circle(ax, factors[0] * clearance)  # both axes have one unit

    def points(kind: str) -> list[Floats]:
        return [
            factor * portrait[f"{kind}.{rotor}.{name}"].values
            for name, factor in zip((across, up), factors, strict=True)
        ]

    own = np.flatnonzero(np.isin(portrait["contact"].values.astype(str), _contacts(case, rotor)))
    own = own[:: -(-max(1, own.size) // MOST_ONSETS)]
    ax.plot(*(p[own] for p in points("onset")), "x", color=ONSET, markersize=2.6, markeredgewidth=0.6)
    x, y = points("path")
    ax.plot(*thinned_path(x, y, MOST_POINTS), color=COUPLED, linewidth=0.6)
    ax.plot(*points("section"), "o", color=SECTION, markersize=1.8)
    paths = [portrait[f"path.{rotor}.{name}"] for name in (across, up)]
    if all(is_still(each.values, each.attrs["units"]) for each in paths):
        middle = [float(np.mean(each)) for each in (x, y)]
        ax.set(xlim=(middle[0] - 1.0, middle[0] + 1.0), ylim=(middle[1] - 1.0, middle[1] + 1.0))
        note_still(ax, paths[0].attrs["units"])
    ax.locator_params(nbins=4)
    ax.set_xlabel(f"{SYMBOLS[across]} [{scales[0][0]}]", fontsize=SMALL)
    ax.set_ylabel(f"{SYMBOLS[up]} [{scales[1][0]}]", fontsize=SMALL)
    ax.set_title(plain(rotor), fontsize=SMALL)
