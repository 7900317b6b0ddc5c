"""Results in Python: dataset, attributes, saving and reading back, spectra, refusals."""

import dataclasses
import json
from pathlib import Path

import numpy as np
import pytest

import gearplay as gp
from gearplay.model.reading import load_case, to_toml
from gearplay.model.variables import VARIABLES
from gearplay.results.spectra import ensemble_spectrum
from gearplay.solver.status import Status
from gearplay.solver.trajectory import WrittenSamples


@pytest.fixture(scope="module")
def result() -> gp.Result:
    return gp.simulate("han2021", duration=0.05, transient=0.01, sampling=2e4)


def test_the_dataset_has_the_contracts_names_units_and_provenance(result: gp.Result) -> None:
    ds = result.ds
    assert dict(ds.sizes) == {"time": 1000, "rotor": 2, "sleeve": 1, "mesh": 1, "contact": 3}
    assert list(ds.rotor.values) == ["pinion", "ring"]
    assert list(ds.mesh.values) == ["pinion-ring"]
    for quantity in (*VARIABLES["rotor"], *VARIABLES["sleeve"], *VARIABLES["mesh"]):
        assert ds[quantity.name].attrs["units"] == quantity.unit
        assert ds[quantity.name].attrs["long_name"]
    assert gp.load_case(json.loads(ds.attrs["case"])).sha256 == ds.attrs["case_sha256"] == result.case.sha256
    for name in (
        "gearplay_version",
        "method",
        "tolerance",
        "seed",
        "steps",
        "events",
        "rejected_steps",
        "status",
        "wall_time",
    ):
        assert name in ds.attrs
    assert ds.time.values[0] == pytest.approx(0.01)


def test_the_method_is_the_one_that_ran() -> None:
    """Under a fixed step nothing is located and no error estimated: the attribute must not say so."""
    case = gp.load_case("han2021")
    equal = gp.replace(case, {"run.fixed_step": 2e-6})
    located, noticed = (
        gp.simulate(each, duration=1e-3, transient=0.0, sampling=2e4).ds.attrs["method"]
        for each in (case, equal)
    )
    assert "located" in located
    assert "equal steps" in noticed
    assert "located" not in noticed


def test_a_mesh_wedged_as_published_is_told() -> None:
    """Where both flanks touch, eq. (19) lets one act: the message says so, with the share of time that the samples show."""
    wedging = {
        "formulation": "as_published",
        "sleeves.ring.radial_clearance": "200 um",
        "rotors.ring.initial.x": "190 um",
    }
    told = gp.simulate(gp.replace(gp.load_case("han2021"), wedging), duration=0.02, transient=0.0)
    both = (told.ds.drive_penetration > 0.0) & (told.ds.back_penetration > 0.0)
    assert told.runs[0].wedged["pinion-ring"] == pytest.approx(float(both.mean()), abs=0.01)
    assert float(both.mean()) > 0.5
    assert "pinion-ring was wedged" in told.message
    assert "wedged" in told.ds.attrs["message"]
    free = gp.simulate(gp.replace(gp.load_case("han2021"), {"formulation": "as_published"}), duration=0.02)
    assert free.message == "Done."


def test_wedged_share__is_zero_of_a_run_that_ended_in_its_transient() -> None:
    wedging = {
        "formulation": "as_published",
        "sleeves.ring.radial_clearance": "200 um",
        "rotors.ring.initial.x": "190 um",
        "run.max_steps": 500,
    }
    stopped = gp.simulate(gp.replace(gp.load_case("han2021"), wedging), duration=0.02, transient=0.5)
    assert not stopped.success
    assert "wedged" not in stopped.message


def test_signals_are_consistent_with_each_other(result: gp.Result) -> None:
    ds = result.ds
    ring = ds.sel(rotor="ring")
    increments = np.diff(ring.x.values) / np.diff(ds.time.values)
    middle = 0.5 * (ring.vx.values[1:] + ring.vx.values[:-1])
    assert np.max(np.abs(increments - middle)) < 1e-3
    total = ds.drive_penetration + ds.back_penetration + ds.backlash
    assert float(np.abs(total).max()) < 1e-15
    assert float(ds.drive_force.min()) >= 0.0
    assert float(ds.back_force.min()) >= 0.0


