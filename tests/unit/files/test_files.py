"""Files are whole or absent, never replaced unasked; refusals are one sentence."""

import os
from pathlib import Path

import pytest

from gearplay.files.atomic import check_new, read_dataset, replacing, write_text
from gearplay.vocabulary.errors import InputError


def test_a_failed_write_leaves_the_old_file_and_no_leftovers(tmp_path: Path) -> None:
    target = tmp_path / "result.txt"
    write_text(target, "old")

    def break_off() -> None:
        with replacing(target) as temporary:
            temporary.write_text("half")
            raise RuntimeError("broken")

    with pytest.raises(RuntimeError, match="broken"):
        break_off()
    assert target.read_text() == "old"
    assert os.listdir(tmp_path) == ["result.txt"]


def test_an_existing_file_is_kept_unless_asked(tmp_path: Path) -> None:
    target = tmp_path / "result.nc"
    target.write_text("x")
    with pytest.raises(InputError, match="must not exist yet"):
        check_new(target, overwrite=False)
    check_new(target, overwrite=True)


def test_a_place_that_cannot_be_written_is_one_sentence(tmp_path: Path) -> None:
    blocked = tmp_path / "file"
    blocked.write_text("x")
    with pytest.raises(InputError, match="out = ") as caught:
        write_text(blocked / "below" / "result.txt", "text")
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("content", [b"", b"not netcdf", b"\x89HDF\r\n\x1a\n" + b"\x00" * 200])
def test_a_damaged_result_is_named(tmp_path: Path, content: bytes) -> None:
    damaged = tmp_path / "damaged.nc"
    damaged.write_bytes(content)
    with pytest.raises(InputError, match=r"damaged\.nc"):
        read_dataset(damaged)


def test_a_missing_result_is_named(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"nowhere\.nc"):
        read_dataset(tmp_path / "nowhere.nc")
