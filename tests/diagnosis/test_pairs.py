"""Two stated causes as variants of a case."""

from gearplay.diagnosis.evidence import Hypothesis
from gearplay.diagnosis.pairs import pairs_of
from gearplay.diagnosis.suspects import Suspect

OLD = {"kind": "crack", "depth": 1}


def fault(name: str, kind: str, sizes: tuple[float, ...]) -> Suspect:
    levels = tuple({"faults": [OLD, {"kind": kind, "depth": size}]} for size in sizes)
    return Suspect(name, kind, (name,), "depth", sizes, levels)


def wear(path: str) -> Suspect:
    return Suspect("worn flanks", "rattle", (), "backlash", (2e-4, 3e-4), ({path: 2e-4}, {path: 3e-4}))


RING, TOOTH = Hypothesis("ring", "inner", (), 1.0, 0.9), Hypothesis("tooth", "tooth", (), 1.0, 0.8)
RATTLE = Hypothesis("rattle of the flanks", "rattle", (), 1.0, 0.8)
RINGS, TEETH = fault("ring", "inner", (2e-6, 6e-6)), fault("tooth", "tooth", (1e-3,))


def test_two_faults__have_those_of_the_case_once_and_each_severity_of_the_first() -> None:
    found = pairs_of([RING, TOOTH], [TEETH, RINGS])
    assert [each.name for each in found] == ["ring together with tooth"] * 2
    assert [each.hypotheses for each in found] == [("ring", "tooth")] * 2
    assert [each.beside.sizes for each in found if each.beside] == [(2e-6,), (6e-6,)]
    assert found[1].levels == (
        {"faults": [OLD, {"kind": "inner", "depth": 6e-6}, {"kind": "tooth", "depth": 1e-3}]},
    )


def test_rattle__is_a_wear() -> None:
    found = pairs_of([RATTLE, TOOTH], [TEETH, wear("meshes.0.backlash")])
    assert [sorted(level) for each in found for level in each.levels] == [["faults", "meshes.0.backlash"]] * 2


def test_one_cause_or_one_that_is_not_simulated__is_no_pair() -> None:
    assert pairs_of([RING], [RINGS, TEETH]) == []
    assert pairs_of([RING, TOOTH], [RINGS]) == []


def test_two_changes_of_one_field__are_no_pair() -> None:
    same = Suspect("ring", "inner", ("ring",), "depth", (1.0,), ({"meshes.0.backlash": 1.0},))
    assert pairs_of([RING, RATTLE], [same, wear("meshes.0.backlash")]) == []
