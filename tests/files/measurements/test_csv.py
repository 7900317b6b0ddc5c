"""Text tables: layouts found, time columns checked, every bad row named."""

from pathlib import Path

import numpy as np
import pytest

from gearplay.files.measurements import read_measurement
from gearplay.files.record import Record
from gearplay.vocabulary.errors import MeasurementError


def table(folder: Path, content: str | bytes, name: str = "run.csv", **options: object) -> Record:
    path = folder / name
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    return read_measurement(path, **options)  # type: ignore[arg-type]


LAYOUTS = {
    "tab": "Time (ms)\tacc [m/s^2]\tforce [N]\n0\t1.5\t-2\n100\t2.5\t30\n200\t3.5\t4\n",
    "tab, decimal comma": "Zeit\tacc\tforce\ns\tm/s^2\tN\n0,0\t1,5\t-2,0\n0,1\t2,5\t3e1\n0,2\t3,5\t4,0\n",
    "blanks": "  t   acc[m/s^2]  force[N]\n  0.0  1.5  -2\n  0.1  2.5  30\n  0.2  3.5  4\n",
    "unit row in brackets": "acc,t,force\n[m/s^2],[s],[N]\n1.5,0,-2\n2.5,0.1,30\n3.5,0.2,4\n",
    "quotes and ends": '"t [s]","acc [m/s^2]","force [N]",\r\n"0","1.5","-2",\r\n"0.1","2.5","30",\r\n"0.2","3.5","4",\r\n',
    "comments and preamble": (
        "Recorder 7\n# rig: one\n\nt,acc [m/s^2],force [N]\n0,1.5,-2\n0.1,2.5,30\n# a mark\n\n0.2,3.5,4\n\n"
    ),
}


@pytest.mark.parametrize("layout", LAYOUTS)
def test_layouts(layout: str, tmp_path: Path) -> None:
    found = table(tmp_path, LAYOUTS[layout])
    assert found.names == ("acc", "force")
    assert [channel.unit for channel in found.channels] == ["m/s^2", "N"]
    assert [channel.sampling for channel in found.channels] == [10.0, 10.0]
    np.testing.assert_array_equal(found.channel("acc").values, [1.5, 2.5, 3.5])
    np.testing.assert_array_equal(found.channel("force").values, [-2, 30, 4])


def test_a_decimal_comma_in_one_column(tmp_path: Path) -> None:
    found = table(tmp_path, "acc [g]\n1,5\n2,5\n", sampling=2.0)
    assert found.channel("acc").values.tolist() == [1.5, 2.5]


def test_comments__declarations_are_read(tmp_path: Path) -> None:
    found = table(tmp_path, "# rig: one\n# sampling = 50 Hz\n# start = 2\nacc\n1\n2\n")
    assert dict(found.attributes) == {"rig": "one"}
    assert (found.channel().sampling, found.channel().start) == (50.0, 2.0)


def test_tables_without_header(tmp_path: Path) -> None:
    assert table(tmp_path, "0,5\n0.5,6\n1.0,7\n").channel("channel 1").sampling == 2.0
    found = table(tmp_path, "0,5\n0.5,6\n1.0,7\n", sampling=100.0)
    assert found.names == ("channel 1", "channel 2")
    assert found.channels[0].sampling == 100.0
    assert table(tmp_path, "3\n1\n2\n", sampling=8.0).channel().values.tolist() == [3, 1, 2]


def test_repeated_and_missing_names__are_made_distinct(tmp_path: Path) -> None:
    assert table(tmp_path, "t,a,,a\n0,1,2,3\n1,1,2,3\n").names == ("a", "channel 2", "a (2)")


def test_a_rounded_time_column_is_even(tmp_path: Path) -> None:
    rows = "".join(f"{k / 12800:.6f},{k}\n" for k in range(2000))
    assert table(tmp_path, "t,x\n" + rows).channel("x").sampling == pytest.approx(12800.0, rel=1e-5)


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ("t,a\n0,1\n1,2\n2.1,3\n", r"largest jitter is 0.05 s, 4.76 % .* at sample 2"),
        ("t,a\n0,1\n0,2\n", "must rise"),
        ("t,a\n0,1\n", "at least 2 samples"),
        ("t\n0\n1\n", "a column in addition to the time"),
        ("t,a\n0,1\nnan,2\n2,3\n", r"'t' must hold finite numbers; 1 of 3 .*sample 2"),
        (
            "t,a\n0,1\n1,inf\n2,nan\n",
            r"'a' must hold finite numbers; 2 of 3 samples are not \(the first at sample 2: inf\)",
        ),
        ("t,a\n0,1\n1,2,3\n2,3\n", "line 3 must have 2 fields, 3 found"),
        ("t,a\n0,1\n1\n2,3\n", "line 3 must have 2 fields, 1 found"),
        ("t,a\n0,1\n1,x\x1b\n2,3\n", r"line 3, field 2 must be a number, 'x\\x1b' found"),
        ("t,a\n0,1\n1,1_0\n2,3\n", "line 3, field 2 must be a number"),
        ("# rows = 3\nt,a\n0,1\n1,2\n2,3", "its last line has no end"),
        ("# rows = 4\nt,a\n0,1\n1,2\n2,3\n", "declares 4 rows and holds 3"),
        ("t,a\nb,c\n", "rows of numbers, none found"),
        (b"t,a\n0,1\n\x00\x00\n", "byte 9 is zero"),
        ("t,a\n0,1\n".encode("utf-16") + b"\x00", "starts as UTF-16"),
        ('t,a\n0,1\n1,"2\n3,4\n', "line 3, field 2 must be a number, '23,4' found"),
        ('t,a\n0,1\n1,"2\n3"\n2,3\n', "open quotation mark after line 2"),
        ("t,a\n0,1\n" + "1" * 200_000 + ",2\n2,3\n", r"must be a table \(field larger"),
        ("t,a\n" + "0,1\n" * 300 + "1" * 200_000 + ",2\n", r"must be a table \(field larger"),
        ("# sampling = -1\na\n1\n", "positive sampling rate"),
    ],
)
def test_damage_is_named(content: str | bytes, words: str, tmp_path: Path) -> None:
    with pytest.raises(MeasurementError, match=words) as caught:
        table(tmp_path, content)
    assert str(caught.value).startswith("run.csv: ")
    assert str(caught.value).isprintable()
