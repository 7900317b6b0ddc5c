"""What is kept of a run: against the same numbers taken from `gearplay.simulate`, closed forms and Parseval's theorem."""

import math
from functools import cache
from typing import Any

import numpy as np
import pytest

import gearplay as gp
from gearplay.model.pack import pack
from gearplay.solver.continuation import End
from gearplay.solver.status import Status
from gearplay.solver.trajectory import Column, ContactStatistics, Counters, Trajectory, WrittenSamples
from gearplay.sweeps.plans.kept import ContactReduction
from gearplay.sweeps.plans.reading import load_sweep
from gearplay.sweeps.running.evaluate import REDUCED, Sweep
from gearplay.sweeps.running.reduce import Reducer
from gearplay.vocabulary.errors import InputError

RATE, MEMBER = 5e3, 1
SET: dict[str, Any] = {
    "run.duration": 0.4,
    "run.transient": 0.1,
    "run.sampling": RATE,
    "rotors.ring.initial.vx": 0.05,
}
AXIS: dict[str, Any] = {"name": "gap", "path": "meshes.0.backlash", "values": [2e-5, 0.0]}
FLOATS = np.ndarray[Any, np.dtype[np.float64]]
STATISTICS = ContactReduction.model_fields["statistic"].annotation.__args__  # type: ignore[union-attr]


def reduction(kind: str, **more: Any) -> dict[str, Any]:
    of = {} if kind in ("contact", "jam", "output") else {"signal": "ax", "at": "ring"}
    return {"kind": kind, "name": "kept", **of, **more}


def made(*reductions: dict[str, Any]) -> Sweep:
    axes = [AXIS, {"name": "gravity", "path": "gravity.1", "values": [0.0, 9.81]}]
    return Sweep(
        load_sweep({"case": "han2021", "set": SET, "axes": axes, "members": 2, "reduce": list(reductions)})
    )


def kept(*reductions: dict[str, Any], jammed: bool = False) -> FLOATS:
    """Return the row of a member of the sweep, at its first or its last values."""
    outcome = made(*reductions).evaluate(3 * jammed)[MEMBER]
    assert outcome.status == 0, outcome.reason
    return outcome.row


@cache
def result(*, jammed: bool = False) -> gp.Result:
    changes = {"meshes.0.backlash": 0.0, "gravity.1": 9.81} if jammed else {"meshes.0.backlash": 2e-5}
    return gp.simulate(gp.replace(gp.load_case("han2021"), {**SET, **changes, "run.ensemble": 2}))


def accelerations() -> FLOATS:
    """Return the mean accelerations of the ring along x between samples [m/s^2], shape [time]."""
    v = result().ds.vx.sel(rotor="ring", member=MEMBER).values
    return (v[1:] - v[:-1]) * RATE


def fake(signal: FLOATS, name: str = "x", dimension: str = "rotor", label: str = "ring") -> Trajectory:
    """Return a finished run that kept one signal."""
    nothing = np.zeros(0)
    return Trajectory(
        member=0,
        first_sample=0.0,
        sampling=RATE,
        samples=WrittenSamples(signal[:, None]),
        columns=(Column(name, dimension, label),),
        statistics=ContactStatistics((), *[nothing] * 7, np.zeros(0, dtype=bool)),
        log=np.zeros((0, 4)),
        status=Status.DONE,
        counters=Counters(),
        reached=signal.size / RATE,
        wall_time=0.0,
        final_state=nothing,
        end=End(nothing, nothing, nothing),
    )


def reduced(run: Trajectory, *reductions: dict[str, Any], slowness: float = 1.0) -> FLOATS:
    sweep = made(*reductions)
    row, lacking = sweep.reducer.row(sweep.template.base, run, slowness=slowness)
    assert lacking == ""
    return row


