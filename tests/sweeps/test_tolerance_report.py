"""The report of a tolerance study: what the document and the page hold, its units, and what degenerate samples do to it."""

import dataclasses
import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

from gearplay.model.reading import load_case
from gearplay.sweeps.cases.draws import draw
from gearplay.sweeps.plans.plan import SweepPlan
from gearplay.sweeps.plans.reading import load_sweep
from gearplay.sweeps.plans.tolerance import Tolerance
from gearplay.sweeps.tolerances import figures as figures_of
from gearplay.sweeps.tolerances.allowable import largest_scale
from gearplay.sweeps.tolerances.figures import Scale, distribution_figure, search_figure
from gearplay.sweeps.tolerances.page import values_of, write_tolerance
from gearplay.sweeps.tolerances.statistics import distribution, exceedance
from gearplay.sweeps.tolerances.words import EXCEEDED, KEPT, OPEN, indices_words, search_words, verdict_of
from gearplay.sweeps.variance import Indices

SCRIPT = "<script>alert(1)</script> of $ 5"
SPEEDS = [2.0 * math.pi, 4.0 * math.pi]


def plan_of(kind: str, count: int, *, members: int = 1, axes: bool = False) -> SweepPlan:
    speeds = {"name": "speed", "path": "rotors.pinion.drive.speed", "values": SPEEDS}
    return load_sweep(
        {
            "title": SCRIPT,
            "case": "han2021",
            "members": members,
            "axes": [speeds] if axes else [],
            "design": {
                "kind": kind,
                "count": count,
                "parameters": [
                    {
                        "name": "play",
                        "path": "sleeves.ring.radial_clearance",
                        "low": "50 um",
                        "high": "150 um",
                    },
                    {
                        "name": "drag",
                        "path": "rotors.ring.load.drag",
                        "mode": "scale",
                        "low": 0.8,
                        "high": 1.2,
                    },
                ],
            },
            "reduce": [{"kind": "line", "name": "mesh", "signal": "x", "at": "ring", "order": 1}],
        }
    )


def product_of(plan: SweepPlan, *, failed: bool = False) -> xr.Dataset:
    """Return a product whose measure is a tenth of the drawn play; members and speeds scatter it."""
    assert plan.design is not None
    drawn, generator = draw(plan.design, load_case("han2021")), np.random.default_rng(0)
    shape = ([2] if plan.axes else []) + [len(drawn), plan.members]
    values = 0.1 * drawn[:, :1] * (1.0 + 0.02 * generator.normal(size=shape))
    if plan.axes:
        values[1] *= 2.0
    if failed:
        values[:] = np.nan
    dims = [*(axis.name for axis in plan.axes), "sample", "member"]
    units = {"units": "m", "long_name": "amplitude of the ring"}
    coordinates: dict[str, Any] = {
        "play": ("sample", drawn[:, 0], {"units": "m", "long_name": "play"}),
        "drag": ("sample", drawn[:, 1], {"units": "1", "long_name": "drag"}),
    }
    if plan.axes:
        coordinates["speed"] = ("speed", np.array(SPEEDS), {"units": "rad/s", "long_name": "speed"})
    found = xr.Dataset({"mesh_amplitude": (dims, values, units)}, coords=coordinates)
    return found if plan.members > 1 else found.isel(member=0)


def drawn_from() -> Any:
    design = plan_of("monte-carlo", 30).design
    assert design is not None
    return design.parameters


