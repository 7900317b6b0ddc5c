"""`gearplay plot` and `gearplay animate`: pictures of stored results; conftest looks at each of them."""

import io
import json
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import gearplay as gp
from depth import sized
from gearplay.cli.main import run
from gearplay.cli.plot import KINDS, window_of
from gearplay.model.reading import bundled_names
from gearplay.pictures.moving import has_mp4
from pictures import faults_of

PLACES = {"han2021": ("ring", "pinion-ring"), "two-stage-reducer": ("layshaft", "layshaft.pinion-output")}


class Results(dict[str, Path]):
    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def __missing__(self, name: str) -> Path:
        self[name] = self.folder / f"{name}.nc"
        gp.simulate(name, duration=0.7, sampling=2e4).save(self[name])
        return self[name]


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> Results:
    """Return short results of the bundled cases, simulated when first used."""
    return Results(tmp_path_factory.mktemp("results"))


def drawn(path: Path) -> np.ndarray:
    return np.asarray(Image.open(path).convert("RGB"), dtype=float)


@pytest.mark.slow
@pytest.mark.many
@pytest.mark.parametrize("kind", list(KINDS))
@pytest.mark.parametrize("name", bundled_names())
def test_every_kind_of_picture_of_every_bundled_case(
    name: str, kind: str, results: Results, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    code = run(["plot", str(results[name]), "--kind", kind, "--out", str(tmp_path / "picture.png")])
    said = capsys.readouterr()
    if kind == "orbit" and "rotor whose centre can move" in said.err:
        assert code == 2
        assert not gp.load_case(name).sleeves
        return
    assert code == 0, said.err
    assert "picture.png" in said.out
    assert np.ptp(drawn(tmp_path / "picture.png")) > 200.0


@pytest.mark.slow
@pytest.mark.many
@pytest.mark.parametrize("name", PLACES)
def test_what_is_asked_for_is_drawn(name: str, results: Results, tmp_path: Path) -> None:
    case = str(results[name])
    rotor, mesh = PLACES[name]
    orders = [
        ["--signal", f"{rotor}.ax", "--signal", f"{mesh}.backlash"],
        ["--signal", "ax", "--at", rotor, "--kind", "spectrum"],
        ["--at", mesh],
        ["--kind", "orbit", "--at", rotor],
        ["--kind", "mechanism", "--at", mesh, "--window", f"{gp.load_case(name).run.transient}:"],
        ["--kind", "portrait", "--at", rotor],
    ]
    pictures = []
    for at, more in enumerate(orders):
        assert run(["plot", case, *more, "--out", str(tmp_path / f"{at}.png")]) == 0
        pictures.append((tmp_path / f"{at}.png").read_bytes())
    assert len(set(pictures)) == len(pictures)


@pytest.mark.slow
def test_titles_say_case_change_and_window(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    titles: list[str] = []
    from gearplay.pictures import canvas

    monkeypatch.setattr(
        canvas, "to_bytes", lambda figure, form: titles.append(figure.get_suptitle()) or b"picture"
    )
    path = tmp_path / "run.nc"
    case = gp.replace(gp.load_case("han2021"), {"meshes.pinion-ring.backlash": "150 um", "run.duration": 0.1})
    gp.simulate(case, transient=0.0).save(path)
    assert run(["plot", str(path), "--kind", "history", "--window", "20ms:80ms"]) == 0
    assert "Han 2021" in titles[0]
    assert "backlash = 150 µm" in titles[0].replace("\n", " ")
    assert "0.02 to 0.08 s" in titles[0].replace("\n", " ")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("words", "rule"),
    [
        (["--kind", "histry"], "Did you mean 'history'?"),
        (["--signal", "ring.aw"], "Did you mean 'ring.ay'?"),
        (["--kind", "orbit", "--signal", "x"], "has no meaning for orbit"),
        (["--kind", "orbit", "--at", "pinion"], "rotor whose centre can move"),
        (["--at", "rung"], "Did you mean 'ring'?"),
        (["--window", ":100ms"], "must lie within the result"),
        (["--window", "5:6"], "must lie within the result"),
        (["--window", "0.7:0.6"], "must begin before it ends"),
        (["--window", "1 kg:2"], "--window"),
        (["--window", "3"], "two times with a colon between"),
        (["--out", "a.jpg"], "must end in .png, .svg, .pdf"),
    ],
)
def test_faults(words: list[str], rule: str, results: Results, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["plot", str(results["han2021"]), *words]) == 2
    said = capsys.readouterr().err
    assert rule in said
    assert "Traceback" not in said


@pytest.mark.slow
def test_read_result__another_file_is_refused_with_a_cure(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], results: Results
) -> None:
    assert run(["plot", "han2021"]) == 2
    assert "gearplay run han2021 --out run.nc" in capsys.readouterr().err
    (tmp_path / "no.nc").write_bytes(b"nothing")
    for verb in ("plot", "animate"):
        assert run([verb, str(tmp_path / "no.nc")]) == 2
        assert run([verb, str(tmp_path / "absent.nc")]) == 2
    out = tmp_path / "a.png"
    words = ["plot", str(results["han2021"]), "--out", str(out)]
    assert run(words) == 0
    assert run(words) == 2
    assert run([*words, "--overwrite"]) == 0