@pytest.mark.parametrize("name", ["transmission_error", "speed_ripple", "efficiency", "impact_power"])
def test_output__is_that_of_the_result(name: str) -> None:
    """The number of the output shaft in a sweep is the member's in a result."""
    expected = result().output.each[name] if name != "impact_power" else None
    (found,) = kept(reduction("output", statistic=name))
    if expected is None:
        alone = gp.simulate(
            gp.replace(gp.load_case("han2021"), {**SET, "meshes.0.backlash": 2e-5, "run.start": "drawn"})
        )
        assert found == pytest.approx(alone.output.values[name], rel=1e-9)
    else:
        assert found == pytest.approx(expected[MEMBER], rel=1e-9)


def test_output__of_an_unknown_rotor() -> None:
    with pytest.raises(
        InputError, match=r"reduce.kept.at = \"wheel\": must be of this case. Choose from: pinion, ring"
    ):
        made(reduction("output", statistic="efficiency", at="wheel"))


def test_statistics_are_those_of_mean_accelerations() -> None:
    a = accelerations()
    level, central = math.sqrt(np.mean(a**2)), a - np.mean(a)
    expected = {
        "rms": level,
        "mean": np.mean(a),
        "peak": np.max(np.abs(a)),
        "peak_to_peak": np.max(a) - np.min(a),
        "crest_factor": np.max(np.abs(a)) / level,
        "kurtosis": np.mean(central**4) / np.mean(central**2) ** 2,
    }
    row = kept(*(reduction("statistic", name=name, statistic=name) for name in expected))
    assert row == pytest.approx(list(expected.values()), rel=1e-9, abs=1e-12)
    assert expected["kurtosis"] > 3.0, "impacts make it peaked"


def test_the_mean_of_mean_accelerations_is_the_change_of_velocity() -> None:
    v = result().ds.vx.sel(rotor="ring", member=MEMBER).values
    (mean,) = kept(reduction("statistic", statistic="mean"))
    assert mean == pytest.approx((v[-1] - v[0]) * RATE / (v.size - 1), rel=1e-9)


def test_other_signals_are_their_samples() -> None:
    force = result().ds.drive_force.sel(mesh="pinion-ring", member=MEMBER).values
    (peak,) = kept(reduction("statistic", signal="drive_force", at="pinion-ring", statistic="peak"))
    assert peak == np.max(np.abs(force)) > 0.0


def test_a_level_is_the_windowed_power_within_its_band() -> None:
    """Half the squared lines within the band over the window's noise bandwidth, from a transform written out here."""
    a = accelerations()
    n = a.size
    window = np.sin(np.pi * np.arange(n) / n) ** 2
    power = 2.0 * np.abs(np.fft.rfft(window * (a - np.mean(a)))) ** 2 / (n * np.sum(window**2))
    f = np.fft.rfftfreq(n, 1.0 / RATE)
    band = (101.3, 903.7)
    (level,) = kept(reduction("level", band=band))
    assert level == pytest.approx(math.sqrt(np.sum(power[(f > band[0]) & (f < band[1])])), rel=1e-9)


def test_levels_of_adjoining_bands_add_up_to_the_rms_value() -> None:
    """Parseval: stationary noise has within all bands together what it has in time."""
    noise = np.random.default_rng(5).standard_normal(20_000)
    band, parts = (1e-3, RATE / 2.0), [(1e-3, 700.1), (700.1, 1900.1), (1900.1, RATE / 2.0)]
    x = {"signal": "x"}
    row = reduced(
        fake(noise),
        *(reduction("level", name=f"part_{i}", band=b, **x) for i, b in enumerate(parts)),
        reduction("level", name="all", band=band, **x),
        reduction("statistic", **x),
    )
    *some, every, rms = row
    assert math.hypot(*some) == pytest.approx(every, rel=1e-12)
    assert every == pytest.approx(rms, rel=0.02)
    assert some[1] == pytest.approx(rms * math.sqrt(1200.0 / 2500.0), rel=0.05)


