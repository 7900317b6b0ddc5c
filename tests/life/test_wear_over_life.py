"""Wear over life: closed forms of Flodin and Andersson and of Archard, worn volume against sliding work, growth of play."""

import json
import math
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
import xarray as xr

import gearplay as gp
from building import Document, Floats, merged
from gearplay.cli.main import run
from gearplay.life.bushes import ANGLES, bush_rates, clearance_of_wear, worn_sleeves
from gearplay.life.flanks import HEIGHTS, SIDES, added_backlash, flank_rates, wearing_flanks
from gearplay.model.case import Case
from gearplay.parts.mesh.train import geometry
from gearplay.pictures.canvas import to_png
from life.pairs import K, wearing_pair

SPEED = 20.0 * math.pi
"""Speed of the pinion [rad/s]."""
LINE_LOAD = 1e5
"""Line load of the closed forms [N/m]."""


class Motion(NamedTuple):
    """Signals of a made-up block, as a result returns them."""

    case: Case
    signals: dict[tuple[str, str], Floats]

    @property
    def runs(self) -> list[None]:
        return [None]

    @property
    def ds(self) -> xr.Dataset:
        slots = [f"{self.case.meshes[0].label}:{side}-0" for side in SIDES]
        return xr.Dataset(coords={"pair": slots})

    def signal(self, name: str, label: str, member: int = 0) -> Floats:
        if f"{label}.{name}" in ("two.omega", "one.omega"):
            size = self.signals["theta", "two"].size if ("theta", "two") in self.signals else 1
            return np.full(size, SPEED if label == "one" else -SPEED / 3.0)
        return self.signals[name, label]


def under_constant_load(document: Document) -> Motion:
    """Return a block in which each pair of teeth carries one line load along its whole path."""
    case = gp.load_case(document)
    path = geometry.installed_pair(case, 0).path
    label = case.meshes[0].label
    signals = {}
    for side, load in zip(SIDES, (LINE_LOAD, 0.0), strict=True):
        place = np.linspace(path.start - 1e-3, path.end + 1e-3, 5000)
        signals["pair_place", f"{label}:{side}-0"] = place
        signals["pair_force", f"{label}:{side}-0"] = np.full(place.size, load * 0.01)
    return Motion(case, signals)


def test_flanks__under_constant_load_wear_as_flodin_and_andersson_have_it() -> None:
    """20/60, k 1e-16 m^2/N, 100 N/mm: depths [um] after a million turns of the pinion at A, at a quarter, pitch point and E."""
    motion = under_constant_load(wearing_pair())
    flanks = wearing_flanks(motion.case)
    rates, _ = flank_rates(motion, flanks)  # type: ignore[arg-type]
    time = 1e6 * 2.0 * math.pi / SPEED
    pinion, wheel = (1e6 * time * rates[gear, "left"] for gear in ("one", "two"))
    for at, first, second in ((0, 44.696761, 2.723913), (10, 9.254181, 1.602108), (-1, 5.358322, 3.847978)):
        assert pinion[at] == pytest.approx(first, rel=1e-6)
        assert wheel[::-1][at] == pytest.approx(second, rel=1e-6)
    pair = geometry.installed_pair(motion.case, 0)
    pitch = (pair.pitch_place - pair.path.start) / pair.path.length
    assert np.interp(pitch, HEIGHTS, pinion) < 0.3
    sliding = pair.specific_sliding(np.array([pair.pitch_place]))
    np.testing.assert_allclose(sliding, 0.0, atol=1e-12)
    assert np.all(rates["one", "right"] == 0.0)


def test_driven_coefficient__is_that_of_the_driven_gear() -> None:
    wear = {"coefficient": K, "driven_coefficient": 3.0 * K}
    one, other = (
        flank_rates(motion, wearing_flanks(motion.case))[0]  # type: ignore[arg-type]
        for motion in map(under_constant_load, (wearing_pair(), with_mesh({"wear": wear})))
    )
    np.testing.assert_allclose(other["one", "left"], one["one", "left"], rtol=1e-12)
    np.testing.assert_allclose(other["two", "left"], 3.0 * one["two", "left"], rtol=1e-12)