@pytest.mark.slow
def test_saving_and_reading_back_gives_the_same(result: gp.Result, tmp_path: Path) -> None:
    path = tmp_path / "run.nc"
    result.save(path)
    again = gp.read_result(path)
    assert isinstance(again, gp.Result)
    assert again.case == result.case
    assert again.ds.drop_attrs(deep=False).identical(result.ds.drop_attrs(deep=False))
    assert (again.message, again.status, again.success) == (result.message, result.status, result.success)
    np.testing.assert_array_equal(
        again.spectrum("ax", rotor="ring").amplitude, result.spectrum("ax", rotor="ring").amplitude
    )
    for name, values in result.contacts.values.items():
        np.testing.assert_allclose(again.contacts.values[name], values, rtol=1e-12)
    assert [run.status for run in again.runs] == [run.status for run in result.runs]
    with pytest.raises(gp.InputError, match="must not exist yet"):
        result.save(path)
    result.save(path, overwrite=True)


def test_an_ensemble_has_members_and_a_spectrum_with_spread() -> None:
    result = gp.simulate(
        "han2021", duration=0.05, transient=0.0, sampling=5e3, ensemble=3, signals=["ring.ax", "ring.x"]
    )
    assert result.ds.sizes["member"] == 3
    assert not np.array_equal(
        result.ds.x.sel(rotor="ring", member=1), result.ds.x.sel(rotor="ring", member=2)
    )
    spectrum = result.spectrum("ax", rotor="ring")
    assert spectrum.members == 3
    assert spectrum.spread is not None
    assert np.all(np.isnan(result.ds.x.sel(rotor="pinion").values)), (
        "signals that were not kept are NaN, not zero"
    )


def test_unknown_signals_are_named(result: gp.Result) -> None:
    with pytest.raises(gp.InputError, match="signal"):
        result.spectrum("az", rotor="ring")
    with pytest.raises(gp.InputError, match="signals"):
        gp.simulate("han2021", duration=0.001, signals=["ring.aax"])
    with pytest.raises(gp.InputError, match="sun"):
        result.plot.orbit("sun")


@pytest.mark.slow
def test_pictures__state_case_element_window_and_settings(tmp_path: Path) -> None:
    file = tmp_path / "mine.toml"
    file.write_text(to_toml(load_case("han2021", ["title=My rig"])), encoding="utf-8")
    changed = load_case(file, ["meshes.pinion-ring.backlash=150um", "run.transient=0s"])
    assert changed == load_case(file, ["run.transient=0s", "meshes.0.backlash=150um"])
    found = gp.simulate(changed, duration=0.8)
    found.save(tmp_path / "run.nc")
    plot = gp.read_result(tmp_path / "run.nc").plot
    close = plot.history("backlash")
    title = close.figure.get_suptitle().replace("\n", " ")
    assert title.startswith("My rig; meshes.0.backlash = 150 µm: total backlash along the line of action, ")
    assert title.endswith("of 0 to 0.8 s")
    assert np.ptp(close.get_xlim()) == pytest.approx(10 / 40.0), "ten mesh periods"
    assert np.ptp(plot.history("backlash", window=(None, None)).get_xlim()) == pytest.approx(0.8, abs=1e-3)
    marks = [text.get_text() for text in plot.spectrum("ax", "ring").texts]
    assert "f_m" in marks
    with pytest.raises(gp.InputError, match="centre can move"):
        plot.orbit("pinion")


def test_pictures_draw_without_touching_pyplot(result: gp.Result) -> None:
    import sys

    before = "matplotlib.pyplot" in sys.modules
    for ax in (
        result.plot.orbit("ring"),
        result.plot.history("backlash"),
        result.plot.spectrum("ax", "ring"),
    ):
        assert "[" in ax.get_xlabel()
        assert "[" in ax.get_ylabel(), "axes carry units"
        ax.figure.canvas.draw()
    assert ("matplotlib.pyplot" in sys.modules) == before


