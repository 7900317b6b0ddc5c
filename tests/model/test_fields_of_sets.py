"""Fields of planetary sets in findings and refusals: a message names the field that the user sets, once for equal parts."""

from typing import Any

import pytest

import gearplay as gp
from gearplay.model.case import Case
from gearplay.model.overrides import apply_change
from gearplay.model.wording import known_fields
from planetary_sets import planetary_document

SLEEVE = {"radial_clearance": 1e-5, "stiffness": 1e10}
COLD = {"temperature": "-60 degC", "housing": {"expansion": 23e-6}}


def pinned(**more: Any) -> gp.Case:
    return gp.load_case(planetary_document(support=None, **{"pin": SLEEVE, **more}))


def is_settable(case: gp.Case, path: str) -> bool:
    """Return whether a path is a field of the set's table of a case file."""
    parts = path.split(".")
    document = case.resolved()
    if apply_change(case.resolved(), path, None) is not None:
        return False
    here = tuple(int(p) if p.isdecimal() else p for p in parts[:-1])
    return parts[-1] in (*known_fields(Case, here, document), "stage", "0")


@pytest.mark.parametrize(
    "more",
    [{}, {"stiffness": None, "sun_planet": 1e8, "planet_ring": 2e8}, {"eccentricities": [{"planet": 2, "amplitude": 1e-5}]}],
    ids=["one stiffness", "two", "runouts"],
)  # fmt: skip
def test_every_field_of_every_part_has_one_of_the_set(more: dict[str, Any]) -> None:
    kinds = {"kind": "harmonic", "amplitude": 0.0}
    more = {k: v if not isinstance(v, float) else kinds | {"mean": v} for k, v in more.items()}
    case = pinned(**more)
    dumped, count = case.model_dump(mode="json"), 0
    for table in ("rotors", "sleeves", "meshes"):
        listed = dumped[table].items() if table != "meshes" else enumerate(dumped[table])
        for name, part in listed:
            for field in part:
                path = case.settable_path(f"{table}.{name}.{field}")
                assert path.startswith("planetary.stage"), path
                assert is_settable(case, path), path
                count += 1
    assert count > 200
    assert case.settable_path("run.duration") == "run.duration"


def test_paths_lead_to_the_number_of_the_part() -> None:
    case = pinned(pin=SLEEVE | {"shaft_radius": 4e-3}, backlash=5e-5)
    for path, value in {
        "rotors.stage.sun.inertia": 2.5e-6,
        "rotors.stage.planet3.mass": 0.5,
        "sleeves.stage.planet2.shaft_radius": 3e-3,
        "meshes.5.backlash": 4e-5,
    }.items():
        changed = gp.replace(case, {case.settable_path(path): value})
        part: Any = changed.model_dump(mode="json")
        table, _, rest = path.partition(".")
        name, _, field = rest.rpartition(".")
        part = part[table][int(name) if table == "meshes" else name]
        assert part[field] == pytest.approx(value)


def test_check_names_fields_of_the_set_only() -> None:
    document = planetary_document(support=None, pin=SLEEVE)
    document["planetary"]["stage"]["sun"]["inertia"] = 1.0
    document["run"].pop("transient", None)
    found = gp.check_case(document)
    assert "planetary.stage.sun.inertia" in [each.path for each in found if each.severity == "warning"]
    assert not [each.path for each in found if each.path.startswith(("rotors.", "meshes.", "sleeves."))]
    assert len({(each.path, each.message) for each in found}) == len(found)
    for path in ("planetary.stage.sun.inertia", "rotors.stage.sun.inertia"):
        accepted = gp.check_case(document | {"accepted": [path]})
        assert "planetary.stage.sun.inertia" in [each.path for each in accepted if "Accepted" in each.message]
        assert not [each for each in accepted if each.path == "accepted"]


@pytest.mark.parametrize(
    ("path", "field"),
    [
        ("rotors.stage.sun.inertia", "planetary.stage.sun.inertia"),
        ("meshes.0.damping.ratio", "planetary.stage.damping.ratio"),
        ("meshes.stage.sun-stage.planet1.backlash", "planetary.stage.backlash"),
        ("sleeves.stage.planet2.radial_clearance", "planetary.stage.pin.radial_clearance"),
    ],
)
def test_a_change_of_a_part_of_a_set_is_one_sentence_with_its_field(path: str, field: str) -> None:
    for source in (pinned(), planetary_document(support=None, pin=SLEEVE)):
        with pytest.raises(gp.InputError, match="planetary set stage") as caught:
            gp.load_case(source, [f"{path}=0.1"])
        assert len(caught.value.faults) == 1
        assert str(caught.value).endswith(f"Change {field}.")


def test_an_item_of_a_list_that_the_case_lacks_is_one_sentence() -> None:
    with pytest.raises(gp.InputError, match="faults has 0 items") as caught:
        gp.load_case("external-pair", ["faults.0.kind=crack"])
    assert len(caught.value.faults) == 1


def test_temperature_lists_all_faults_once_each() -> None:
    document = planetary_document(support=None, pin=SLEEVE)
    document["environment"] = {"temperature": "-60 degC"}
    with pytest.raises(gp.InputError) as caught:
        gp.check_case(document)
    wanted = [f"planetary.stage.{name}.material" for name in ("sun", "ring", "carrier", "planets")]
    wanted += ["environment.housing", "planetary.stage.pin.shaft_radius"]
    assert [fault.path for fault in caught.value.faults] == wanted


def test_seats_at_a_temperature_are_refused_together_with_materials() -> None:
    document = planetary_document(support=None, pin=SLEEVE | {"shaft_radius": 4e-3, "radial_clearance": 1e-6})
    document["environment"] = COLD
    for name, expansion in (("ring", 23e-6), ("carrier", 11.5e-6), ("planets", 23e-6)):
        document["planetary"]["stage"][name]["material"] = {"expansion": expansion}
    with pytest.raises(gp.InputError) as caught:
        gp.simulate(document)
    paths = ["planetary.stage.sun.material", "planetary.stage.pin.radial_clearance"]
    assert [fault.path for fault in caught.value.faults] == paths


def test_assembled_faults_name_the_set() -> None:
    document = planetary_document()
    document["planetary"]["stage"]["planets"]["inertia"] = 0.0
    with pytest.raises(gp.InputError, match=r"^planetary\.stage\.planets\.inertia = 0\.0: [^\n]*$"):
        gp.simulate(document)


@pytest.mark.parametrize("count", [4, 5, 7, 9])
def test_advised_numbers_of_planets_are_all_that_can_be_built(count: int) -> None:
    """Of 18/27/72 sun and ring allow the divisors of 90, the tips of the planets three at most."""
    stage = planetary_document()["planetary"]["stage"]
    stage |= {"module": 1e-3, "sun": stage["sun"] | {"teeth": 18}, "ring": stage["ring"] | {"teeth": 72}}

    def refused(number: int) -> str:
        planets = stage["planets"] | {"teeth": 27, "count": number}
        try:
            gp.load_case({"planetary": {"stage": stage | {"planets": planets}}, "run": {"duration": 0.01}})
        except gp.InputError as error:
            return str(error)
        return ""

    built = [number for number in range(1, 25) if not refused(number)]
    assert built == [1, 2, 3]
    assert f"Choose of {', '.join(map(str, built))} planets" in refused(count)
