"""Damaged and hostile REXS files: every one is read or refused in one message, within bounds of memory and time."""

import base64
import io
import random
import re
import time
import tracemalloc
import zipfile
from pathlib import Path

import pytest

import gearplay as gp
from depth import sized
from gearplay.cli.main import run
from gearplay.rexs import opening
from gearplay.rexs.importing import import_rexs
from rexs.gearbox_files import PLANETARY, RIGID, TWO_STAGES, packed, pair, place, unpacked

pytestmark = pytest.mark.hostile

DECLARED = '<?xml version="1.0"?><!DOCTYPE model [{}]><model version="1.4">{}</model>'


def refused(tmp_path: Path, content: bytes | str, match: str, name: str = "box.rexs") -> None:
    path = tmp_path / name
    path.write_bytes(content if isinstance(content, bytes) else content.encode("utf-8"))
    start = time.monotonic()
    with pytest.raises(gp.InputError, match=match) as caught:
        import_rexs(path)
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) < 500
    assert time.monotonic() - start < 60.0  # a hang, not a measure


def test_entities_are_refused(tmp_path: Path) -> None:
    laughs = "".join(f'<!ENTITY l{k} "{f"&l{k - 1};" * 10 if k else "ha"}">' for k in range(12))
    refused(tmp_path, DECLARED.format(laughs, "&l11;"), "no document type and no entities")
    secret = tmp_path / "secret.txt"
    secret.write_text("42", encoding="utf-8")
    refused(tmp_path, DECLARED.format(f'<!ENTITY x SYSTEM "{secret.as_uri()}">', "&x;"), "no document type")
    refused(
        tmp_path,
        '<!DOCTYPE model SYSTEM "http://localhost:9/x.dtd"><model version="1.4"/>',
        "no document type",
    )


def test_archives_that_unpack_to_any_size_are_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(opening, "LARGEST", 1_000_000)
    bomb = packed(b"<" + b" " * 50_000_000)
    assert len(bomb) < 100_000
    tracemalloc.start()
    refused(tmp_path, bomb, "at most 0 MiB, unpacked too")
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 10_000_000
    refused(tmp_path, b"<model>" + b" " * 2_000_000, "at most 0 MiB")