def test_html_and_repr_escape_the_title() -> None:
    case = gp.replace(
        gp.load_case("han2021"), {"title": "<b>bold</b> $x$", "run.duration": 0.001, "run.transient": 0.0}
    )
    result = gp.simulate(case)
    assert "<b>bold" not in result._repr_html_()
    assert "DONE" in repr(result)


def test_limits_stop_a_run_and_keep_what_was_computed() -> None:
    case = gp.replace(
        gp.load_case("han2021"), {"run.max_steps": 10_000, "run.duration": 100.0, "run.sampling": 100.0}
    )
    result = gp.simulate(case)
    assert not result.success
    assert result.status.name == "TOO_MANY_STEPS"
    assert "max_steps" in result.message
    assert result.ds.sizes["time"] > 10


@pytest.mark.parametrize(
    ("changes", "limit"),
    [
        ({"run.duration": 1e6, "run.sampling": 1.0, "run.ensemble": 100}, r"limit of 2e\+10 steps"),
    ],
)
def test_a_run_that_is_too_large_is_refused_with_its_estimate(changes: dict, limit: str) -> None:
    with pytest.raises(gp.ResourceError, match=f"about .* {limit}"):
        gp.simulate(gp.replace(gp.load_case("han2021"), changes), signals=["ring.x"])


def stopped_early(result: gp.Result, member: int) -> gp.Result:
    """Return the result with one member as if it had stopped after a third of its record."""
    runs = list(result.runs)
    run = runs[member]
    third = len(run.values) // 3
    runs[member] = dataclasses.replace(
        run,
        samples=WrittenSamples(run.values[:third]),
        status=Status.TOO_MANY_STEPS,
        reached=run.first_sample + third / run.sampling,
    )
    return gp.Result(result.case, runs)


@pytest.mark.slow
def test_an_ensemble_with_a_member_that_stopped_early_has_the_spectrum_of_the_others(tmp_path: Path) -> None:
    whole = gp.simulate("han2021", duration=0.05, transient=0.0, sampling=2e4, ensemble=3)
    stopped = stopped_early(whole, 1)
    assert not stopped.success
    others = gp.Result(whole.case, [whole.runs[0], whole.runs[2]]).spectrum("ax", rotor="ring")
    found = stopped.spectrum("ax", rotor="ring")
    assert found.members == 2
    np.testing.assert_array_equal(found.amplitude, others.amplitude)
    assert stopped.plot.spectrum("ax", "ring").get_lines()
    stopped.save(tmp_path / "run.nc")
    again = gp.read_result(tmp_path / "run.nc")
    np.testing.assert_array_equal(again.spectrum("ax", rotor="ring").amplitude, others.amplitude)
    assert again.time(1).size == stopped.time(1).size == len(stopped.runs[1].values)
    with pytest.raises(gp.InputError, match="has no member that reached its end"):
        stopped_early(stopped_early(stopped, 0), 2).spectrum("ax", rotor="ring")
    with pytest.raises(gp.InputError, match="must have one length"):
        ensemble_spectrum([np.zeros(100), np.zeros(50)], 1.0)


def test_a_history_of_many_samples_keeps_every_impact() -> None:
    """One sample among 300 000 stands out: thinning to each n-th would lose it."""
    result = gp.simulate("han2021", duration=0.01, transient=0.0, sampling=1e5)
    run = result.runs[0]
    values = np.zeros((300_000, len(run.columns)))
    place = next(i for i, c in enumerate(run.columns) if (c.signal, c.label) == ("ax", "ring"))
    values[123_457, place], values[222_223, place] = 70.0, -90.0
    long = gp.Result(result.case, [dataclasses.replace(run, samples=WrittenSamples(values))])
    line = long.plot.history("ax", "ring", window=(None, None)).get_lines()[0]
    drawn = np.asarray(line.get_ydata())
    assert (drawn.max(), drawn.min(), len(drawn) <= 20_000) == (70.0, -90.0, True)
    assert np.asarray(line.get_xdata())[np.argmax(drawn)] == run.first_sample + 123_457 / run.sampling


