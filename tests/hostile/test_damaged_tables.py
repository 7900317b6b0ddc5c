"""A hundred damaged files of each table of elements, excitation and environment: one sentence each, exit code 2."""

import contextlib
import io
from pathlib import Path

import pytest

from depth import some
from gearplay.cli.main import run
from gearplay.model.reading import load_case
from gearplay.vocabulary.errors import InputError
from hostile.damage_tables import TABLES, Table, slips
from hostile.test_damaged_cases import check_message, guard_against_hanging

pytestmark = pytest.mark.hostile
each_table = pytest.mark.parametrize("table", TABLES, ids=lambda table: table.name)


@each_table
def test_the_sound_file_is_accepted(table: Table, tmp_path: Path) -> None:
    path = tmp_path / "sound.toml"
    path.write_text(table.file)
    load_case(path)


@pytest.mark.slow
@each_table
def test_a_hundred_slips_get_a_sentence_each(table: Table, tmp_path: Path) -> None:
    """Every one is refused by a sentence that names its field; the command says so with exit code 2."""
    damages = list(slips(table))
    assert len(damages) >= 100
    assert len({case.content for case in damages}) == len(damages)
    path = tmp_path / "case.toml"
    for case in some(damages):
        path.write_bytes(case.content)
        with guard_against_hanging(), pytest.raises(InputError) as caught:
            load_case(path)
        check_message(str(caught.value), case)
        said = io.StringIO()
        with contextlib.redirect_stderr(said):
            assert run(["check", str(path)]) == 2
        assert str(caught.value).splitlines()[-1].strip() in said.getvalue()
        assert len(caught.value.faults) == 1 or any(
            case.named[0] in fault.path for fault in caught.value.faults
        )