def test_coefficient_of_0__is_a_side_that_does_not_wear() -> None:
    """The other side wears as it does beside one that wears, since Archard's law has no term of both."""
    wear = {"coefficient": 0.0, "driven_coefficient": K}
    one, hard = (
        flank_rates(motion, wearing_flanks(motion.case))[0]  # type: ignore[arg-type]
        for motion in map(under_constant_load, (wearing_pair(), with_mesh({"wear": wear})))
    )
    assert np.all(hard["one", "left"] == 0.0)
    np.testing.assert_array_equal(hard["two", "left"], one["two", "left"])
    _, motion = bearing_motion(load_turns=False)
    both = bush_rates(motion, "two")  # type: ignore[arg-type]
    for factors, free in (((0.0, K), "journal"), ((K, 0.0), "bush")):
        changed = {
            f"sleeves.two.wear.{name}": k
            for name, k in zip(("coefficient", "bush_coefficient"), factors, strict=True)
        }
        rates = bush_rates(motion._replace(case=gp.replace(motion.case, changed)), "two")  # type: ignore[arg-type]
        assert np.all(rates[free] == 0.0)
        other = "bush" if free == "journal" else "journal"
        np.testing.assert_array_equal(rates[other], both[other])


@pytest.mark.parametrize(
    ("document", "field"),
    [
        (lambda: with_mesh({"wear": {"coefficient": 0.0}}), "driven_coefficient"),
        (lambda: wearing_pair(sleeves={"two": {"wear": {"coefficient": 0.0, "bush_coefficient": 0.0}}}), "bush_coefficient"),
    ],
    ids=["flanks", "bush"],
)  # fmt: skip
def test_coefficients_of_0__of_both_sides_are_refused(document: Any, field: str) -> None:
    with pytest.raises(
        gp.InputError, match=rf"wear\.coefficient = 0\.0: must be greater than 0 m\^2/N unless {field} is"
    ):
        gp.load_case(document())


def with_mesh(changes: Document, **more: Any) -> Document:
    """Return the pair with changes of its mesh."""
    document = wearing_pair(**more)
    return {**document, "meshes": [merged(document["meshes"][0], changes)]}


def bearing_motion(load_turns: bool) -> tuple[Case, Motion]:
    """Return a block of three turns under 100 N, from above on the ground, or turning with the journal."""
    case = gp.load_case(wearing_pair())
    turn = 6.0 * math.pi * np.arange(21_600) / 21_600
    away = turn + 0.5 * math.pi if load_turns else 0.5 * math.pi + 0.0 * turn
    signals = {
        ("sleeve_force_x", "two"): 100.0 * np.cos(away),
        ("sleeve_force_y", "two"): 100.0 * np.sin(away),
        ("theta", "two"): turn,
    }
    return case, Motion(case, signals)


def test_bush__under_a_fixed_load_wears_by_archard() -> None:
    """100 N, 10 mm, a million turns: 1 um off the journal all round, pi k F / (theta_0 L) off the bush over its arc 2 theta_0."""
    case, motion = bearing_motion(load_turns=False)
    rates = bush_rates(motion, "two")  # type: ignore[arg-type]
    time = 1e6 * 6.0 * math.pi / SPEED  # the wheel turns at a third of the pinion's speed
    depths = {surface: time * rate for surface, rate in rates.items()}
    np.testing.assert_allclose(depths["journal"], 1e-6, rtol=1e-6)
    deepest = math.pi * K * 100.0 / (math.radians(30.0) * 0.01) * 1e6
    assert np.max(depths["bush"]) == pytest.approx(deepest, rel=1e-6)
    below = np.abs((ANGLES - 1.5 * math.pi + math.pi) % (2.0 * math.pi) - math.pi)
    assert np.all(depths["bush"][below > math.radians(31.0)] < 1e-15)
    assert np.mean(depths["bush"]) == pytest.approx(1e-6, rel=1e-6)
    assert clearance_of_wear(depths) == pytest.approx(1e-6 + 0.5 * deepest, rel=1e-6)
    changed = worn_sleeves(case, {"two": depths})
    assert changed["sleeves.two.radial_clearance"] == pytest.approx(21e-6 + 0.5 * deepest, rel=1e-6)
    assert changed["sleeves.two.offset"] == pytest.approx([0.0, -0.5 * deepest], abs=1e-12)


