"""Findings about deviations of teeth: classes without effect, classes that eat the backlash, tip relief that is too long."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

from gearplay.parts.mesh.drawn_gears import follows_centres, gear_path
from gearplay.parts.mesh.train import geometry
from gearplay.schema.finding import Finding
from gearplay.toothing.quality import gear_tolerances

if TYPE_CHECKING:
    from gearplay.parts.mesh.train.train import Train
    from gearplay.toothing.pair import GearPair


FORM_LEFT_OUT = "the form, a sine, has no closed form along oblique lines of contact and is left out"


def deviation_findings(case: Train) -> Iterator[Finding]:
    """Yield findings about quality and tip relief, once for identical pairs, such as those of planets."""
    found = [each for j in range(len(case.meshes)) for each in _findings(case, j)]
    alike: dict[tuple[str, str], list[tuple[str, Finding]]] = {}
    for key, names, each in found:
        alike.setdefault((each.severity, key), []).append((names, each))
    for same in alike.values():
        labels = ", ".join(dict.fromkeys(names for names, _ in same))
        first = same[0][1]
        yield Finding(first.severity, first.path, f"{labels}: {first.message}")


def _findings(case: Train, j: int) -> Iterator[tuple[str, str, Finding]]:
    """Yield findings of mesh j, each after the key of those that are alike and the name of the mesh."""
    mesh = case.meshes[j]
    pair = geometry.installed_pair(case, j)
    drawn = dict(zip(geometry.gears_of_pair(case, j), (pair.first, pair.second), strict=True))
    given = {name: geometry.gear_of(case, name) for name in (mesh.driver, mesh.driven)}
    if not follows_centres(case):
        for name, gear in given.items():
            if gear.quality is not None:
                path = gear_path(case, name, "quality")
                words = (
                    f"quality = {gear.quality} of {name} has no effect where the line of action does not follow the centres. "
                    'Write backlash_model = "coupled", for which deviations are drawn.'
                )
                yield path, mesh.label, Finding("note", path, words)
        return
    for name, gear in given.items():
        if gear.quality is not None and gear.helix_angle:
            path = gear_path(case, name, "quality")
            counts, why = "pitch and profile slope count", FORM_LEFT_OUT
            if pair.facewidth is None:
                counts, why = "the pitch counts alone", "profile deviations need the facewidths of both gears"
            words = f"of the deviations that quality = {gear.quality} draws for {name} {counts}: {why}."
            yield path, mesh.label, Finding("note", path, words)
    allowed = {
        name: gear_tolerances(drawn[name], gear.quality).cumulative_pitch
        for name, gear in given.items()
        if gear.quality is not None
    }
    eaten = sum(allowed.values()) * math.cos(pair.first.transverse_angle)
    left = geometry.installed_backlash(case.operating, j)
    if eaten > left > 0.0:
        each = ", ".join(
            f"{1e6 * value:.4g} um of class {given[name].quality}" for name, value in allowed.items()
        )
        words = (
            f"the cumulative pitch deviations that ISO 1328-1 allows, {each}, add up to {1e6 * eaten:.4g} um along the line of "
            f"action, more than the backlash left, {1e6 * left:.4g} um: both flanks can touch at once. Raise the backlash or "
            "take finer classes."
        )
        yield words, mesh.label, Finding("warning", f"meshes.{j}.backlash", words)
    yield from _relieved(case, j, pair)


def _relieved(case: Train, j: int, pair: GearPair) -> Iterator[tuple[str, str, Finding]]:
    """Yield a finding for tip relief that leaves less of the path of contact as it is than one base pitch.

    Lines of contact of helical teeth need less by the way by which they shift over the facewidth.
    """
    mesh = case.meshes[j]
    reliefs = {
        name: relief
        for name in (mesh.driver, mesh.driven)
        if (relief := geometry.gear_of(case, name).tip_relief) is not None and relief.amount > 0.0
    }
    if not reliefs:
        return
    path = pair.path.end - pair.path.start
    pitch = pair.first.base_pitch
    left, needed = path - sum(relief.length for relief in reliefs.values()), max(pitch - pair.overlap, 0.0)
    if left >= needed or path < needed:
        return
    wide = f", at an overlap ratio of {pair.overlap_ratio:.3g}" if pair.overlap > 0.0 else ""
    lengths = " and ".join(f"{1e3 * relief.length:.4g} mm" for relief in reliefs.values())
    share = max(left / pitch, 0.0)
    words = (
        f"tip relief over {lengths} of the path of contact, {1e3 * path:.4g} mm, leaves {share:.3g} base pitches "
        f"without{wide}: at some phases every pair of teeth is relieved, and a transmission error is left without load. "
        f"Shorten it, to {1e3 * (path - needed):.4g} mm of both gears together."
    )
    where = gear_path(case, next(iter(reliefs)), "tip_relief", "length")
    yield words, mesh.label, Finding("warning", where, words)
