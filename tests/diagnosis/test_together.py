"""Causes that occur together: both stated, none beside them, each alone as before."""

from typing import Any

import pytest

import gearplay as gp
from gearplay.diagnosis.result import Diagnosis
from machine_records import BEARINGS, CONDITIONS, NAMES, machine_record

PAIR: dict[str, Any] = {"teeth": "23:61", "bearings": BEARINGS, "speed": "1500 rpm"}
TOGETHER = (
    "tooth 1 + inner 1", "tooth 2 + outer 2", "tooth 1 + outer 2", "tooth 1 + tooth 2", "tooth 1 + cage 1",
    "eccentric 1 + inner 1", "eccentric 2 + outer 1", "eccentric 2 + inner 2", "eccentric 1 + eccentric 2",
    "eccentric 1 + tooth 2", "eccentric 2 + tooth 1", "eccentric 1 + tooth 1", "inner 1 + outer 2", "outer 1 + inner 2",
    "inner 1 + outer 1", "inner 1 + inner 2", "outer 1 + outer 2", "rattle + outer 1", "rattle + inner 1",
    "rattle + tooth 1", "rattle + tooth 2", "rattle + eccentric 1",
)  # fmt: skip


def diagnosed(condition: str, seed: int, **more: Any) -> tuple[set[str], Diagnosis]:
    """Return the names of the causes of a record, and its diagnosis."""
    channel, _ = machine_record(condition, seed, **more)
    return {NAMES[each] for each in condition.split(" + ")}, gp.diagnose(channel, **PAIR)


@pytest.mark.parametrize(
    "condition", ["eccentric 1 + inner 1", "tooth 2 + outer 2", "inner 1 + outer 2", "rattle + inner 1"]
)
def test_two_causes__are_both_stated(condition: str) -> None:
    names, found = diagnosed(condition, 7000 if condition.startswith("inner") else 61)
    assert set(found.causes) == names
    assert found.told
    first, second = found.hypotheses()[:2]
    assert {first["name"], second["name"]} == names
    assert f"; together with {second['name']}, confidence {second['confidence']:.2f}: " in found.message


@pytest.mark.slow
def test_two_causes__in_forty_four_records_none_wrong_is_stated_and_three_of_four_pairs_are() -> None:
    every = [diagnosed(condition, seed) for seed in (6000, 6001) for condition in TOGETHER]
    assert [found.message for names, found in every if not set(found.causes) <= names] == []
    assert sum(set(found.causes) == names for names, found in every) >= 33
    assert all(found.told for _, found in every)


@pytest.mark.slow
def test_one_cause__no_second_one_is_stated() -> None:
    for seed, more in ((1000, {}), (1001, {}), (8, {"severity": 6.0})):
        for condition in CONDITIONS:
            names, found = diagnosed(condition, seed, **more)
            assert set(found.causes) <= names, found.message


def test_a_second_cause_with_a_twin__is_left_open() -> None:
    """A cage, of whose FTF BPFO is a multiple and whose lines lie near those of a turn, is a further cause that may be."""
    _, found = diagnosed("tooth 1 + cage 1", 7000)
    assert found.causes == [NAMES["tooth 1"]]
    said = " ".join(found.cannot_be_told)
    assert "Whether bearing 1, cage occurs as well cannot be told: confidence 0.60." in said
    assert "BPFO is a multiple of FTF: bearing 1, outer ring, cannot be ruled out." in said


def test_causes__come_back_from_a_file(tmp_path: Any) -> None:
    _, found = diagnosed("eccentric 1 + inner 1", 61)
    found.save(tmp_path / "d.nc")
    assert gp.read_result(tmp_path / "d.nc").causes == found.causes