def test_bush__under_a_turning_load_wears_all_round() -> None:
    _, motion = bearing_motion(load_turns=True)
    rates = bush_rates(motion, "two")  # type: ignore[arg-type]
    np.testing.assert_allclose(rates["bush"], np.mean(rates["bush"]), rtol=1e-6)
    assert np.max(rates["journal"]) == pytest.approx(6.0 * np.mean(rates["journal"]), rel=1e-6)
    depths = {"journal": 0.0 * rates["bush"], "bush": rates["bush"]}
    assert clearance_of_wear(depths) == pytest.approx(np.mean(rates["bush"]), rel=1e-6)


def test_bush__counts_whole_turns_only() -> None:
    """2.4 turns under a fixed load wear the journal as evenly as 3 do; part of a turn is refused."""
    _, motion = bearing_motion(load_turns=False)
    cut = motion._replace(signals={key: values[: 2 * 7200 + 2880] for key, values in motion.signals.items()})
    found = bush_rates(cut, "two")["journal"]  # type: ignore[arg-type]
    np.testing.assert_allclose(found, bush_rates(motion, "two")["journal"], rtol=1e-6)  # type: ignore[arg-type]
    short = motion._replace(signals={key: values[:3600] for key, values in motion.signals.items()})
    with pytest.raises(
        gp.InputError, match=r'run.duration = "0.31 s": must be at least 0.62. s, a turn of two'
    ):
        bush_rates(short, "two")  # type: ignore[arg-type]


def test_bush__of_a_rocking_journal_counts_all_of_the_block() -> None:
    """A journal that swings by 20 deg under a fixed load wears on one side, as far as arc and swing reach."""
    _, motion = bearing_motion(load_turns=False)
    swing = np.radians(20.0) * np.sin(motion.signals["theta", "two"])
    rates = bush_rates(motion._replace(signals={**motion.signals, ("theta", "two"): swing}), "two")  # type: ignore[arg-type]
    reach = np.abs((ANGLES - 1.5 * math.pi + math.pi) % (2.0 * math.pi) - math.pi)
    assert np.all(rates["journal"][reach > math.radians(51.0)] < 1e-9 * np.max(rates["journal"]))
    assert np.mean(rates["journal"]) == pytest.approx(np.mean(rates["bush"]), rel=1e-9)


@pytest.fixture(scope="module")
def worn() -> Any:
    return gp.wear(wearing_pair(), turns=2e5, blocks=2)


def test_worn_volume__is_the_coefficient_times_the_sliding_work(worn: Any) -> None:
    """Archard: k times the integral of force times sliding speed over the same motion, for each gear, and of the bush."""
    case = gp.load_case(wearing_pair())
    result = gp.simulate(case)
    pair = geometry.installed_pair(case, 0)
    work = 0.0
    for slot in range(4):
        label = f"one-two:drive-{slot}"
        place, force = (result.signal(name, label) for name in ("pair_place", "pair_force"))
        inside = (place >= pair.path.start) & (place <= pair.path.end)
        work += float(np.mean(np.where(inside, force * np.abs(pair.sliding(place)) * SPEED, 0.0)))
    time = 1e5 * 2.0 * math.pi / SPEED
    volumes = worn.ds["worn_volume"].sel(flank=["one left", "two left"]).values[1]
    np.testing.assert_allclose(volumes, K * work * time, rtol=0.01)
    load = np.mean(np.hypot(*(result.signal(f"sleeve_force_{axis}", "two") for axis in "xy")))
    journal = worn.ds["journal_depth"].values[1, 0]
    assert np.mean(journal) == pytest.approx(K * load * 1e5 / 3.0 / 0.01, rel=1e-3)


def test_play__grows_with_life(worn: Any) -> None:
    """The lost volume goes on at the same rate; backlash and clearance grow, and the worn case has them."""
    ds = worn.ds
    assert np.all(np.diff(ds["backlash"].values[:, 0]) > 1e-8)
    growth = np.diff(ds["radial_clearance"].values[:, 0])
    assert growth == pytest.approx([growth[0]] * 2, rel=1e-3)
    assert worn.worn_case.sleeves["two"].radial_clearance == ds["radial_clearance"].values[-1, 0]
    assert worn.case_at(0).sleeves["two"] == gp.load_case(wearing_pair()).sleeves["two"]
    faults = worn.worn_case.faults
    assert [(fault.at, fault.flank) for fault in faults] == [("one", "left"), ("two", "left")]
    assert [depth for _, depth in faults[0].profile] == ds["depth"].sel(flank="one left").values[-1].tolist()
    assert "100 to" in worn.message
    assert "take more blocks" not in worn.message


