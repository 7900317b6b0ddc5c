"""`gearplay motion` and `gp.motion`: motions whose kind is known from their orbits, exponents and equations."""

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gearplay as gp
from depth import sized
from gearplay.cli.main import run
from gearplay.model.reading import to_toml
from gearplay.nonlinear import method_comparison
from gearplay.nonlinear.motion import ARTEFACT
from gearplay.pictures.canvas import to_png


def pair(frequency: float, **more: Any) -> gp.Case:
    return gp.torsional_pair(frequency, **{"mean_force": 0.1, "damping_ratio": 0.1, **more})


@pytest.mark.slow
@pytest.mark.parametrize(
    ("case", "kind", "order"),
    [
        (pair(0.7, mean_force=1.0), "at rest", 1),
        (pair(0.7, mean_force=1.0, force=0.1), "periodic", 1),
        (pair(0.7, force=0.1), "periodic", 1),
        (pair(0.8, force=0.2), "periodic", 2),
        (pair(0.6, force=0.2), "chaotic", None),
        (pair(0.7, mean_force=1.0, force=0.1, damping_ratio=0.0), "quasi-periodic", None),
        (pair(0.7, mean_force=1.0, force=0.1, damping_ratio=2e-5), "transient", None),
    ],
    ids=["rest", "linear", "rattling", "doubled", "chaos", "undamped", "decaying"],
)
def test_kinds_of_the_torsional_pair(case: gp.Case, kind: str, order: int | None) -> None:
    """The undamped linear pair turns with its own frequency beside the forced one: a torus. Little damped it decays for ages."""
    periods = 1000 if order is None else 300  # what repeats is soon told
    found = gp.motion(case, periods=periods, settle=300, compare=False)
    assert (found.kind, found.order) == (kind, order), found.reason


@pytest.mark.slow
def test_the_article_s_pair_is_chaotic_and_no_artefact() -> None:
    """Most paths are: one in ten records of 400 periods is not long enough to tell; no exponent is below 0."""
    kinds = []
    for tolerance in np.linspace(1e-9, 0.8e-9, sized(5, 2)):
        changes = {
            "run.sampling": 2e3,
            "run.duration": 1.0,
            "run.transient": 0.5,
            "run.tolerance": float(tolerance),
        }
        found = gp.motion(
            gp.replace(gp.load_case("han2021"), changes), periods=400, settle=100, period="mesh"
        )
        kinds.append(found.kind)
        value, half = found.exponent
        assert value - half > 0.0
        assert len(found.comparisons) > 10
        assert max(abs(each.t) for each in found.comparisons) < found.limit
    assert set(kinds) <= {"chaotic", "transient", "undecided"}
    assert kinds.count("chaotic") > 0.5 * len(kinds)


@pytest.mark.slow
@pytest.mark.many
@pytest.mark.parametrize(
    ("formulation", "step", "kind"),
    [("as_published", None, ARTEFACT), ("as_published", 5e-6, ARTEFACT), ("geometric", 5e-6, "chaotic")],
)
def test_the_published_force_jumps_and_plain_steps_feed_on_it(
    formulation: str, step: float | None, kind: str
) -> None:
    """At 200/100 um the printed backlash (18) turns negative and the force (19) jumps: noticed late, each jump adds energy."""
    changes = {
        "formulation": formulation,
        "sleeves.ring.radial_clearance": 2e-4,
        "run.sampling": 2e3,
        "run.fixed_step": step,
    }
    case = gp.replace(gp.load_case("han2021"), changes)
    found = gp.motion(case, periods=400, settle=100, period="mesh")
    assert found.kind == kind, found.reason
    assert (step is None) == math.isfinite(found.exponent[0])
    if kind == ARTEFACT:
        assert "plain steps of" in found.reason if step is None else "located contacts" in found.reason


@pytest.mark.slow
def test_what_depends_on_the_method_is_an_artefact(monkeypatch: pytest.MonkeyPatch) -> None:
    """A case whose tolerance is so coarse that the statistics hang on it."""
    case = pair(0.6, force=0.2, tolerance=1e-10)
    changed = method_comparison.replace

    def replace(base: gp.Case, changes: Any) -> gp.Case:
        """Make the run with the finer tolerance one of another mechanism, as a method that matters would."""
        if "run.tolerance" in changes:
            return pair(0.8, force=0.2)
        return changed(base, changes)

    monkeypatch.setattr(method_comparison, "replace", replace)
    found = gp.motion(case, periods=1000, settle=50)
    assert found.kind == ARTEFACT
    assert found.response.kind == "chaotic"
    assert "With a hundredth of the tolerance the " in found.reason
    assert max(abs(each.t) for each in found.comparisons) > found.limit


@pytest.mark.slow
def test_the_command_says_what_and_why(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "pair.toml"
    file.write_text(to_toml(pair(0.8, force=0.2)), encoding="utf-8")
    words = ["motion", str(file), "--periods", "200", "--settle", "200"]
    assert run(words) == 0
    said = capsys.readouterr().out
    assert "Torsional pair: periodic of order 2" in said
    assert "The section repeats every 2 periods within the resolution" in said
    assert "may be chance" in said
    assert run([*words, "--no-compare", "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert (document["kind"], document["order"], document["comparisons"]) == ("periodic", 2, [])
    assert document["exponent"]["value"] < 0.0


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["han2021", "--periods", "99"], "periods = 99: must be a whole number, 100 or more"),
        (["han2021", "--members", "3"], "--members = 3: must be a whole number, 4 or more"),
        (["han2021", "--settle", "-1"], "settle = -1: must be a whole number, 0 or more"),
        (["han2021", "--period", "tooth"], 'period = "tooth"'),
        (["external-pair"], "must be a prescribed speed without a ramp"),
        (["han2012"], "Did you mean 'han2021'?"),
    ],
)
def test_what_cannot_be_is_one_sentence(
    words: list[str], told: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["motion", *words]) == 2
    complaint = capsys.readouterr().err
    assert told in complaint
    assert complaint.count("\n") == 1


@pytest.mark.slow
def test_basins_and_their_picture() -> None:
    found = gp.basins(
        gp.torsional_pair(0.6, mean_force=0.1, force=0.05),
        ("wheel.theta", -6e-4, 4e-4, 4),
        ("wheel.omega", -4.0, 4.0, 3),
    )
    assert found.labels.shape == (3, 4)
    assert to_png(found.plot(title="A $b$")).startswith(b"\x89PNG")
    with pytest.raises(gp.InputError, match="must be an entry of the state"):
        gp.basins("han2021", ("ring.z", 0.0, 1.0, 2), ("ring.vx", 0.0, 1.0, 2))
