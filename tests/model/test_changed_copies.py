"""A changed copy of a case reads anew only what lies on the way to the change: it is, or is refused, as the whole read anew."""

import copy
import random
from collections.abc import Iterator
from typing import Any

import pytest

import gearplay as gp
from depth import some
from gearplay.model.plan_values import value_at
from gearplay.model.reading import bundled_names
from gearplay.vocabulary.errors import InputError


def leaves(document: Any, path: tuple[str, ...] = ()) -> Iterator[tuple[str, Any]]:
    inner = (
        document.items()
        if isinstance(document, dict)
        else enumerate(document)
        if isinstance(document, list)
        else ()
    )
    for name, value in inner:
        yield ".".join((*path, str(name))), value
        yield from leaves(value, (*path, str(name)))


def whole(document: dict[str, Any], path: str, value: Any) -> gp.Case:
    """Read the whole document with one value changed."""
    document = copy.deepcopy(document)
    *way, last = path.split(".")
    place: Any = document
    for part in way:
        place = place[int(part)] if isinstance(place, list) else place[part]
    place[int(last) if isinstance(place, list) else last] = value
    return gp.load_case(document)


def outcome(make: Any) -> Any:
    try:
        return make()
    except InputError as error:
        return str(error)


@pytest.mark.slow
@pytest.mark.parametrize("name", bundled_names())
def test_every_value_of_every_bundled_case(name: str) -> None:
    case = gp.load_case(name)
    document = case.resolved()
    for path, value in some([*leaves(document)], 12):
        for new in (value, 1.25 * value if isinstance(value, float) else None, -1.0, "7 um", "nonsense"):
            assert outcome(lambda: gp.replace(case, {path: new})) == outcome(  # noqa: B023  (called at once)
                lambda: whole(document, path, new)  # noqa: B023
            ), (path, new)


def test_changed_copy__leaves_the_original_and_other_fields() -> None:
    case = gp.load_case("external-pair")
    before = case.resolved()
    _ = case.sha256
    changed = gp.replace(case, {"meshes.0.backlash": "70 um", "run.seed": 9})
    assert case.resolved() == before
    assert changed.sha256 != case.sha256
    assert changed.rotors["input"] is case.rotors["input"]
    with pytest.raises(TypeError, match="cannot be changed"):
        changed.rotors["input"] = case.rotors["input"]  # type: ignore[index]
    assert gp.load_case(changed.resolved()) == changed


def test_changes_follow_each_other() -> None:
    case = gp.load_case("han2021")
    changes = {
        "rotors.ring.drive": {"kind": "torque", "torque": 1.0},
        "rotors.ring.drive.torque": 2.0,
        "gravity.1": -9.81,
        "meshes.0.transmission_error": [{"order": 1, "amplitude": 1e-6}],
        "meshes.0.transmission_error.0.amplitude": "3 um",
    }
    made = gp.replace(case, changes)
    assert value_at(made.resolved(), "rotors.ring.drive.torque") == 2.0
    assert made.gravity == (0.0, -9.81)
    assert made.meshes[0].transmission_error[0].amplitude == 3e-6


@pytest.mark.parametrize(
    "path", ["", "meshes.7.backlash", "meshes." + "9" * 5000, "a.b.c", "rotors..x", "title.x"]
)
def test_paths_that_lead_nowhere(path: str) -> None:
    with pytest.raises(InputError):
        gp.replace(gp.load_case("han2021"), {path: 1.0})


def test_random_changes_of_several_values() -> None:
    draw = random.Random(5)
    case = gp.load_case("pinion-idler-ring")
    document = case.resolved()
    numbers = [path for path, value in leaves(document) if isinstance(value, float)]
    for _ in range(50):
        wanted = {path: draw.uniform(0.5, 1.5) * value_at(document, path) for path in draw.sample(numbers, 4)}
        expected = document
        for path, value in wanted.items():
            place = expected = copy.deepcopy(expected)
            *way, last = path.split(".")
            for part in way:
                place = place[int(part)] if isinstance(place, list) else place[part]
            place[int(last) if isinstance(place, list) else last] = value
        assert outcome(lambda: gp.replace(case, wanted)) == outcome(lambda: gp.load_case(expected))  # noqa: B023
