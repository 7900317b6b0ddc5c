"""Result of `lost_motion`: dataset, message, table, picture."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from gearplay.hysteresis.cycle import ARCMIN, SMALL, Curve, Numbers
from gearplay.results.base import OfDataset

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure


STAGE_NAMES = ("K1", "K2", "K3")
OVERLAP = 1.02
"""Sum of the shares of clearances above which some are in parallel."""
WORDS = {
    "lost_motion": ("rad", "lost motion at 3 % of the rated torque"),
    "backlash": ("rad", "width of the hysteresis curve at no torque"),
    "torsional_stiffness": ("N m/rad", "torsional stiffness above 15 % of the rated torque"),
    "stiffness": ("N m/rad", "torsional stiffness in stages"),
    "hysteresis_loss": ("J", "work of friction in one cycle of the torque"),
}
"""Unit and long name of the key numbers."""
FIELDS = {
    "lost_motion": "lost_motion",
    "backlash": "backlash",
    "torsional_stiffness": "stiffness",
    "stiffness": "stages",
    "hysteresis_loss": "loss",
}
"""Field of `Numbers` behind each."""
OVER = {
    "position": ("rad", "angle of the output"),
    "member": ("1", "member"),
    "temperature": ("K", "temperature of the environment"),
}


def in_arcmin(name: str, values: Any) -> tuple[Any, str] | None:
    """Return values [rad] or [N m/rad] converted to arcmin, and the unit; None for quantities without an angle."""
    if name in ("lost_motion", "backlash"):
        return values * ARCMIN, "arcmin"
    return (values / ARCMIN, "N m/arcmin") if "stiffness" in name else None


def variables_of(found: Sequence[Numbers] | Numbers, dim: str = "") -> dict[str, Any]:
    """Return the variables of key numbers, along a dimension if they are several."""
    made: dict[str, Any] = {}
    for name, field in FIELDS.items():
        values = np.array(
            getattr(found, field) if isinstance(found, Numbers) else [getattr(each, field) for each in found]
        )
        dims = ((dim,) if dim else ()) + (("stage",) if name == "stiffness" else ())
        unit, words = WORDS[name]
        over = f", by {dim}" if dim else ""
        tail = f"_by_{dim}" if dim else ""
        made[f"{name}{tail}"] = (dims, values, {"units": unit, "long_name": f"{words}{over}"})
        small = in_arcmin(name, values)
        if small is not None:
            made[f"{name}_arcmin{tail}"] = (
                dims,
                small[0],
                {"units": small[1], "long_name": f"{words}{over}"},
            )
    return made


def dataset_of(
    curve: Curve,
    found: Numbers,
    ends: Sequence[float],
    rated: float,
    parts: Mapping[str, float],
    more: Mapping[str, tuple[Any, list[Numbers]]],
    attributes: Mapping[str, Any],
) -> xr.Dataset:
    """Return the dataset of a curve and its numbers; ``more`` are numbers by position, member, temperature."""
    import xarray as xr

    variables = variables_of(found)
    variables["angle"] = (
        ("branch", "torque"),
        curve.angle,
        {"units": "rad", "long_name": "rotation of the output"},
    )
    variables["tangent_stiffness"] = (
        ("branch", "torque"), curve.tangent, {"units": "N m/rad", "long_name": "slope of torque over rotation"},
    )  # fmt: skip
    variables["stage_end"] = (
        ("stage",),
        np.array([*ends, rated]),
        {"units": "N m", "long_name": "end of the stage"},
    )
    coords: dict[str, Any] = {
        "branch": (
            "branch",
            ["unloading", "loading"],
            {"long_name": "branch, from the positive end of the torque"},
        ),
        "torque": ("torque", curve.torque, {"units": "N m", "long_name": "torque on the output"}),
        "stage": ("stage", list(STAGE_NAMES), {"long_name": "stage of the stiffness"}),
    }
    if parts:
        values = np.array(list(parts.values()))
        coords["clearance"] = ("clearance", list(parts), {"long_name": "clearance"})
        words = "decrease of the lost motion with this clearance 0"
        variables["lost_motion_part"] = (("clearance",), values, {"units": "rad", "long_name": words})
        share = values / found.lost_motion if found.lost_motion > 0.0 else np.zeros(len(values))
        variables["lost_motion_share"] = (
            ("clearance",),
            share,
            {"units": "1", "long_name": f"{words}, of the whole"},
        )
    for dim, (places, rows) in more.items():
        unit, words = OVER[dim]
        coords[dim] = (dim, places, {"units": unit, "long_name": words})
        variables |= variables_of(rows, dim)
    return xr.Dataset(variables, coords=coords, attrs=dict(attributes))


def _friction_caution(ds: xr.Dataset) -> str:
    """Return a clause where friction exceeds 3 % of the rated torque, so that the lost motion leaves out the play."""
    unloading, loading = (ds["angle"].sel(branch=name) for name in ("unloading", "loading"))
    at_small = float((unloading - loading).interp(torque=SMALL * ds.attrs["rated_torque"]))
    whole = float(ds["backlash"])
    if at_small < 0.5 * whole or float(ds["lost_motion"]) > 0.5 * whole:
        return ""
    return (
        f"; friction exceeds {100.0 * SMALL:g} % of the rated torque, so this lost motion does not include the play: "
        + ("take the fitted play" if "play" in ds else "take the backlash, or set load.friction to 0")
    )


@dataclass(frozen=True, repr=False)
class LostMotion(OfDataset):
    """Hysteresis curve of a train whose input is held, and its key numbers.

    ``ds``: ``lost_motion``, ``backlash`` [rad], ``torsional_stiffness``, ``stiffness`` (stage) [N m/rad], each also with
    ``_arcmin``; ``hysteresis_loss`` [J]; ``angle`` and ``tangent_stiffness`` (branch, torque); ``lost_motion_part`` [rad] and
    ``lost_motion_share`` (clearance): by how much the lost motion shrinks with this clearance set to 0. With ``_by_position``,
    ``_by_member``, ``_by_temperature`` the numbers over the output's turn, drawn members, temperatures. Of a measured curve
    ``..._interval`` (.., bound), ``measured_torque`` and ``measured_angle`` (sample).
    """

    result_kind = "lost motion"

    @property
    def message(self) -> str:
        """Lost motion, backlash and stiffness as text."""
        ds = self.dataset
        lost, play, stiff = (
            float(ds[name])
            for name in ("lost_motion_arcmin", "backlash_arcmin", "torsional_stiffness_arcmin")
        )
        words = (
            f"{lost:.4g} arcmin of lost motion at 3 % of {ds.attrs['rated_torque']:.6g} N m, {play:.4g} arcmin of backlash, "
            f"{stiff:.4g} N m/arcmin"
        )
        for dim, title in (("member", "members"), ("position", "positions"), ("temperature", "temperatures")):
            if dim in ds.dims:
                values = ds[f"lost_motion_arcmin_by_{dim}"].values
                words += f"; {values.min():.4g} to {values.max():.4g} arcmin over {values.size} {title}"
                if dim == "member":
                    words += f" ({ds.attrs['scatter']})"
        return words + _friction_caution(ds)

    def rows(self) -> Sequence[tuple[str, str]]:
        """Return the key numbers, and the share of each clearance."""
        ds, found = self.dataset, []
        for name, title, small in (
            ("lost_motion", "lost motion", "arcmin"),
            ("backlash", "backlash", "arcmin"),
            ("torsional_stiffness", "stiffness above 15 %", "N m/arcmin"),
        ):
            value = float(ds[f"{name}_arcmin"])
            found.append(
                (
                    title,
                    f"{value:.4g} {small}{self._interval(f'{name}_arcmin')} = {float(ds[name]):.6g} {WORDS[name][0]}",
                )
            )
        low = 0.0
        for k, stage in enumerate(STAGE_NAMES):
            end, value = float(ds["stage_end"][k]), float(ds["stiffness_arcmin"][k])
            shown = f"{value:.4g} N m/arcmin{self._interval('stiffness_arcmin', k)}"
            found.append((stage, f"{shown}, {low:.4g} to {end:.4g} N m"))
            low = end
        found.append(
            ("hysteresis loss", f"{float(ds['hysteresis_loss']):.4g} J{self._interval('hysteresis_loss')}")
        )
        if "play" in ds:
            found.append(
                ("play, without friction", f"{float(ds['play']) * ARCMIN:.4g} arcmin{self._play_interval()}")
            )
            found.append(("friction", f"{float(ds['friction']):.4g} N m{self._interval('friction')}"))
        if "clearance" in ds.dims:
            for k in np.argsort(-ds["lost_motion_part"].values).tolist():
                part, share = float(ds["lost_motion_part"][k]), float(ds["lost_motion_share"][k])
                name = str(ds["clearance"].values[k])
                found.append((name, f"{part * ARCMIN:.4g} arcmin less without it, {100.0 * share:.3g} %"))
            whole = float(ds["lost_motion_share"].sum())
            if whole > OVERLAP:
                text = f"{100.0 * whole:.0f} %: clearances in parallel overlap, as without any of them their play is gone"
                found.append(("sum of these", text))
        return found

    def _play_interval(self) -> str:
        low, high = self.dataset["play_interval"].values * ARCMIN
        return f" ({low:.4g} to {high:.4g})"

    def _interval(self, name: str, place: int | None = None) -> str:
        if f"{name}_interval" not in self.dataset:
            return ""
        values = self.dataset[f"{name}_interval"].values
        low, high = values if place is None else values[place]
        return f" ({low:.4g} to {high:.4g})"

    def plot(self) -> Figure:
        """Draw the hysteresis curve and the parts of the lost motion; return the figure."""
        from gearplay.hysteresis.figures import lost_motion_drawing

        drawn: Figure = lost_motion_drawing(self.dataset)
        return drawn