def test_life__goes_on_from_the_worn_case(worn: Any) -> None:
    """Two blocks, and one block twice from the case that the first left, wear alike."""
    once = gp.wear(wearing_pair(), turns=1e5, blocks=1)
    again = gp.wear(once.worn_case, turns=1e5, blocks=1)
    np.testing.assert_allclose(again.ds["depth"].values[0], once.ds["depth"].values[-1], rtol=1e-12)
    np.testing.assert_allclose(
        again.ds["depth"].values[-1], worn.ds["depth"].values[-1], rtol=1e-3, atol=1e-10
    )
    clearances = [each.ds["radial_clearance"].values[-1, 0] for each in (again, worn)]
    assert clearances[0] == pytest.approx(clearances[1], rel=1e-5)


def test_load__leaves_the_places_that_wear_most(worn: Any) -> None:
    load = worn.ds["line_load"].sel(side="one-two:drive").values
    assert load[1, 1] < 0.95 * load[0, 1]
    assert load[1].mean() == pytest.approx(load[0].mean(), rel=0.02)


def test_added_backlash__of_even_wear_is_its_depth_on_both_gears() -> None:
    case = gp.load_case(wearing_pair())
    flanks = wearing_flanks(case)
    depths = {key: np.full(len(HEIGHTS), 1e-6 if key[1] == "left" else 2e-6) for key in flanks}
    assert added_backlash(case, 0, depths, flanks) == pytest.approx(6e-6, rel=1e-12)


def test_long_block__is_called_so() -> None:
    found = gp.wear(wearing_pair(sleeves={"two": {"wear": None}}), turns=1e7, blocks=1)
    assert "take more blocks" in found.message
    assert "sleeve" not in found.ds.dims


@pytest.mark.parametrize(
    ("document", "words"),
    [
        (with_mesh({"wear": None}, sleeves={"two": {"wear": None}}), r"wear.*required in a mesh or a sleeve"),
        (with_mesh({"contact": "mesh"}), r'meshes.0.wear.*contact = "pairs"'),
        (wearing_pair(rotors={"one": {"drive": {"speed": 0.0}}, "two": {"load": None}}), r"rotor.*must turn"),
    ],
)  # fmt: skip
def test_what_cannot_wear__is_refused(document: Document, words: str) -> None:
    with pytest.raises(gp.InputError, match=words):
        gp.wear(document, turns=1e5, blocks=1)


def test_path__to_a_base_tangent_point_is_refused() -> None:
    """The tips of the ring of this case reach the tangent point of its pinion."""
    case = gp.replace("han2021-pairs", {"meshes.0.wear": {"coefficient": K}})
    with pytest.raises(gp.InputError, match=r"rotors.ring.tip_diameter.*base tangent point of pinion"):
        gp.wear(case, turns=1e5, blocks=1)


def test_rotor__must_be_one() -> None:
    with pytest.raises(gp.InputError, match=r'rotor = "three": must be a rotor.*one, two'):
        gp.wear(wearing_pair(), turns=1e5, rotor="three")
    found = gp.wear(wearing_pair(), turns=1e5, blocks=1, rotor="two")
    assert found.ds["radial_clearance"].values[-1, 0] > 20e-6
    assert found.ds.attrs["rotor"] == "two"


PINS = {"planetary.stage.pin.wear": {"coefficient": K, "length": 0.02, "arc": math.radians(60.0)}}


