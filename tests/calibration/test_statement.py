"""A model is named only where it beats every other, in every reading."""

import pytest

from gearplay.calibration.model_comparison import OPEN, Standing, conclude


def standing(model: str, evidence: float, *, predictive: float | None = None) -> Standing:
    """Return a standing over three conditions whose predictions are ahead as evenly as the evidence."""
    level = evidence if predictive is None else predictive
    return Standing(model, -2.0 * evidence, evidence, 0.1, {"a": level, "b": level + 0.5, "c": level + 1.0})


GOOD, MIDDLE, BAD = standing("good", 20.0), standing("middle", 10.0), standing("bad", 0.0)


def test_the_winner_of_every_reading_is_named() -> None:
    found = conclude({"absolute": [BAD, GOOD, MIDDLE], "displacement": [GOOD, BAD, MIDDLE]})
    assert found.overall == "good"
    assert [each.winner for each in found.readings] == ["good", "good"]
    assert found.words == (
        "good explains the data better than every other model, in every reading (absolute, displacement)."
    )
    assert len(found.readings[0].pairs) == 3


def test_readings_that_disagree_tell_nothing() -> None:
    found = conclude(
        {"absolute": [GOOD, BAD], "displacement": [standing("good", 0.0), standing("bad", 20.0)]}
    )
    assert found.overall == OPEN
    assert [each.winner for each in found.readings] == ["good", "bad"]
    assert found.words == f"{OPEN}: the readings disagree (absolute: good; displacement: bad)."


def test_one_open_reading_leaves_the_whole_open() -> None:
    found = conclude({"absolute": [GOOD, BAD], "displacement": [standing("good", 1.0), BAD]})
    assert [each.winner for each in found.readings] == ["good", OPEN]
    assert found.overall == OPEN
    assert found.words.startswith(f"{OPEN}: not every reading has one model ahead")


def test_beating_only_some_of_the_others_is_not_enough() -> None:
    found = conclude({"absolute": [GOOD, standing("rival", 19.0), BAD]})
    assert any(pair.winner == "good" for pair in found.readings[0].pairs)
    assert found.overall == OPEN
    assert found.words == f"{OPEN}: no model beats every other."


def test_evidence_without_prediction_is_not_enough() -> None:
    found = conclude({"absolute": [standing("good", 20.0, predictive=0.0), BAD]})
    assert found.overall == OPEN


@pytest.mark.parametrize("readings", [["absolute"], ["absolute", "displacement"]])
def test_a_model_alone_has_beaten_nobody(readings: list[str]) -> None:
    found = conclude({reading: [GOOD] for reading in readings})
    assert found.overall == OPEN
    assert "is the only model" in found.words


def test_a_model_missing_from_a_reading_was_not_beaten_there() -> None:
    found = conclude({"absolute": [GOOD, MIDDLE, BAD], "displacement": [GOOD, BAD]})
    assert [each.winner for each in found.readings] == ["good", "good"]
    assert found.overall == OPEN
    assert "not every model was compared" in found.words


def test_numbers_that_do_not_exist_tell_nothing() -> None:
    nan = float("nan")
    found = conclude({"absolute": [standing("good", nan), BAD]})
    assert found.overall == OPEN
    assert conclude({}).overall == OPEN