def test_a_spectrum_shares_a_level_out() -> None:
    band = (100.0, 1100.0)
    row = kept(reduction("spectrum", band=band, count=50), reduction("level", name="level", band=band))
    assert row.size == 51
    assert math.sqrt(np.sum(row[:50] ** 2)) == pytest.approx(row[50], rel=1e-12)
    found = made(reduction("spectrum", band=band, count=50)).reducer.layout[0]
    assert (found.along, found.along_unit, len(found.grid)) == ("kept_frequency", "Hz", 50)
    assert found.grid[:2] == pytest.approx((110.0, 130.0))


def test_a_tone_falls_into_its_part_of_a_spectrum() -> None:
    tone = 3.0 * np.sin(2.0 * np.pi * 415.0 * np.arange(10_000) / RATE)
    row = reduced(fake(tone), reduction("spectrum", signal="x", band=(100.0, 1100.0), count=50))
    assert int(np.argmax(row)) == 15
    assert row[15] == pytest.approx(3.0 / math.sqrt(2.0), rel=1e-3)


@pytest.mark.parametrize("frequency", [40.0, 40.13, 39.777])
def test_a_line_has_its_amplitude_and_frequency(frequency: float) -> None:
    t = np.arange(10_000) / RATE
    noise = 0.01 * np.random.default_rng(6).standard_normal(t.size)
    amplitude, found = reduced(
        fake(7.0 + 2.5 * np.cos(2.0 * np.pi * frequency * t) + noise),
        reduction("line", signal="x", near=40.0),
    )
    assert amplitude == pytest.approx(2.5, rel=5e-3)
    assert found == pytest.approx(frequency, abs=0.01)


def test_mean_acceleration__a_line_is_attenuated_by_the_averaging() -> None:
    """A velocity A sin(2 pi f t) has increments of amplitude A 2 sin(pi f / fs)."""
    f, t = 800.0, np.arange(10_000) / RATE
    tone = fake(0.3 * np.sin(2.0 * np.pi * f * t), "vx")
    amplitude, found = reduced(tone, reduction("line", near=f))
    assert amplitude == pytest.approx(0.3 * 2.0 * RATE * math.sin(math.pi * f / RATE), rel=1e-3)
    assert found == pytest.approx(f, abs=0.05)


@pytest.mark.parametrize(("order", "slowness"), [(1, 1.0), (3, 1.0), (3, 0.8)])
def test_orders_count_from_the_mesh_frequency(order: int, slowness: float) -> None:
    """The pinion's 20 teeth at 120 rpm mesh 40 times a second."""
    t = np.arange(20_000) / RATE
    tones = sum(k * np.sin(2.0 * np.pi * 40.0 * slowness * k * t) for k in (1, 2, 3))
    amplitude, found = reduced(
        fake(np.asarray(tones)), reduction("line", signal="x", order=order), slowness=slowness
    )
    assert (amplitude, found) == pytest.approx((order, 40.0 * slowness * order), rel=1e-3)


@pytest.mark.slow
def test_hump__is_the_highest_broad_one_in_its_band() -> None:
    """Noise through a resonance, beside a higher line out of the band.

    White noise has lines of 2 sqrt(1.5 / n) with a Hann window; the smoothing (8 % of 300 Hz) widens the resonance's power
    (40 Hz / sqrt(2)) and lowers it as much.
    """
    noise, t = np.random.default_rng(7).standard_normal(20_000), np.arange(20_000) / RATE
    f = np.fft.rfftfreq(t.size, 1.0 / RATE)
    broad = np.fft.irfft(np.fft.rfft(noise) * np.exp(-0.5 * ((f - 300.0) / 40.0) ** 2))
    run = fake(broad + 5.0 * np.sin(2.0 * np.pi * 900.0 * t))
    amplitude, found = reduced(run, reduction("hump", signal="x", band=(100.0, 700.0)))
    assert found == pytest.approx(300.0, rel=0.05)
    narrow, smoothing = 40.0 / math.sqrt(2.0), 0.08 * 300.0
    lowered = math.sqrt(narrow / math.hypot(narrow, smoothing))
    assert amplitude == pytest.approx(2.0 * math.sqrt(1.5 / t.size) * lowered, rel=0.1)


