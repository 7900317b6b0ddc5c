"""`Wear`: depths of flanks and plain bearings over the life of a mechanism, backlash and clearance that follow."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from gearplay.life.bushes import SURFACES, worn_sleeves
from gearplay.life.flanks import worn_faults
from gearplay.model.reading import replace
from gearplay.results.base import Column, OfDataset, case_in

if TYPE_CHECKING:
    from gearplay.model.case import Case

COLUMNS = {
    "depth": Column(("turns", "flank", "height"), "m", "material worn off a flank, normal to it"),
    "worn_volume": Column(("turns", "flank"), "m^3", "volume worn off a flank of all teeth of a gear"),
    "line_load": Column(("block", "side", "height"), "N/m", "mean line load of a pair of teeth"),
    "backlash": Column(
        ("turns", "mesh"), "m", "normal backlash at the reference temperature, mean over a mesh period"
    ),
    "journal_depth": Column(("turns", "sleeve", "direction"), "m", "material worn off a journal"),
    "bush_depth": Column(("turns", "sleeve", "direction"), "m", "material worn off a bush"),
    "radial_clearance": Column(("turns", "sleeve"), "m", "radial clearance at the reference temperature"),
}
COORDINATES = {
    "turns": Column(("turns",), "1", "turns of the reference rotor"),
    "height": Column(("height",), "1", "place on a flank's path of contact, 0 at its root end, 1 at the tip"),
    "direction": Column(("direction",), "rad", "direction, of a journal in the frame that turns with it"),
    "flank": Column(("flank",), "", "gear and flank"),
    "side": Column(("side",), "", "mesh and side"),
    "mesh": Column(("mesh",), "", "mesh with wear"),
    "sleeve": Column(("sleeve",), "", "journal of the plain bearing"),
}


class Wear(OfDataset):
    """Wear of a mechanism over its life.

    ``ds`` has over the ``turns`` of the reference rotor: of flanks ``depth`` (turns, flank, height) [m], ``worn_volume`` (turns,
    flank) [m^3] and ``backlash`` (turns, mesh) [m], and the ``line_load`` (block, side, height) [N/m] of each simulated block; of
    plain bearings ``journal_depth`` and ``bush_depth`` (turns, sleeve, direction) [m] and ``radial_clearance`` (turns, sleeve)
    [m].
    """

    result_kind: ClassVar[str] = "wear"

    @property
    def message(self) -> str:
        """Turns, deepest wear, and whether blocks were too long, as text."""
        ds, blocks = self.ds, int(self.ds.attrs["blocks"])
        life = f"{float(ds['turns'][-1]):.4g} turns of {ds.attrs['rotor']}"
        parts = [f"{life} in {blocks} block{'s' * (blocks > 1)}"]
        if "depth" in ds:
            last = ds["depth"].values[-1]
            flank, height = np.unravel_index(np.argmax(last), last.shape)
            parts.append(
                f"deepest wear {1e6 * last[flank, height]:.4g} um on {ds['flank'].values[flank]} at height "
                f"{ds['height'].values[height]:.3g}"
            )
        parts += [
            f"{words} of {name} from {1e6 * first:.4g} to {1e6 * then:.4g} um"
            for variable, dim, words in (("backlash", "mesh", "backlash"), ("radial_clearance", "sleeve", "radial clearance"))
            if variable in ds
            for name, first, then in zip(
                ds[dim].values, ds[variable].values[0], ds[variable].values[-1], strict=True
            )
        ]  # fmt: skip
        deepest, bent = float(ds.attrs["deepest_step"]), float(ds.attrs["deflection"])
        text = "; ".join(parts)
        if deepest > 0.5 * bent > 0.0:
            text += (
                f". A block wears up to {1e6 * deepest:.3g} um, more than half the deflection of the teeth, "
                f"{1e6 * bent:.3g} um: take more blocks"
            )
        return text

    def rows(self) -> Sequence[tuple[str, str]]:
        """Return depth and volume of each flank, and depths of each journal and bush at the end."""
        ds, found = self.ds, []
        if "depth" in ds:
            for k, name in enumerate(ds["flank"].values):
                depth = 1e6 * ds["depth"].values[-1, k]
                volume = 1e9 * float(ds["worn_volume"].values[-1, k])
                found.append((str(name), f"{depth.min():.4g} to {depth.max():.4g} um, {volume:.4g} mm^3"))
        if "sleeve" in ds.dims:
            for k, name in enumerate(ds["sleeve"].values):
                for surface in SURFACES:
                    depth = 1e6 * ds[f"{surface}_depth"].values[-1, k]
                    found.append((f"{surface} of {name}", f"{depth.min():.4g} to {depth.max():.4g} um"))
        return found

    @property
    def worn_case(self) -> Case:
        """The case at the end of its life: worn profiles as faults, clearances and centres of bushes."""
        return self.case_at(-1)

    def case_at(self, step: int) -> Case:
        """Return the case at a step of its life, 0 the first, -1 the last."""
        ds = self.ds.isel(turns=step)
        flanks, sleeves = {}, {}
        if "depth" in ds:
            for name, depth in zip(ds["flank"].values, ds["depth"].values, strict=True):
                gear, _, flank = str(name).rpartition(" ")
                flanks[gear, flank] = depth
        if "sleeve" in ds.dims:
            for k, name in enumerate(ds["sleeve"].values):
                sleeves[str(name)] = {surface: ds[f"{surface}_depth"].values[k] for surface in SURFACES}
        return worn(case_in(self.ds), flanks, sleeves)

    def plot(self) -> Any:
        """Return a figure: depth over height of each flank, backlash and clearance over life, depths of bushes."""
        from gearplay.life.figures import wear_drawing

        return wear_drawing(self.ds)


def worn(case: Case, flanks: dict[tuple[str, str], Any], sleeves: dict[str, dict[str, Any]]) -> Case:
    """Return the case with worn flanks, depths [m] over height, and plain bearings, depths [m] over direction by surface."""
    changes: dict[str, Any] = {"faults": worn_faults(case, flanks)} if flanks else {}
    return replace(case, changes | worn_sleeves(case, sleeves))
