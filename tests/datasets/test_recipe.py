"""Records of a plan by number: cases, labels, groups, refusals."""

from collections import Counter
from typing import Any

import numpy as np
import pytest

from datasets.plans import FEW, RECORDS
from gearplay.datasets.reading import load_dataset_plan
from gearplay.datasets.recipe import Recipe
from gearplay.datasets.split import split_groups
from gearplay.vocabulary.errors import InputError, ResourceError


def recipe(**changes: Any) -> Recipe:
    return Recipe(load_dataset_plan(FEW | changes))


def test_cases_have_the_values_of_their_labels() -> None:
    made = recipe()
    assert len(made) == RECORDS
    drag = made.base.rotors["ring"].load.drag
    for record in range(RECORDS):
        labels, case = made.labels(record), made.case_at(record)
        assert case.meshes[0].backlash == labels["backlash"]
        assert case.rotors["pinion"].drive.speed == labels["speed"]
        assert case.rotors["ring"].load.drag == pytest.approx(drag * labels["drag"], rel=1e-15)
        worn = labels["label"] == "worn"
        assert case.sleeves["ring"].radial_clearance == (labels["clearance"] if worn else 1e-4)
        assert 2 * np.pi <= labels["speed"] <= 6 * np.pi
    assert len({made.labels(record)["speed"] for record in range(RECORDS)}) == RECORDS, (
        "drawn for each record"
    )
    assert made.columns() == {"drag": "1", "backlash": "m", "speed": "rad/s", "clearance": "m"}


def test_every_machine_has_every_class_and_one_part() -> None:
    made = recipe()
    rows = [made.labels(record) for record in range(RECORDS)]
    parts: dict[int, set[str]] = {}
    for row in rows:
        parts.setdefault(row["machine"], set()).add(row["split"])
    assert all(len(found) == 1 for found in parts.values())
    assert Counter(next(iter(found)) for found in parts.values()) == {"train": 3, "validation": 1, "test": 1}
    assert len({row["backlash"] for row in rows}) == 5
    for machine in range(5):
        own = [row for row in rows if row["machine"] == machine]
        assert len({row["backlash"] for row in own}) == 1
        assert Counter(row["label"] for row in own) == {"normal": 4, "worn": 4}


def test_groups_may_be_conditions() -> None:
    made = recipe(split={"by": "condition", "train": 0.5, "validation": 0.0, "test": 0.5})
    parts: dict[float, set[str]] = {}
    for record in range(RECORDS):
        row = made.labels(record)
        parts.setdefault(row["drag"], set()).add(row["split"])
        assert row["group"] == (row["drag"] == 2.0)
    assert sorted(map(sorted, parts.values())) == [["test"], ["train"]]


@pytest.mark.parametrize("count", [5, 7, 20, 1000])
def test_parts_have_their_shares(count: int) -> None:
    shares = {"train": 0.6, "validation": 0.2, "test": 0.2}
    found = Counter(split_groups(count, shares, 3))
    assert sum(found.values()) == count
    assert all(abs(found[name] - share * count) < 1.0 for name, share in shares.items())
    assert split_groups(count, shares, 3) != split_groups(count, shares, 4) or count < 6


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"split": {"train": 0.5}}, "split.train"),
        ({"design": FEW["design"] | {"count": 2}}, "must leave a group for it; the plan has 2 groups"),
        ({"design": None, "split": {"by": "machine"}}, "must be condition where the plan has no"),
        ({"classes": FEW["classes"] + [{"label": "worn"}]}, "must be a label of its own"),
        ({"draws": [FEW["draws"][0] | {"name": "label"}]}, "must be a name of its own"),
        ({"draws": [FEW["draws"][0] | {"high": "-1 rpm"}]}, "draws.0.high"),
        ({"draws": [FEW["draws"][0] | {"path": "rotors.ring.nothing"}]}, "nothing"),
        ({"classes": [{"label": "x", "set": {"sleeves.ring.radial_clearance": "-1 um"}}]}, "classes.0.set: "),
        (
            {
                "draws": [
                    {
                        "name": "b",
                        "path": "run.tolerance",
                        "distribution": "normal",
                        "mean": 1e-6,
                        "deviation": 1e-3,
                    }
                ]
            },
            "draws.0: the draws of b reach run.tolerance",
        ),
        ({"classes": []}, "classes"),
        ({"format": "png"}, "format"),
        ({"rig": {"accelerometers": {"a": {"rotor": "wheel"}}}}, "must be a rotor of the case"),
    ],
)
def test_refused_plans(changes: dict[str, Any], words: str) -> None:
    document = {name: value for name, value in (FEW | changes).items() if value is not None}
    with pytest.raises(InputError) as refused:
        Recipe(load_dataset_plan(document))
    assert words in str(refused.value)


def test_too_many_records() -> None:
    with pytest.raises(ResourceError, match="are more than the limit"):
        recipe(members=1_000_000)