def test_an_ensembles_contact_table_is_of_all_members_and_says_so() -> None:
    result = gp.simulate("han2021", duration=0.4, transient=0.0, sampling=1e3, signals=["ax"], ensemble=4)
    table = result.contacts
    each = [run.statistics for run in result.runs]
    assert table.members == 4
    np.testing.assert_allclose(
        table.values["impacts_per_second"], np.mean([s.impacts_per_second for s in each], axis=0)
    )
    np.testing.assert_allclose(table.values["peak_force"], np.max([s.peak_force for s in each], axis=0))
    hits = np.array([s.impacts_per_second for s in each])
    speeds = np.array([s.mean_impact_speed for s in each])
    of_all = (hits * speeds).sum(axis=0) / np.maximum(hits.sum(axis=0), 1e-300)
    np.testing.assert_allclose(table.values["mean_impact_speed"], of_all)
    assert "4 members together" in result._repr_html_()
    assert not np.allclose(table.values["impacts_per_second"], each[0].impacts_per_second)
    alone = gp.Result(result.case, result.runs[:1])
    assert "members together" not in alone._repr_html_()
    np.testing.assert_allclose(alone.contacts.values["rms_impact_speed"], each[0].rms_impact_speed)


def test_statistics_of_contacts_are_those_of_their_log() -> None:
    """Onsets per second and their speeds, and the share of time, counted again from the located changes."""
    transient, span = 0.3, 2.0
    run = gp.simulate("han2021", duration=span, transient=transient, sampling=1e3, signals=["ax"]).runs[0]
    s = run.statistics
    assert (run.log[:, 0] >= transient).all()
    for k in range(len(s.labels)):
        own = run.log[run.log[:, 1] == k]
        speeds = own[own[:, 2] == 1.0, 3]
        assert s.impacts_per_second[k] == pytest.approx(len(speeds) / span, rel=1e-12)
        if len(speeds):
            assert s.mean_impact_speed[k] == pytest.approx(speeds.mean(), rel=1e-9)
            assert s.rms_impact_speed[k] == pytest.approx(np.sqrt(np.mean(speeds**2)), rel=1e-9)
            assert s.max_impact_speed[k] == pytest.approx(speeds.max(), rel=1e-9)
        times = own[:, 0].tolist()
        times = [transient, *times] if len(own) and own[0, 2] == 0.0 else times
        times = [*times, transient + span] if len(times) % 2 else times
        touched = sum(b - a for a, b in zip(times[::2], times[1::2], strict=True))
        assert s.share_of_time[k] == pytest.approx(touched / span, rel=1e-6, abs=1e-9)
    assert s.impacts_per_second[0] > 0.0


@pytest.mark.slow
def test_contact_states_are_flags_of_cf(tmp_path: Path) -> None:
    found = gp.simulate("external-pair", duration=0.02, transient=0.0)
    state = found.ds["contact_state"]
    assert state.dtype == np.int8
    assert state.attrs["flag_values"].tolist() == [-1, 0, 1, 2, 3]
    assert len(state.attrs["flag_meanings"].split()) == 5
    found.save(tmp_path / "run.nc")
    again = gp.read_result(tmp_path / "run.nc")
    assert again.ds["contact_state"].dtype == np.int8
    assert again.ds["contact_state"].attrs["flag_values"].tolist() == [-1, 0, 1, 2, 3]
    expected = found.signal("contact_state", "input-output")
    np.testing.assert_array_equal(again.signal("contact_state", "input-output"), expected)
    assert set(expected) <= {0.0, 1.0, 2.0, 3.0}


def test_spectrum__prints_in_one_line_and_as_a_table(result: gp.Result) -> None:
    """Its fields, some 40 kB of numbers, were printed; the largest line is the one that is there."""
    found = result.spectrum("ax", rotor="ring")
    text = repr(found)
    assert len(text) < 200
    at = int(np.argmax(found.amplitude))
    assert f"largest {found.amplitude[at]:.4g} m/s² at {found.frequency[at]:.6g} Hz" in text
    assert f"{found.frequency.size} to 10000 Hz, 20 Hz apart" in text
    html = found._repr_html_()
    assert "<table>" in html
    assert "<svg" in html
    assert len(html) < 20_000
    assert "window hann" in html