@pytest.mark.slow
def test_json_says_where_it_is(results: Results, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "a.svg"
    assert run(["plot", str(results["han2021"]), "--out", str(out), "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["out"] == str(out)
    assert document["kind"] == "overview"
    assert "<svg" in out.read_text(encoding="utf-8")


@pytest.mark.slow
@pytest.mark.parametrize("name", ["planetary-reducer", "two-stage-reducer"])
def test_a_gif_moves(name: str, results: Results, tmp_path: Path) -> None:
    out, frames = tmp_path / "motion.gif", sized(24, 6)
    assert run(["animate", str(results[name]), "--out", str(out), "--frames", str(frames)]) == 0
    film = Image.open(io.BytesIO(out.read_bytes()))
    assert film.n_frames == frames
    pictures = []
    for at in range(frames):
        film.seek(at)
        pictures.append(np.asarray(film.convert("RGB"), dtype=float))
    changed = [np.count_nonzero(np.abs(a - b).max(axis=2) > 60.0) for a, b in pairwise(pictures)]
    assert min(changed) > 100


@pytest.mark.slow
def test_a_page_holds_the_motion_and_needs_nothing_else(
    results: Results, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "motion.html"
    words = ["animate", str(results["planetary-reducer"]), "--out", str(out), "--magnify", "2", "--json"]
    assert run(words) == 0
    assert json.loads(capsys.readouterr().out)["frames"] == 900
    page = out.read_text(encoding="utf-8")
    assert len(page) < 3e6
    assert "Planetary reducer 17/37/91" in page
    for outside in ('src="', 'href="', "import(", "http://", "https://"):
        assert outside not in page


@pytest.mark.slow
@pytest.mark.parametrize(
    ("words", "rule"),
    [
        (["--out", "a.avi"], "must end in .html, .gif, .mp4"),
        (["--magnify", "0"], "--magnify"),
        (["--frames", "1"], "--frames"),
        (["--at", "rung"], "Did you mean 'ring'?"),
    ],
)
def test_faults_of_animations(
    words: list[str], rule: str, results: Results, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["animate", str(results["han2021"]), *words]) == 2
    assert rule in capsys.readouterr().err


def test_a_film_needs_ffmpeg(results: Results, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "motion.mp4"
    code = run(["animate", str(results["han2021"]), "--out", str(out), "--frames", "5"])
    if has_mp4():
        assert code == 0
        assert out.read_bytes()[4:8] == b"ftyp"
    else:
        assert code == 2
        assert "Install ffmpeg" in capsys.readouterr().err


def test_windows() -> None:
    assert window_of("0.5s : 600ms") == (0.5, 0.6)
    assert window_of(":0.1") == (None, 0.1)


def test_a_picture_with_faults_is_found() -> None:
    from gearplay.pictures.canvas import make_figure

    figure, axes = make_figure(1, 2, 2.0)
    axes[0, 0].plot([0.0, 1.0], [1e6, 1e6 + 1e-3])
    axes[0, 0].ticklabel_format(useOffset=True)
    figure.text(0.9, 0.02, "a text that runs over the edge of the picture")
    axes[0, 0].text(0.5, 0.5, "one", transform=axes[0, 0].transAxes)
    axes[0, 0].text(0.5, 0.5, "two", transform=axes[0, 0].transAxes)
    found = " ".join(faults_of(figure))
    for word in ("cut off", "'one' lies over 'two'", "blank", "offset", "has no name"):
        assert word in found