def test_archives_of_other_things_are_refused(tmp_path: Path) -> None:
    refused(tmp_path, packed("x", "notes.txt"), "must have one member", "no_rexs_file.rexsz")
    two = io.BytesIO()
    with zipfile.ZipFile(two, "w") as archive:
        archive.writestr("a.rexs", "<model/>")
        archive.writestr("b.rexsj", "{}")
    refused(tmp_path, two.getvalue(), "it has 2 among 2")
    whole = packed(unpacked(TWO_STAGES))
    refused(tmp_path, whole[: len(whole) // 2], "archive: is damaged")
    encrypted = bytearray(whole)
    for mark, at in ((b"PK\x01\x02", 8), (b"PK\x03\x04", 6)):
        encrypted[whole.index(mark) + at] |= 1
    refused(tmp_path, bytes(encrypted), "archive: is damaged, encrypted")


def test_what_is_no_model_is_refused(tmp_path: Path) -> None:
    for content, match in (
        ("", "must be a REXS model"),
        (b"\x00" * 100, "must be a REXS model"),
        ("<html></html>", "first element is <model>"),
        ('{"case": 1}', "first entry is 'model'"),
        ("[1]", "must be a REXS model"),
        ('<model version="2.0"><components/></model>', "REXS 1.0 to 1.6"),
        ('<model version="1.4"/>', "must have components"),
        ("<model", "not valid XML"),
        ('{"model": {"version": "1.4", "components": [1]}}', "must be a JSON object"),
        ('{"model": {"version": "1.4", "components": [{"id": NaN}]}}', "finite numbers"),
        ("[" * 100_000, "must be a REXS model"),
        ('{"a":' * 100_000, "nested too deep|not valid JSON"),
        ("<model>" + "<a>" * 5000, "nest elements at most"),
        ('{"model": {"version": "1.4", "components": [{"id": ' + "9" * 5000 + "}]}}", "not valid JSON"),
        ('<?xml version="1.0" encoding="klingon"?><model/>', "not valid XML"),
    ):
        refused(tmp_path, content, match)
    with pytest.raises(gp.InputError, match="no such file"):
        import_rexs(tmp_path / "missing.rexs")
    with pytest.raises(gp.InputError, match="regular file"):
        import_rexs(tmp_path)


def test_references_and_cycles_are_refused(tmp_path: Path) -> None:
    box = pair()
    box.relate("assembly", assembly=2, part=999)
    refused(tmp_path, box.xml(), "refers to component 999 as part")
    box = pair()
    box.relate("assembly", assembly=2, part=4)
    box.relate("assembly", assembly=4, part=2)
    refused(tmp_path, box.xml(), "must not be a part of itself")
    box = pair()
    for one, other in ((2, 4), (4, 2)):
        kind, name, attributes = box.components[one]
        box.components[one] = (kind, name, {**attributes, "reference_component_for_position": other})
    refused(tmp_path, box.xml(), "placed relative to itself")
    text = pair().xml().replace('<component id="4"', '<component id="2"')
    refused(tmp_path, text, "component 2: must be there once")
    box = pair()
    box.cases[1] = {77: {"rotational_speed": (1.0, "1 / min")}}
    box.components[77] = ("shaft", "", {})
    text = re.sub(r'<component id="77"[^\n]*\n', "", box.xml(), count=1)
    refused(tmp_path, text, "load_case 1: refers to component 77")


def test_long_chains_end(tmp_path: Path) -> None:
    """Parts of parts, couplings in a row and places relative to each other, more than Python's stack holds."""
    box = pair()
    last = 2
    for _ in range(1500):
        shaft = box.add("shaft", "", reference_component_for_position=last, **place((1.0, 0.0)))
        box.hold(last, shaft, "coupling", **RIGID)
        box.relate("assembly", assembly=last, part=shaft)
        last = shaft
    refused(tmp_path, box.xml(), "placed relative to itself")
    text = re.sub(r'<attribute id="reference_component_for_position"[^/]*/attribute>', "", box.xml())
    (tmp_path / "chain.rexs").write_text(text, encoding="utf-8")
    assert len(import_rexs(tmp_path / "chain.rexs").case.rotors) == 2
    many = '<component id="{}" type="cylindrical_gear"/>'
    text = (
        pair()
        .xml()
        .replace("</components>", "".join(many.format(k) for k in range(100, 1000)) + "</components>")
    )
    refused(tmp_path, text, "at most 800 gears")


def coded(kind: str, text: str) -> str:
    array = f'<component id="99" type="x"><attribute id="a"><array code="{kind}">{text}</array></attribute></component>'
    return pair().xml().replace("</components>", f"{array}</components>")


def test_coded_arrays(tmp_path: Path) -> None:
    refused(tmp_path, coded("float64", "AAAA"), "whole numbers of 8 bytes")
    refused(tmp_path, coded("float64", "$$$$"), "valid base64")
    refused(tmp_path, coded("complex", "AAAA"), "coded as int32, float32, float64")
    huge = base64.b64encode(bytes(4 * 2_100_000)).decode()
    refused(tmp_path, coded("int32", huge), "elements and values")
    (tmp_path / "sound.rexs").write_text(
        coded("float32", base64.b64encode(bytes(8)).decode()), encoding="utf-8"
    )
    assert import_rexs(tmp_path / "sound.rexs").case


def test_too_many_elements_are_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("gearplay.rexs.values.MOST", 10_000)
    cells = "<c>1</c>" * 20_000
    text = (
        pair()
        .xml()
        .replace(
            "</components>",
            f'<component id="99" type="x"><attribute id="a"><array>{cells}</array></attribute></component></components>',
        )
    )
    monkeypatch.setattr("gearplay.rexs.values.Budget.__init__", lambda self: setattr(self, "left", 10_000))
    refused(tmp_path, text, "at most 10000 elements")


def test_names_cannot_break_the_case_file(tmp_path: Path) -> None:
    """Names with quotes, line breaks and controls end up in comments and plain names."""
    box = pair()
    for number in (2, 4):
        kind, _, attributes = box.components[number]
        box.components[number] = (kind, '"]\n[rotors.evil]\nmass = "1 kg"\u202e\u2028 #', attributes)
    text = box.xml().replace('applicationId="t"', 'applicationId="t\u202e\u2028x"')
    (tmp_path / "box.rexs").write_text(text, encoding="utf-8")
    found = import_rexs(tmp_path / "box.rexs")
    assert "evil" not in "".join(name for name in found.case.rotors if not name.startswith("rotors_evil"))
    assert len(found.case.rotors) == 2
    assert all(line.isprintable() for line in found.text.splitlines())


VALUES = ("", "0", "-1", "1e308", "nan", "inf", "true", "abc", "1e-300", "999999999", "20.5", "-0.0", "1e20")
TOKENS = ("1", "2", "53", "shaft", "x", "mm", "N m", "stage", "gear_1", "assembly", "-5", "none", "kg", "°")


def damaged(text: str, rng: random.Random) -> str:
    """Return a text with one place changed: a value, an element, an attribute of an element, or characters."""
    chance = rng.random()
    if chance < 0.4 and (hits := list(re.finditer(r">([^<>\s][^<>]*)<|: (-?[\d.]+)[,\n} ]", text))):
        hit = rng.choice(hits)
        group = 1 if hit[1] else 2
        return text[: hit.start(group)] + rng.choice(VALUES) + text[hit.end(group) :]
    if chance < 0.6 and (
        hits := list(
            re.finditer(r"\s*<(relation|component|ref|attribute)\b[^>]*?(/>|>.*?</\1>)", text, re.DOTALL)
        )
    ):
        hit = rng.choice(hits)
        return text[: hit.start()] + text[hit.end() :]
    if chance < 0.8 and (hits := list(re.finditer(r'(id|type|role|unit|version)="([^"]*)"', text))):
        hit = rng.choice(hits)
        return text[: hit.start(2)] + rng.choice(TOKENS) + text[hit.end(2) :]
    at = rng.randrange(len(text))
    return (
        text[:at]
        + (rng.choice(["<", "&", "\x00", "é", "]]>", "{", "[", "\n"]) if chance < 0.9 else "")
        + text[at + rng.randrange(50) :]
    )


def test_damaged_models_are_read_or_refused(tmp_path: Path) -> None:
    rng, path, outcomes = random.Random(5), tmp_path / "box.rexs", {"read": 0, "refused": 0}
    sources = [unpacked(PLANETARY), unpacked(TWO_STAGES), pair().xml(), pair().json()]
    for _ in range(sized(600)):
        text = rng.choice(sources)
        for _ in range(rng.choice([1, 1, 2, 5])):
            text = damaged(text, rng)
        path.write_bytes(text.encode("utf-8", "surrogatepass"))
        try:
            import_rexs(path)
            outcomes["read"] += 1
        except gp.InputError:
            outcomes["refused"] += 1
    assert min(outcomes.values()) > 0


def test_the_command_says_one_sentence(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "box.rexs"
    path.write_text(DECLARED.format("", ""), encoding="utf-8")
    assert run(["import", str(path)]) == 2
    said = capsys.readouterr().err.strip().splitlines()
    assert len(said) == 1
    assert not (tmp_path / "case.toml").exists()
    pair().write(tmp_path)
    assert run(["import", str(path)]) == 0
    assert (tmp_path / "case.toml").exists()
    capsys.readouterr()
    assert run(["import", str(path)]) == 2
    assert "must not exist yet" in capsys.readouterr().err