@pytest.mark.parametrize("contact", ["ring", "pinion-ring:drive", "pinion-ring:back"])
def test_contacts_have_their_statistics(contact: str) -> None:
    expected = [float(result().ds[name].sel(contact=contact, member=MEMBER)) for name in STATISTICS]
    row = kept(*(reduction("contact", name=name, contact=contact, statistic=name) for name in STATISTICS))
    assert row.tolist() == expected
    assert all(value > 0.0 for value in expected)


def test_jam_is_the_share_of_time_with_both_flanks_pressed() -> None:
    """Without backlash, and with a weight that hangs across the line of centres, the mesh jams at times."""
    (share,) = kept(reduction("jam", mesh="pinion-ring"), jammed=True)
    state = result(jammed=True).ds.contact_state.sel(mesh="pinion-ring", member=MEMBER).values
    assert share == np.count_nonzero(state == 3.0) / state.size
    assert 0.0 < share < 1.0
    states = fake(np.array([0.0, 1.0, 2.0, 3.0, 3.0]), "contact_state", "mesh", "pinion-ring")
    assert reduced(states, reduction("jam", mesh="pinion-ring")).tolist() == [0.4]


def test_a_history_is_the_record() -> None:
    x = result().ds.x.sel(rotor="ring", member=MEMBER).values
    row = kept(reduction("history", signal="x"), reduction("history", name="other"))
    assert np.array_equal(row[: x.size], x)
    assert np.array_equal(row[x.size :], accelerations())
    position, acceleration = made(
        reduction("history", signal="x"), reduction("history", name="other")
    ).reducer.layout
    assert (position.along, position.along_unit) == ("kept_time", "s")
    assert position.grid == pytest.approx(tuple(np.arange(x.size) / RATE))
    assert len(acceleration.grid) == x.size - 1


def test_a_row_is_laid_out_as_the_plan_lists_it() -> None:
    every = [
        reduction("line", name="line", order=1),
        reduction("statistic", name="kurtosis", statistic="kurtosis"),
        reduction("spectrum", name="spectrum", band=(10.0, 100.0), count=4),
        reduction("contact", name="hits", contact="ring", statistic="impacts_per_second"),
        reduction("hump", name="hump", signal="x", band=(10.0, 100.0)),
        reduction("jam", name="jam", mesh="pinion-ring"),
        reduction("level", name="level", signal="theta", band=(10.0, 100.0)),
    ]
    reducer = made(*every).reducer
    assert [(k.name, k.unit, k.size) for k in reducer.layout] == [
        ("line_amplitude", "m/s^2", 1),
        ("line_frequency", "Hz", 1),
        ("kurtosis", "1", 1),
        ("spectrum", "m/s^2", 4),
        ("hits", "1/s", 1),
        ("hump_amplitude", "m", 1),
        ("hump_frequency", "Hz", 1),
        ("jam", "1", 1),
        ("level", "rad", 1),
    ]
    assert all(k.long_name for k in reducer.layout)
    row = kept(*every)
    assert row.size == reducer.size == 12
    assert row[0] == kept(every[0])[0]
    assert row[7] == kept(every[3])[0]
    assert row[11] == kept(every[6])[0]


def test_only_the_signals_that_are_needed_are_kept() -> None:
    reducer = made(reduction("statistic"), reduction("level", name="level", band=(1.0, 20.0))).reducer
    assert reducer.signals == ["ring.vx"]
    assert made(reduction("contact", contact="ring", statistic="peak_force")).reducer.signals == []


