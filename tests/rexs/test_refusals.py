"""Gearboxes that a planar case cannot have, or that contradict themselves: refused in one sentence."""

from pathlib import Path
from typing import Any

import pytest

import gearplay as gp
from gearplay.rexs.importing import import_rexs
from rexs.gearbox_files import Box, pair, planetary


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"normal_module": (2.5, "mm")}, "one normal module"),
        ({"helix_angle_reference_diameter": (10.0, "deg")}, "one helix angle"),
        ({"number_of_teeth": 20.5}, "whole number of teeth"),
        ({"normal_module": (2.0, "kg")}, "is not a length"),
        ({"normal_module": (2.0, "parsnip")}, "unknown unit"),
        ({"normal_module": ("two", "mm")}, "must be a finite number"),
    ],
)
def test_pairs_that_do_not_fit_are_refused_in_one_sentence(tmp_path: Path, change: Any, words: str) -> None:
    box = pair()
    number = next(n for n, (kind, _, _) in box.components.items() if kind == "cylindrical_gear")
    kind, name, attributes = box.components[number]
    box.components[number] = (kind, name, {**attributes, **change})
    with pytest.raises(gp.InputError, match=words) as caught:
        import_rexs(box.write(tmp_path))
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("kind", "words"),
    [
        ("worm_stage", "axes of a worm stage cross"),
        ("bevel_stage", "axes of a bevel stage meet"),
        ("chain_stage", "no chain stage"),
    ],
)
def test_other_stages_are_refused_with_the_reason(tmp_path: Path, kind: str, words: str) -> None:
    box = pair()
    box.add(kind, "S")
    with pytest.raises(gp.InputError, match=words):
        import_rexs(box.write(tmp_path))


def test_crossed_axes_and_stepped_planets_are_refused(tmp_path: Path) -> None:
    box = pair()
    kind, name, attributes = box.components[4]
    box.components[4] = (kind, name, {**attributes, "u_axis_vector": ([0, 1, 0], "mm")})
    with pytest.raises(gp.InputError, match="axis parallel to that of"):
        import_rexs(box.write(tmp_path))
    box = Box()
    planetary(box, box.add("gear_casing"))
    planet = next(n for n, (kind, name, _) in box.components.items() if name == "Planet")
    box.gear(planet, 30, 3.0)
    with pytest.raises(gp.InputError, match=r"one gear on each planet shaft.*Stepped planets"):
        import_rexs(box.write(tmp_path))


def test_a_set_that_cannot_be_assembled_is_refused(tmp_path: Path) -> None:
    box = Box()
    planetary(box, box.add("gear_casing"), planets=5)
    with pytest.raises(gp.InputError, match=r"planetary\.stage\.planets\.angles.*steps of 360"):
        import_rexs(box.write(tmp_path))


def test_arguments_are_refused_in_one_sentence(tmp_path: Path) -> None:
    path = pair().write(tmp_path)
    for arguments, words in (
        ({"load_case": 3}, "it has none"),
        ({"gear_bodies": "hollow"}, "must be none or solid"),
        ({"allowance": "c99"}, "series of DIN 3967"),
        ({"load_case": "one"}, "whole number"),
    ):
        with pytest.raises(gp.InputError, match=words):
            gp.import_rexs(path, **arguments)