def test_pin_of_a_planet__under_a_constant_load_wears_by_archard() -> None:
    """200 N on the third pin in the direction of its motion: k F / L a turn off the bore, 2 pi k F / (arc L) off the pin.

    The clearance grows by the bore's depth and half the pin's; the centre moves by half the pin's along the load.
    """
    case = gp.replace(
        "planetary-reducer", {**PINS, "planetary.stage.pin_errors": [{"planet": 3, "radial": "5 um"}]}
    )
    # Three turns of the planet against the carrier.
    carrier = 0.3 + 3.0 * 37.0 / 91.0 * 2.0 * math.pi * np.arange(21_600) / 21_600
    planet = carrier * (1.0 - 91.0 / 37.0)  # rolls in the ring
    away = carrier + 4.0 / 3.0 * math.pi + 0.5 * math.pi  # the pin pushes the planet forwards
    motion = Motion(
        case,
        {
            ("sleeve_force_x", "stage.planet3"): 200.0 * np.cos(away),
            ("sleeve_force_y", "stage.planet3"): 200.0 * np.sin(away),
            ("theta", "stage.planet3"): planet,
            ("theta", "stage.carrier"): carrier,
            ("omega", "stage.planet3"): np.full(carrier.size, 1.0 - 91.0 / 37.0),
            ("omega", "stage.carrier"): np.ones(carrier.size),
        },
    )
    turns = 1e6
    time = (
        turns * 2.0 * math.pi * 37.0 / 91.0
    )  # turns of the planet on its pin, one of the carrier in 2 pi seconds
    depths = {surface: time * rate for surface, rate in bush_rates(motion, "stage.planet3").items()}  # type: ignore[arg-type]
    bore, pin = K * 200.0 / 0.02 * turns, 2.0 * math.pi / math.radians(60.0) * K * 200.0 / 0.02 * turns
    np.testing.assert_allclose(depths["journal"], bore, rtol=1e-6)
    assert np.max(depths["bush"]) == pytest.approx(pin, rel=1e-6)
    off = {"stage.planet1": 0.0, "stage.planet2": 0.0, "stage.planet3": 1.0}
    every = {
        name: {surface: share * depth for surface, depth in depths.items()} for name, share in off.items()
    }
    changed = gp.replace(case, worn_sleeves(case, every))
    errors = changed.planetary["stage"].pin_errors
    assert [each.clearance for each in errors] == pytest.approx([0.0, 0.0, bore + 0.5 * pin], rel=1e-6)
    assert (errors[2].radial, errors[2].tangential) == pytest.approx((5e-6, -0.5 * pin), rel=1e-6)
    assert changed.sleeves["stage.planet3"].radial_clearance == pytest.approx(
        10e-6 + bore + 0.5 * pin, rel=1e-6
    )
    assert changed.sleeves["stage.planet1"].radial_clearance == 10e-6
    assert [each.tangential for each in errors[:2]] == [0.0, 0.0]


def test_pins_of_planets__lose_the_coefficient_times_the_sliding_work() -> None:
    """Archard: of each planet k times the mean of force times sliding speed, over 2 pi r L; the pin ahead of its place less."""
    sun = {
        "planetary.stage.sun.floating": False,
        "planetary.stage.pin_errors": [{"planet": 2, "tangential": "20 um"}],
    }
    case = gp.replace("planetary-reducer", {**PINS, **sun, "run.duration": 0.25, "run.transient": 0.1})
    found = gp.wear(case, turns=1e5, blocks=1)
    result = gp.simulate(case)
    time, names = 1e5 * 60.0 / 800.0, [f"stage.planet{k}" for k in (1, 2, 3)]
    lost = []
    for name in names:
        force = np.hypot(*(result.signal(f"sleeve_force_{axis}", name) for axis in "xy"))
        sliding = np.abs(result.signal("omega", name) - result.signal("omega", "stage.carrier"))
        lost.append(K * np.mean(force * sliding) * time / (2.0 * math.pi * 0.02))
    last = found.ds.isel(turns=-1)
    assert [*last["sleeve"].values] == names
    for surface in ("journal_depth", "bush_depth"):
        np.testing.assert_allclose(last[surface].mean("direction"), lost, rtol=0.03)
    assert lost[1] < 0.8 * min(lost[0], lost[2])
    grown = [found.worn_case.sleeves[name].radial_clearance for name in names]
    np.testing.assert_allclose(grown, last["radial_clearance"], rtol=1e-9)
    assert found.worn_case.planetary["stage"].pin.radial_clearance == 10e-6
    assert gp.simulate(found.worn_case, duration=0.01, transient=0.0).success