def test_what_does_not_move_has_no_shape() -> None:
    row = reduced(
        fake(np.zeros(100)),
        *(
            reduction("statistic", name=s, signal="x", statistic=s)
            for s in ("rms", "kurtosis", "crest_factor")
        ),
    )
    assert row[0] == 0.0
    assert np.isnan(row[1:]).all()


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        (reduction("statistic", signal="axx"), r"reduce\.kept\.signal = \"axx\""),
        (reduction("statistic", at="rng"), r"reduce\.kept\.at = \"rng\""),
        (reduction("statistic", signal="backlash"), r"reduce\.kept\.at = \"ring\""),
        (
            reduction("contact", contact="pinion", statistic="peak_force"),
            r"reduce\.kept\.contact = \"pinion\"",
        ),
        (reduction("jam", mesh="ring"), r"reduce\.kept\.mesh = \"ring\""),
    ],
)
def test_what_the_case_does_not_have_is_refused(wrong: dict[str, Any], words: str) -> None:
    with pytest.raises(InputError, match=words):
        made(wrong)


def test_orders_need_a_mesh() -> None:
    disc = {
        "rotors": {"disc": {"mass": 0.5, "inertia": 1e-4}},
        "sleeves": {"disc": {"radial_clearance": 1e-4, "stiffness": 1e9, "restitution": 0.9}},
        "run": {"duration": 0.1},
    }
    case = gp.load_case(disc)
    document = {"case": disc, "reduce": [reduction("line", at="disc", order=1)]}
    with pytest.raises(InputError, match="must not be given: the case has no mesh"):
        Reducer(load_sweep(document), case, pack(case))


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ({"kind": "line", "near": 2501.0}, r'reduce\.kept\.near = "2501 Hz": must be at most 2500 Hz, half of run\.sampling'),
        ({"kind": "level", "band": [10.0, 2600.0]}, r'reduce\.kept\.band = "2600 Hz": must be at most 2500 Hz'),
        ({"kind": "hump", "band": [1.0, 8.0]}, r"must be at least 7\.5 Hz wide: a record of 0\.4 s"),
        ({"kind": "spectrum", "band": [1.0, 101.0], "count": 41}, r"count = 41: must be at most 40"),
    ],
)  # fmt: skip
def test_frequencies_that_the_record_does_not_hold_are_refused(wrong: dict[str, Any], words: str) -> None:
    with pytest.raises(InputError, match=words):
        made({**reduction(wrong["kind"]), **wrong})


def test_a_reduction_that_fails_leaves_the_others() -> None:
    """At 0 rpm there is no mesh line, but there is an rms value."""
    line = reduction("line", name="line", order=1)
    axis = {"name": "speed", "path": "rotors.pinion.drive.speed", "values": ["60 rpm", "0 rpm"]}
    plan = {"case": "han2021", "set": SET, "axes": [axis], "reduce": [reduction("statistic"), line]}
    sweep = Sweep(load_sweep(plan))
    (whole,), (partly,) = sweep.evaluate(0), sweep.evaluate(1)
    assert (whole.status, partly.status) == (0, REDUCED)
    assert partly.reason.startswith("reduce.line: band = ")
    assert np.isfinite(whole.row).all()
    assert np.isfinite(partly.row).tolist() == [True, False, False]


def test_statistics_of_couplings__have_units_of_rotations() -> None:
    """The largest load of a coupling is a torque; of the flanks of the same train it is a force."""
    wanted = (("motor-pinion:forward", "N m"), ("pinion-wheel:drive", "N"))
    plan = {
        "case": "torsional-train",
        "axes": [{"name": "gap", "path": "meshes.0.backlash", "values": [1e-4, 2e-4]}],
        "reduce": [reduction("contact", name=f"peak_{k}", contact=contact, statistic="peak_force")
                   for k, (contact, _) in enumerate(wanted)],
    }  # fmt: skip
    case = gp.load_case("torsional-train")
    assert [kept.unit for kept in Reducer(load_sweep(plan), case, pack(case)).layout] == [
        unit for _, unit in wanted
    ]
