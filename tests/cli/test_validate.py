"""`gearplay validate`: the table, its JSON, and exit code 1 where a number is beyond its tolerance."""

import dataclasses
import json

import pytest

import gearplay as gp
from gearplay.cli.main import run
from gearplay.validation import published

FEW = tuple(each for each in published.COMPARISONS if each.topic in ("Events", "Bearings"))[:2]


def test_table(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setattr(published, "COMPARISONS", FEW)
    assert run(["validate"]) == 0
    out = capsys.readouterr().out
    assert "mesh frequency" in out
    assert "7 of 7 numbers, of 2 sources, within their tolerances." in out
    assert run(["validate", "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["passed"] is True
    assert [row["name"] for row in document["numbers"]][3:] == ["FTF", "BPFO", "BPFI", "BSF"]
    assert {row["source"] for row in document["numbers"]} == {each.source for each in FEW}


def test_a_deviation__exit_code_1(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    number = FEW[0].numbers[0]
    wrong = (dataclasses.replace(number, value=number.value + 0.01), *FEW[0].numbers[1:])
    monkeypatch.setattr(published, "COMPARISONS", (dataclasses.replace(FEW[0], numbers=wrong),))
    assert run(["validate"]) == 1
    out = capsys.readouterr().out
    assert "BEYOND ITS TOLERANCE" in out
    assert "Beyond: 17/37/91, sun at 800 rpm: mesh frequency." in out
    found = gp.validate()
    assert not found.passed
    assert found.ds["within"].values.tolist() == [0, 1, 1]


def test_missing_values_are_deviations(monkeypatch: pytest.MonkeyPatch) -> None:
    short = dataclasses.replace(FEW[1], measure=lambda: FEW[1].measure()[:2])
    monkeypatch.setattr(published, "COMPARISONS", (short,))
    assert gp.validate().ds["within"].values.tolist() == [1, 1, 0, 0]