def test_sleeve_of_a_sun__wears_in_its_table() -> None:
    case = gp.replace("planetary-reducer", {"planetary.stage.sun.floating": False, "planetary.stage.sun.sleeve": {
        "radial_clearance": "20 um", "stiffness": "2e10 N/m^1.5", "restitution": 0.8,
        "wear": {"coefficient": K, "length": 0.02}}})  # fmt: skip
    depths = {surface: np.full(len(ANGLES), 1e-6) for surface in ("journal", "bush")}
    changed = gp.replace(case, worn_sleeves(case, {"stage.sun": depths}))
    assert changed.sleeves["stage.sun"].radial_clearance == pytest.approx(22e-6, rel=1e-12)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        (
            {"planetary.stage.pin": None, "planetary.stage.support": {"stiffness": [1e8, 1e8]}},
            "must not be given without pin",
        ),
        (
            {"planetary.stage.pin.radial_clearance": "99 mm"},
            "at most 100 mm together with pin.radial_clearance",
        ),
    ],
)
def test_clearance_of_one_pin__that_cannot_be(changes: Document, words: str) -> None:
    worn = {"planetary.stage.pin_errors": [{"planet": 1, "clearance": "2 mm"}]}
    with pytest.raises(gp.InputError, match=rf"planetary.stage.pin_errors.0.clearance.*{words}"):
        gp.replace("planetary-reducer", {**worn, **changes})


def test_wear__on_the_command_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    case = tmp_path / "pair.toml"
    from gearplay.model.toml_files import write_toml

    case.write_text(write_toml(wearing_pair()))
    words = ["wear", str(case), "--turns", "1e5", "--blocks", "1", "--out", str(tmp_path / "w")]
    assert run([*words, "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    found = gp.wear(wearing_pair(), turns=1e5, blocks=1)
    assert document["backlash"]["one-two"] == pytest.approx(float(found.ds["backlash"][-1, 0]), rel=1e-12)
    assert gp.read_result(document["out"]).message == document["message"]
    again = gp.load_case(document["worn_case"])
    assert again.sleeves["two"].radial_clearance == pytest.approx(
        document["radial_clearance"]["two"], rel=1e-12
    )
    assert Path(document["picture"]).stat().st_size > 10_000
    assert run(words) == 2
    assert "overwrite" in capsys.readouterr().err


def test_planets__wear_on_one_flank_by_the_sun_and_on_the_other_by_the_ring() -> None:
    """Of steel on steel both sides of a mesh lose as much: the sun what all planets lose on that flank, the ring the other."""
    teeth = {f"planetary.stage.{member}.facewidth": 0.05 for member in ("sun", "planets", "ring")}
    pairs = {
        "planetary.stage.sun_planet": None,
        "planetary.stage.planet_ring": None,
        "planetary.stage.stiffness": {"kind": "teeth", "method": "iso6336"},
        "planetary.stage.contact": "pairs",
        "planetary.stage.wear": {"coefficient": K},
    }
    case = gp.replace("planetary-reducer", {**teeth, **pairs, "run.duration": 0.05, "run.transient": 0.05})
    found = gp.wear(case, turns=1e5, blocks=1)
    volumes = found.ds["worn_volume"].isel(turns=-1).to_series()
    for member, flank in (("sun", "left"), ("ring", "right")):
        planets = sum(volumes[f"stage.planet{k} {flank}"] for k in (1, 2, 3))
        assert volumes[f"stage.{member} {flank}"] == pytest.approx(planets, rel=0.02)
        assert planets > 1e-11
    assert volumes["stage.sun right"] == volumes["stage.ring left"] == 0.0
    assert gp.simulate(found.worn_case, duration=0.01, transient=0.0).success


def test_figure__of_many_blocks_has_curves_that_all_eyes_tell_apart() -> None:
    """The fixture of all figures judges the colours."""
    wear = "sleeves.ring.wear={coefficient=1e-16, length=0.01}"
    case = gp.load_case("han2021", [wear, "run.duration=1.6"])
    figure = gp.wear(case, turns=1e6).plot()
    to_png(figure)
    assert len({tuple(line.get_color()) for line in figure.axes[0].get_lines()}) == 5


def test_life__that_wears_off_half_of_a_tooth_or_a_bush_is_refused() -> None:
    """In one sentence, not as the points of a profile that no one wrote; 11.8 mm of base pitch leave 2.95 mm."""
    few = with_mesh({}, run={"duration": 0.31, "transient": 0.05})
    with pytest.raises(
        gp.InputError, match=r"turns = 1.*at most 2.95 mm of a flank: two left lacks .* fewer turns"
    ) as found:
        gp.wear(few, turns=1e10, blocks=2)
    assert len(found.value.faults) == 1
    with pytest.raises(gp.InputError, match=r"turns = 1.*clearance of at most 100 mm: that of two is"):
        gp.wear(with_mesh({"wear": None}), turns=1e12, blocks=1)
