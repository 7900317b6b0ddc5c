"""What the page opens, saves, links to and finds again."""

import json
import resource
from pathlib import Path

import pytest

from serving import Server, Visit
from visiting import BACKLASH, SPEED, Open, brief, field, fill, shown, small_map


@pytest.mark.slow
def test_a_file_is_opened(visit: Open, tmp_path: Path) -> None:
    from gearplay.model.reading import load_case, to_toml

    file = tmp_path / "mine.toml"
    file.write_text(to_toml(load_case("han2021", ["title=Mine", "meshes.0.backlash=70um"])), encoding="utf-8")
    made = visit(plots=False).ready()
    made.after(lambda: made.page.set_input_files("#upload", file))
    assert made.page.text_content("#title") == "Mine"
    assert field(made, BACKLASH).input_value() == "70"


@pytest.mark.slow
@pytest.mark.many
@pytest.mark.parametrize(
    ("name", "content", "said"),
    [
        (
            "case.toml",
            'title = "für"\n'.encode("latin-1"),
            "case.toml: must be UTF-8 text. Save the file as UTF-8.",
        ),
        ("bad.toml", b"not = [a case", "bad.toml: is not valid TOML"),
        ("bad.toml", b"[rotors.a]\nmass = -1\n", "rotors.a"),
        ("bad.toml", b"", "rotors"),
        ("run.nc", b"\x89HDF", "run.nc: must be a case file"),
    ],
)
def test_a_bad_file_is_refused_and_the_case_stays(
    visit: Open, tmp_path: Path, name: str, content: bytes, said: str
) -> None:
    file = tmp_path / name
    file.write_bytes(content)
    made = visit(plots=False).ready()
    made.page.set_input_files("#upload", file)
    made.until(f"document.getElementById('message').textContent.includes({json.dumps(said)})")
    assert made.page.text_content("#title") == "Han 2021, 120 rpm, 100/100 um"
    made.complaints[:] = [
        each for each in made.complaints if "400" not in each
    ]  # the browser notes the refusal


@pytest.mark.deep
def test_a_link_carries_the_case(visit: Open) -> None:
    made = visit().ready()
    fill(made, BACKLASH, "140")
    made.page.click("#share")
    made.until("location.hash.startsWith('#case=')")
    link = made.page.evaluate("location.hash")
    other = visit("/" + link).ready()
    assert field(other, BACKLASH).input_value() == "140"
    assert other.page.evaluate("window.gearplay.state.base.meshes[0].backlash") == pytest.approx(140e-6)


@pytest.mark.slow
@pytest.mark.many
@pytest.mark.parametrize(
    ("form", "start"), [("nc", b"\x89HDF"), ("csv", b"member,time [s],"), ("toml", b"# The rig of Han")]
)
def test_results_and_cases_are_saved(visit: Open, form: str, start: bytes) -> None:
    made = visit(plots=False).ready()
    with made.page.expect_download() as waited:
        made.page.select_option("#save", form)
    path = Path(waited.value.path())
    assert path.read_bytes().startswith(start)
    of = "" if form == "toml" else "-coupled"
    assert waited.value.suggested_filename == f"han-2021-120-rpm-100-100-um{of}.{form}"


@pytest.mark.deep
@pytest.mark.many
@pytest.mark.parametrize(("form", "start"), [("png", b"\x89PNG"), ("svg", b"<svg")])
def test_pictures_are_saved(visit: Open, form: str, start: bytes) -> None:
    made = visit().ready()
    with made.page.expect_download() as waited:
        made.page.select_option("#save", form)
    assert Path(waited.value.path()).read_bytes().startswith(start)


@pytest.mark.deep
def test_save__without_a_result_is_reported(visit: Open) -> None:
    made = visit(plots=False).ready()
    made.page.click("#tab-map")
    made.page.select_option("#save", "csv")
    made.until("document.getElementById('message').textContent.includes('nothing to save here yet')")


@pytest.mark.deep
def test_a_result_of_another_case_brings_its_case_back(visit: Open) -> None:
    made = visit().ready()
    brief(made)
    small_map(made)
    made.page.click("#tab-run")
    made.after(lambda: made.page.select_option("#case", "pinion-idler-ring"))
    made.after(lambda: recall(made, "map, Han 2021"))
    assert made.page.text_content("#title") == "Han 2021, 120 rpm, 100/100 um"
    assert made.page.locator("#panel-map").is_visible()
    assert field(made, "run.duration").input_value() == "0.05"
    assert made.page.evaluate("document.getElementById('map').data[0].z.length") == 2


@pytest.mark.deep
def test_damaged_link__is_reported(visit: Open) -> None:
    made = visit("/#case=eyJydW4iOnsiZH").ready()
    made.until("document.getElementById('message').textContent.includes('The link is damaged')")


def recall(made: Visit, start: str) -> None:
    """Choose the newest of the results that are kept whose words start so."""
    words = "[...document.getElementById('history').options]"
    made.until(f"{words}.some((each) => each.text.startsWith({json.dumps(start)}))")
    key = made.page.evaluate(f"{words}.find((each) => each.text.startsWith({json.dumps(start)})).value")
    made.page.select_option("#history", value=key)


@pytest.mark.deep
def test_earlier_results_are_recalled(visit: Open) -> None:
    made = visit().ready()
    fill(made, BACKLASH, "111")
    wanted = shown(made, "result.sha256")
    fill(made, BACKLASH, "112")
    recall(made, "run, Han 2021, 120 rpm, 100/100 um, pinion-ring backlash 111 µm")
    made.until(f"window.gearplay.state.result.sha256 === {json.dumps(wanted)}")
    assert field(made, BACKLASH).input_value() == "111"
    assert made.page.text_content("#changes") == "changed: pinion-ring backlash 111 µm"


@pytest.mark.slow
def test_case_file__is_saved_as_written(visit: Open) -> None:
    made = visit(plots=False).ready()
    fill(made, BACKLASH, "150")
    with made.page.expect_download() as waited:
        made.page.select_option("#save", "toml")
    text = Path(waited.value.path()).read_text(encoding="utf-8")
    assert text.startswith("# The rig of Han")
    assert 'backlash = "150 um"                     # article: 100 or 200 um' in text


@pytest.mark.slow
def test_unstorable_result__is_reported_until_the_next_run(server: Server, visit: Open) -> None:
    """At the limit of a file's size writes fail as on a full disk."""
    made = visit(plots=False).ready()
    unlimited = resource.prlimit(server.process.pid, resource.RLIMIT_FSIZE)
    resource.prlimit(server.process.pid, resource.RLIMIT_FSIZE, (1000, unlimited[1]))
    try:
        fill(made, SPEED, "131.5")
        made.until("document.getElementById('message').textContent.includes('not kept among the results')")
        assert not made.page.locator("#message").is_hidden()
    finally:
        resource.prlimit(server.process.pid, resource.RLIMIT_FSIZE, unlimited)
    fill(made, SPEED, "132.5")
    assert made.page.text_content("#message") == ""
