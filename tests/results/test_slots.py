"""Slots of pairs of teeth: tables, lists and pictures have the flank for them."""

import re

import pytest

import gearplay as gp
from gearplay.model.pack import pack
from gearplay.web.frames import unpack_frame
from gearplay.web.maps import contacts_of, measures
from gearplay.web.tasks import TASKS
from page_jobs import STOP, quiet
from tooth_pairs import with_pairs

FLANKS = ["one-two:drive", "one-two:back"]


def test_the_page__has_flanks_only() -> None:
    """Table, strips of contact and measures of maps; each strip is as long as its share of the time."""
    case = with_pairs({"quality": 7}, {})
    assert "one-two:drive-3" in pack(case).contact_labels
    view = unpack_frame(TASKS["run"]({"case": case.resolved(), "models": ["coupled"]}, quiet, STOP))
    shown = view["models"]["coupled"]
    assert [strip["label"] for strip in shown["strip"]] == FLANKS
    for strip, each in zip(shown["strip"], shown["statistics"], strict=True):
        closed = float((strip["spans"][:, 1] - strip["spans"][:, 0]).sum())
        assert closed == pytest.approx(each["share_of_time"] * 0.02, abs=2e-6)
    assert list(dict.fromkeys(each["of"] for each in measures(case))) == ["one", "two", *FLANKS]
    assert contacts_of(case, "two") == FLANKS


def test_portrait__has_onsets_of_flanks() -> None:
    """Gears of class 9 rattle at this light load: onsets are of flanks, not of the slots of pairs."""
    case = gp.replace(with_pairs({"quality": 9}, {"quality": 9}), {"rotors.two.load.torque": 5.0})
    found = gp.portrait(case, settle=20, keep=20, show=1, period=1.0 / 190.0)
    contacts = set(found.ds["contact"].values)
    assert contacts
    assert contacts <= set(FLANKS)


@pytest.mark.parametrize(
    "asked",
    [
        lambda case: gp.impacts(case, ["two.theta"], "one-two:drvie"),
        lambda case: gp.sweep(
            {
                "title": "Relief",
                "case": case,
                "axes": [{"name": "gap", "path": "meshes.0.backlash", "values": [1e-4, 2e-4]}],
                "reduce": [{"kind": "contact", "name": "peak", "contact": "one-two:drvie", "statistic": "peak_force"}],
            }
        ),
    ],
)  # fmt: skip
def test_unknown_contacts__are_answered_with_flanks(asked: object) -> None:
    case = with_pairs({}, {})
    with pytest.raises(gp.InputError, match=re.escape("Choose from: one-two:drive, one-two:back.") + "$"):
        asked(case)  # type: ignore[operator]