def test_distribution__of_a_saltelli_design_is_drawn_of_its_independent_points(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The curve ends at the largest of the values that the numbers are made of, not of all points of the blocks."""
    plan, seen = plan_of("saltelli", 16), []
    monkeypatch.setattr(
        figures_of, "distribution_figure", lambda values, *_, **__: seen.append(values) or b""
    )
    tolerance = Tolerance(measure="mesh_amplitude", limit="13 um", probability=0.6)
    document = write_tolerance(plan, tolerance, product_of(plan), tmp_path)
    (drawn,), found = seen, document["conditions"][0]["distribution"]
    assert drawn.size == found["cases"] == 32
    assert (drawn.min(), drawn.max()) == (found["least"], found["most"])


@pytest.mark.slow
def test_document__equals_the_file_and_the_page(tmp_path: Path) -> None:
    plan = plan_of("saltelli", 64, members=2)
    tolerance = Tolerance(measure="mesh_amplitude", limit="13 um", probability=0.6, scale=("play",))
    sample = np.linspace(5e-6, 15e-6, 200)
    search = largest_scale(lambda f: f * sample, 13e-6, probability=0.6, check=lambda f: f * sample)
    document = write_tolerance(plan, tolerance, product_of(plan), tmp_path, search=search)
    assert json.loads((tmp_path / "tolerance.json").read_text()) == document
    assert document["limit"] == 13e-6
    (found,) = document["conditions"]
    assert found["verdict"] == KEPT
    assert found["exceedance"]["cases"] == 2 * 128
    assert found["indices"]["source"] == "sobol"
    assert found["indices"]["names"] == ["play", "drag"]
    assert found["indices"]["total"][0] > 0.9
    assert document["search"]["factor"] == search.factor
    assert document["search"]["advised"] == search.advised
    (size,) = document["search"]["sizes"]
    assert (size["name"], size["planned"]) == ("play", "50 to 150 µm")
    assert document["answer"] == [found["words"][0], document["search"]["words"][0], found["words"][1]]
    assert f"play of {50 * search.advised:.3g} to {150 * search.advised:.3g} µm" in document["answer"][1]
    assert sorted(f.name for f in (tmp_path / "figures").iterdir()) == [
        "distribution.png",
        "indices.png",
        "search.png",
    ]
    page = (tmp_path / "tolerance.html").read_text()
    assert "<script>" not in page
    assert "within 13 µm with probability 60 %" in page
    assert "without draws" in page
    assert page.count("data:image/png;base64,") == 3
    assert page.index(document["answer"][1]) < page.index("data:image/png") < page.index("as planned")
    for line in found["words"] + document["search"]["words"]:
        assert line.replace("'", "&#39;") in page
    assert "Play matters most" in " ".join(found["words"])
    assert "µm (a fifth of them)" in " ".join(found["words"])


@pytest.mark.slow
def test_every_combination_of_the_axes_has_its_answer(tmp_path: Path) -> None:
    plan = plan_of("latin-hypercube", 100, axes=True)
    document = write_tolerance(
        plan, Tolerance(measure="mesh_amplitude", limit=16e-6), product_of(plan), tmp_path
    )
    assert [c["label"] for c in document["conditions"]] == ["speed 60 rpm", "speed 120 rpm"]
    assert [c["verdict"] for c in document["conditions"]] == [KEPT, EXCEEDED]
    assert document["conditions"][1]["at"] == {"speed": SPEEDS[1]}
    assert document["search"] is None
    assert document["conditions"][0]["indices"]["source"] == "polynomial"
    assert document["conditions"][0]["distribution"]["noise"] is None
    assert {f.name for f in (tmp_path / "figures").iterdir()} >= {"distribution-1.png", "indices-2.png"}
    assert "All conditions" in (tmp_path / "tolerance.html").read_text()


@pytest.mark.slow
def test_a_sweep_of_failures_has_a_page_all_the_same(tmp_path: Path) -> None:
    plan = plan_of("monte-carlo", 30)
    product = product_of(plan, failed=True)
    tolerance = Tolerance(measure="mesh_amplitude", limit=1e-5, scale=("play",))
    search = largest_scale(lambda f: np.full(30, np.nan), 1e-5)
    document = write_tolerance(plan, tolerance, product, tmp_path, search=search)
    assert document["conditions"][0]["words"][0].startswith("No case finished")
    assert document["conditions"][0]["exceedance"]["probability"] is None
    assert document["search"]["words"][0].startswith("No case of the search finished")


def test_values_have_one_member_where_the_product_has_none() -> None:
    plan = plan_of("monte-carlo", 10)
    assert values_of(product_of(plan), "mesh_amplitude").shape == (10, 1)
    plan = plan_of("monte-carlo", 10, members=3, axes=True)
    product = product_of(plan).transpose("member", "sample", "speed")
    assert values_of(product, "mesh_amplitude").shape == (2, 10, 3)


def test_the_verdict_allows_for_what_failed() -> None:
    values = np.zeros(200)
    assert verdict_of(exceedance(values, 1.0), 0.95) == KEPT
    values[:6] = np.nan
    assert verdict_of(exceedance(values, 1.0), 0.95) == OPEN
    values[100:] = 2.0
    assert verdict_of(exceedance(values, 1.0), 0.95) == EXCEEDED


def test_a_parameter_matters_only_beyond_the_scatter_among_members() -> None:
    found = Indices("sobol", ("a",), 0.95, 50, 0, (0.1,), (0.2,), (0.5,), (0.1,), noise=0.3)
    assert indices_words(found)[0].startswith("A matters most: total index 0.50")
    noisy = dataclasses.replace(found, noise=0.45)
    assert indices_words(noisy)[0].startswith("No parameter can be told to matter; first comes a")
    assert indices_words(dataclasses.replace(found, reason="why"))[0] == "No Sobol indices: why."


@pytest.mark.slow
@pytest.mark.parametrize(
    "values",
    [
        np.array([1.0]), np.full(40, 2.0), np.zeros(40), np.full((3, 2), np.nan), np.linspace(1.0, 3.0, 500),
        np.geomspace(1e-4, 1e4, 50), np.linspace(1e3, 2e3, 20), -np.linspace(1.0, 3.0, 9),
    ],
)  # fmt: skip
def test_any_sample_can_be_drawn(values: Any) -> None:
    scale = Scale.of("level", "m/s^2", 3.0)
    png = distribution_figure(
        values, distribution(values), exceedance(values, 2.0), scale, SCRIPT, wanted=0.9
    )
    assert png.startswith(b"\x89PNG")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("limit", "power", "said"),
    [
        (1e-3, 1.0, "No factor of play and drag from 0.25 to 4"),
        (99.0, 1.0, "the largest factor of the range"),
        (2.0, 1.0, "Safe with 95 % confidence: play of "),
        (2.0, -1.0, "the largest factor of the range"),
    ],
)
def test_any_search_can_be_drawn_and_told(limit: float, power: float, said: str) -> None:
    sample = np.abs(np.random.default_rng(0).normal(size=300))
    found = largest_scale(lambda f: f**power * sample, limit, check=lambda f: f**power * sample[::-1])
    assert search_figure(found, SCRIPT).startswith(b"\x89PNG")
    assert said in " ".join(search_words(found, drawn_from()))


def test_a_search_whose_smaller_factors_fail_warns() -> None:
    sample = np.abs(np.random.default_rng(0).normal(size=300))
    found = largest_scale(lambda f: 5.0 * np.abs(f - 1.1875) * sample, 2.0)
    words = " ".join(search_words(found, drawn_from()[:1]))
    assert "Smaller factors exceed the limit too often as well" in words
    assert "not checked" in words
    assert search_figure(found, "t").startswith(b"\x89PNG")
