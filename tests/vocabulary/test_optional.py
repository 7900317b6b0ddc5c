import sys
from pathlib import Path

import pytest

from gearplay.vocabulary.errors import InputError
from gearplay.vocabulary.optional import cure_for, load_optional


def test_a_missing_library_is_named_with_its_cure() -> None:
    with pytest.raises(InputError) as caught:
        load_optional("no_such_library", "calibration")
    said = f"no_such_library: is needed for this and not installed. {cure_for('calibration')}."
    assert str(caught.value) == said


def test_the_cure_is_the_command_of_this_environment(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "prefix", str(tmp_path / ".venv"))
    monkeypatch.setattr(sys, "executable", "/usr/bin/python3")
    assert cure_for("web") == "Run: /usr/bin/python3 -m pip install 'gearplay[web]'"
    (tmp_path / "Makefile").touch()
    (tmp_path / "src" / "gearplay").mkdir(parents=True)
    assert cure_for("web") == f"Run: make -C {tmp_path} extras"
    monkeypatch.chdir(tmp_path)
    assert cure_for("web") == "Run: make extras"
