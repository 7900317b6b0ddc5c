"""The ten questions of the first hour (first_hour.md): each is answered on a first screen."""

import html
import re
from pathlib import Path
from typing import Any

import pytest
from matplotlib.text import Text

from gearplay.cli.main import run
from gearplay.model.toml_files import write_toml
from gearplay.pictures import canvas

ROW = re.compile(r"^\| (?P<question>[^|]+\?[^|]*) \| (?P<screen>\w+) \| `(?P<answer>.*)` \|$", re.MULTILINE)
QUESTIONS = [
    match.groups()
    for match in ROW.finditer(Path(__file__).with_name("first_hour.md").read_text(encoding="utf-8"))
]
SHORT = {"run.duration": 0.05, "run.transient": 0.0, "run.sampling": 1e3, "run.tolerance": 1e-6}
ERROR = "meshes.0.transmission_error.0.amplitude"
MAP: dict[str, Any] = {
    "title": "map",
    "case": "han2021",
    "members": 2,
    "set": SHORT,
    "axes": [
        {
            "name": "speed",
            "path": "rotors.pinion.drive.speed",
            "low": "60 rpm",
            "high": "300 rpm",
            "count": 4,
        },
        {
            "name": "play",
            "path": "sleeves.ring.radial_clearance",
            "low": "10 um",
            "high": "300 um",
            "count": 4,
        },
    ],
    "reduce": [{"kind": "statistic", "name": "rms", "signal": "ax", "at": "ring"}],
}
TOLERANCE = {
    **{key: value for key, value in MAP.items() if key != "axes"},
    "title": "tolerances",
    "design": {
        "kind": "monte-carlo",
        "count": 16,
        "parameters": [
            {"name": "error", "path": ERROR, "distribution": "uniform", "low": "0.5 um", "high": "4 um"}
        ],
    },
    "tolerance": {"measure": "rms", "limit": "0.2 m/s^2", "probability": 0.5, "scale": ["error"], "steps": 5},
}
CALIBRATION: dict[str, Any] = {
    "title": "small",
    "case": "han2021",
    "set": {"run.tolerance": 1e-6},
    "sensor": {"rotor": "ring"},
    "parameters": [
        {"name": "drag", "path": "rotors.ring.load.drag", "low": "1e-4 N m s/rad", "high": "1e-3 N m s/rad"},
        {"name": "error", "path": ERROR, "low": "0.1 um", "high": "2 um"},
    ],
    "models": [{"name": name, "set": {"backlash_model": name}} for name in ("coupled", "uncoupled")],
    "simulation": {"members": 2, "duration": "1 s", "transient": "0.1 s", "sampling": "500 Hz"},
    "effort": {
        "evaluations": 24,
        "startup": 16,
        "polish": 0,
        "polish_members": 2,
        "check_members": 2,
        "seed": 3,
    },
    "targets": [{"kind": "line", "name": "mesh", "order": 1, "search": 0.1}],
    "conditions": [
        {
            "name": name,
            "set": {"rotors.pinion.drive.speed": speed},
            "measured": {"mesh": {"amplitude": amplitude}},
        }
        for name, speed, amplitude in (("slow", "60 rpm", 0.004), ("fast", "120 rpm", 0.008))
    ],
}


def first_screen(page: Path) -> str:
    """Return the text of a report up to the section after the answer, without its pictures."""
    text = page.read_text(encoding="utf-8")
    begin = text.index("<h1")
    sections = [match.start() for match in re.finditer("<h2", text[begin:])]
    answered = re.match(r"<h2[^>]*>Answer", text[begin + sections[0] :])
    end = begin + sections[1 if answered else 0]
    return html.unescape(re.sub(r"\s+", " ", re.sub(r"<[^>]*>", " ", text[begin:end])))


@pytest.fixture(scope="module")
def screens(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """Return what a newcomer sees first, by the names of first_hour.md."""
    folder = tmp_path_factory.mktemp("hour")

    def plan(name: str, document: dict[str, Any]) -> str:
        path = folder / f"{name}.toml"
        path.write_text(write_toml(document), encoding="utf-8")
        return str(path)

    calls = {
        "study": ["study", "han2021", "--members", "2", "--duration", "2"],
        "sweep": ["sweep", plan("map", MAP)],
        "tolerance": ["sweep", plan("tolerance", TOLERANCE)],
        "calibration": ["calibrate", plan("calibration", CALIBRATION)],
    }
    for name, words in calls.items():
        assert run([*words, "--out", str(folder / name)]) == 0
    pages = {"tolerance": "tolerance.html"}
    return {name: first_screen(folder / name / pages.get(name, "report.html")) for name in calls}


def said_by_run(folder: Path, capsys: pytest.CaptureFixture[str]) -> str:
    words = ["run", "han2021", "--duration", "1s", "--set", "meshes.pinion-ring.backlash=150um"]
    assert run([*words, "--out", str(folder / "run.nc")]) == 0
    return capsys.readouterr().out


def shown_by_plot(folder: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    shown: list[str] = []

    def keep(figure: Any, form: str) -> bytes:
        shown.extend(text.get_text() for text in figure.findobj(Text))
        return b"picture"

    monkeypatch.setattr(canvas, "to_bytes", keep)
    assert run(["plot", str(folder / "run.nc")]) == 0
    title = next(text for text in shown if "overview" in text)
    return " ".join([title, *shown])


@pytest.mark.slow
@pytest.mark.parametrize(("question", "screen", "answer"), QUESTIONS, ids=[each[0] for each in QUESTIONS])
def test_a_question_is_answered(
    question: str,
    screen: str,
    answer: str,
    screens: dict[str, str],
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    if screen in ("run", "plot"):
        capsys.readouterr()
        seen = said_by_run(tmp_path, capsys)
        seen = shown_by_plot(tmp_path, monkeypatch) if screen == "plot" else seen
    else:
        seen = screens[screen]
    assert re.search(answer.replace(r"\|", "|"), seen, re.DOTALL), seen[:1500]


def test_there_are_ten_questions() -> None:
    assert len(QUESTIONS) == 10
