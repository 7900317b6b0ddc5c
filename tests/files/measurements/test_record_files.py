"""A library of sound, odd and damaged record files by the writers that people use: right values or one sentence, never silent."""

import struct
import wave
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import h5py
import numpy as np
import pandas as pd
import pytest
import xarray as xr
from scipy.io import savemat, wavfile

from gearplay import read_measurement
from gearplay.vocabulary.errors import GearplayError

pytestmark = pytest.mark.hostile

RATE = 1000.0
COUNT = 400
VALUES = np.round(np.random.default_rng(42).normal(size=COUNT), 6)
OTHER = np.round(np.random.default_rng(43).normal(size=COUNT), 6)
TIME = np.arange(COUNT) / RATE

Write = Callable[[Path], None]


@dataclass(frozen=True)
class Sound:
    """A file and what it holds: channel -> samples, their units and the sampling rate [Hz]."""

    name: str
    write: Write
    channels: dict[str, np.ndarray]
    units: dict[str, str] = field(default_factory=dict)
    rate: float = RATE
    tolerance: float = 1e-9
    given: float | None = None


@dataclass(frozen=True)
class Refused:
    """A file and the words by which it is refused."""

    name: str
    write: Write
    words: str


def text(content: str, encoding: str = "utf-8") -> Write:
    return lambda path: path.write_bytes(content.encode(encoding)) and None


def table(
    head: str,
    *columns: np.ndarray,
    separator: str = ",",
    decimal: str = ".",
    end: str = "\n",
    times: str = "%.6f",
) -> str:
    rows = [
        separator.join((times % row[0], *(f"{value:.6f}" for value in row[1:]))).replace(
            ".", decimal if decimal != "." else "."
        )
        for row in zip(*columns, strict=True)
    ]
    return head + end + end.join(rows) + end


def frame(**options: object) -> Write:
    return lambda path: pd.DataFrame({"time [s]": TIME, "acc [g]": VALUES}).to_csv(path, **options)  # type: ignore[call-overload]


def mat(**variables: object) -> Write:
    return lambda path: savemat(path, variables)


def mat_of(options: dict[str, object], **variables: object) -> Write:
    return lambda path: savemat(path, variables, **options)  # type: ignore[arg-type]


def h5(fill: Callable[[h5py.File], None], **options: object) -> Write:
    def write(path: Path) -> None:
        with h5py.File(path, "w", **options) as file:
            fill(file)

    return write


def put(
    file: h5py.File, values: dict[str, object], attributes: dict[str, dict[str, object]] | None = None
) -> None:
    for name, value in values.items():
        file[name] = value
    for name, about in (attributes or {}).items():
        file[name].attrs.update(about)


def netcdf(times: object, units: str = "", *, axis: str = "time", **about: object) -> Write:
    along = (axis, times, {"units": units} if units else {})
    return lambda path: xr.Dataset(
        {"acc": (axis, VALUES, {"units": "m/s2", **about})}, {axis: along}
    ).to_netcdf(path, engine="h5netcdf")


def packed_netcdf(path: Path) -> None:
    dataset = xr.Dataset({"acc": ("time", np.round(VALUES, 2))}, {"time": TIME})
    dataset.to_netcdf(
        path, engine="h5netcdf", encoding={"acc": {"dtype": "i2", "scale_factor": 0.01, "_FillValue": -32768}}
    )


def matlab_73(path: Path) -> None:
    """As MATLAB writes: a structure, a text and a matrix, whose dimensions h5py shows the other way round."""
    with h5py.File(path, "w", userblock_size=512) as file:
        group = file.create_group("run")
        group.attrs["MATLAB_class"] = np.bytes_("struct")
        for name, values, kind in (
            ("acc", np.stack([VALUES, OTHER]), "double"),
            ("fs", np.array([[RATE]]), "double"),
            ("unit", np.array([[ord(c)] for c in "m/s²"], dtype="u2"), "char"),
        ):
            group[name] = values
            group[name].attrs["MATLAB_class"] = np.bytes_(kind)
        file["nothing"] = np.zeros(2, dtype="u8")
        file["nothing"].attrs.update({"MATLAB_class": np.bytes_("double"), "MATLAB_empty": np.uint8(1)})
    content = path.read_bytes()
    path.write_bytes(b"MATLAB 7.3 MAT-file".ljust(124) + b"\x00\x02IM" + content[128:])


def twice(path: Path) -> None:
    savemat(path, {"acc": VALUES, "fs": RATE})
    once = path.read_bytes()
    savemat(path, {"acc": OTHER, "fs": RATE})
    path.write_bytes(once + path.read_bytes()[128:])


def npz(**arrays: object) -> Write:
    return lambda path: np.savez(path, **arrays)  # type: ignore[arg-type]


def waves(width: int, channels: int = 1) -> Write:
    def write(path: Path) -> None:
        with wave.open(str(path), "wb") as file:
            file.setnchannels(channels)
            file.setsampwidth(width)
            file.setframerate(int(RATE))
            whole = np.round(VALUES / 5 * (2 ** (8 * width - 1) - 1)).astype("<i4")
            frames = np.repeat(whole, channels)
            raw = (frames + 128).astype("u1") if width == 1 else frames
            file.writeframes(raw.view("u1").reshape(frames.size, -1)[:, :width].tobytes())

    return write


def unfinished_wav(path: Path) -> None:
    waves(2)(path)
    content = path.read_bytes()
    path.write_bytes(content[:4] + struct.pack("<I", 0) + content[8:40] + struct.pack("<I", 0) + content[44:])


def tdms(values: np.ndarray, properties: dict[str, object], *, name: str = "acc") -> Write:
    def write(path: Path) -> None:
        from nptdms import ChannelObject, TdmsWriter

        with TdmsWriter(path) as writer:
            writer.write_segment([ChannelObject("rig", name, values, properties)])

    return write


LINEAR = {
    "NI_Number_Of_Scales": 1, "NI_Scaling_Status": "unscaled", "NI_Scale[0]_Scale_Type": "Linear",
    "NI_Scale[0]_Linear_Slope": 0.5, "NI_Scale[0]_Linear_Y_Intercept": 1.0,
    "NI_Scale[0]_Linear_Input_Source": np.uint32(0xFFFFFFFF),
}  # fmt: skip
UNKNOWN = {"NI_Number_Of_Scales": 1, "NI_Scaling_Status": "unscaled", "NI_Scale[0]_Scale_Type": "Reciprocal"}


def tdms_groups(path: Path) -> None:
    from nptdms import ChannelObject, TdmsWriter

    with TdmsWriter(path) as writer:
        for group, values in (("a", VALUES), ("b", OTHER)):
            time = ChannelObject(group, "Time", TIME * 1e3, {"unit_string": "ms"})
            acc = ChannelObject(group, "acc", values, {"unit_string": "m/s²"})
            writer.write_segment([time, acc, ChannelObject(group, "text", ["x", "y"])])


def mdf(
    conversion: dict[str, object] | None = None,
    values: np.ndarray = VALUES,
    times: np.ndarray = TIME,
    **options: object,
) -> Write:
    def write(path: Path) -> None:
        from asammdf import MDF, Signal

        file = MDF(version="4.10")
        file.append([Signal(values, times, name="acc", unit="m/s²", conversion=conversion)])
        file.save(path, overwrite=True, **options)
        file.close()

    return write


def uff(name: str = "acc", unit: str = "m/s^2", *, encoding: str = "utf-8", step: float = 1.0) -> Write:
    def write(path: Path) -> None:
        import pyuff

        shared = dict.fromkeys(("rsp_node", "rsp_dir", "ref_node", "ref_dir"), 1)
        one = {
            "type": 58,
            "func_type": 1,
            "id1": name,
            "data": VALUES,
            "x": TIME * step,
            "binary": 0,
            "abscissa_spacing": 1,
        }
        one |= {
            "ordinate_axis_units_lab": unit,
            "abscissa_spec_data_type": 17,
            "ordinate_spec_data_type": 12,
            "orddenom_spec_data_type": 0,
        }
        pyuff.UFF(str(path)).write_sets(shared | one, mode="overwrite")
        if encoding != "utf-8":
            path.write_bytes(path.read_bytes().decode("utf-8").encode(encoding))

    return write


def cut(write: Write, share: float) -> Write:
    def cut_file(path: Path) -> None:
        write(path)
        content = path.read_bytes()
        path.write_bytes(content[: int(share * len(content))])

    return cut_file


def clock(form: str) -> str:
    stamps = pd.Timestamp("2026-03-01 23:59:59.900") + pd.to_timedelta(TIME, unit="s")
    return "Zeitstempel,acc [g]\n" + "".join(
        f"{s.strftime(form)[:-3]},{v:.6f}\n" for s, v in zip(stamps, VALUES, strict=True)
    )


ACC = {"acc": VALUES}
COUNTS = np.round(1000 * VALUES)
PLAIN = table("t,acc", TIME, VALUES)
SOUND = [
    Sound("pandas.csv", frame(index=False), ACC, {"acc": "g"}),
    Sound("pandas-decimal-comma.csv", frame(index=False, sep=";", decimal=","), ACC, {"acc": "g"}),
    Sound("pandas-bom.csv", frame(index=False, encoding="utf-8-sig"), ACC, {"acc": "g"}),
    Sound("pandas-utf16.csv", frame(index=False, encoding="utf-16"), ACC, {"acc": "g"}),
    Sound("pandas-tabs.txt", frame(index=False, sep="\t", lineterminator="\r\n"), ACC, {"acc": "g"}),
    Sound("numpy.csv", lambda path: np.savetxt(path, np.column_stack([TIME, VALUES]), header="t acc"), {"channel 1": VALUES}),
    Sound("numbered-columns.csv", lambda path: pd.DataFrame(np.column_stack([VALUES, OTHER])).to_csv(path, index=False),
          {"0": VALUES, "1": OTHER}, given=RATE),
    Sound("latin-1.csv", text(table("Zeit [s];Kraft [µm]", TIME, VALUES, separator=";", decimal=","), "latin-1"),
          {"Kraft": VALUES}, {"Kraft": "µm"}),
    Sound("old-mac.csv", text(table("t,acc", TIME, VALUES, end="\r")), ACC),
    Sound("no-line-end.csv", text(PLAIN[:-1]), ACC),
    Sound("milliseconds.csv", text(table("time_ms,acc", 1e3 * TIME, VALUES)), ACC),
    Sound("unit-row.csv", text(table("t,acc\ns,m/s²", TIME, VALUES)), ACC, {"acc": "m/s²"}),
    Sound("header-rate.csv", text("Sample rate: 1 kHz\n" + table("acc,force", VALUES, OTHER)), {"acc": VALUES, "force": OTHER}),
    Sound("header-fields.csv", text("Sampling Rate;1000;Hz\n" + table("acc;force", VALUES, OTHER, separator=";")),
          {"acc": VALUES, "force": OTHER}),
    Sound("header-step.csv", text("# dt = 1 ms\nacc\n" + "\n".join(f"{v:.6f}" for v in VALUES) + "\n"), ACC),
    Sound("iso-times.csv", text(clock("%Y-%m-%dT%H:%M:%S.%f")), ACC, {"acc": "g"}),
    Sound("iso-times-blank.csv", text(clock("%Y-%m-%d %H:%M:%S.%f")), ACC, {"acc": "g"}),
    Sound("fortran.csv", text(PLAIN.replace("\n", "D+00\n").replace("accD+00", "acc")), ACC),
    Sound("plain.mat", mat(acc=VALUES, fs=RATE), ACC),
    Sound("column.mat", mat_of({"oned_as": "column", "do_compression": True}, acc=VALUES, dt=1e-3), ACC),
    Sound("version-4.mat", mat_of({"format": "4"}, acc=VALUES, fs=RATE), ACC),
    Sound("structure.mat", mat(bearing={"sr": RATE, "gs": VALUES, "load": 270.0}), {"bearing.gs": VALUES}),
    Sound("header.mat", mat(File_Header={"SampleFrequency": "1000"}, Channel_1={"data": VALUES, "unit": "g"}),
          {"Channel_1.data": VALUES}, {"Channel_1.data": "g"}),
    Sound("named-structures.mat", mat(ch=np.array([{"name": "a x", "fs": RATE, "y": VALUES},
          {"name": "b", "fs": RATE, "y": OTHER}])), {"a x": VALUES, "b": OTHER}),
    Sound("matrix.mat", mat(acc=np.stack([VALUES, OTHER], 1), fs=RATE), {"acc 1": VALUES, "acc 2": OTHER}),
    Sound("rows.mat", mat(acc=np.stack([VALUES, OTHER]), fs=RATE), {"acc 1": VALUES, "acc 2": OTHER}),
    Sound("labelled-matrix.mat", mat(y=np.stack([VALUES, OTHER], 1), labels=np.array(["a", "b"], dtype=object), Fs=RATE),
          {"a": VALUES, "b": OTHER}),
    Sound("time-in-matrix.mat", mat(run=np.stack([TIME, VALUES], 1)), {"run 2": VALUES}),
    Sound("cells.mat", mat(c=np.array([VALUES, OTHER[:300]], dtype=object), fs=RATE), {"c(1)": VALUES, "c(2)": OTHER[:300]}),
    Sound("integers.mat", mat(acc=COUNTS.astype("i2"), t=TIME), {"acc": COUNTS}),
    Sound("matlab-73.mat", matlab_73, {"run.acc 1": VALUES, "run.acc 2": OTHER}, {"run.acc 1": "m/s²"}),
    Sound("vectors.h5", h5(lambda f: put(f, {"acc": VALUES, "fs": RATE}, {"acc": {"units": "g"}})), ACC, {"acc": "g"}),
    Sound("file-attribute.h5", h5(lambda f: put(f, {"acc": VALUES}, {"/": {"sampling_rate_hz": RATE}})), ACC),
    Sound("text-attribute.h5", h5(lambda f: put(f, {"acc": VALUES}, {"acc": {"rate": 3, "sample_rate": "1.0 kHz"}})), ACC),
    Sound("matrix.h5", h5(lambda f: put(f, {"acc": np.stack([VALUES, OTHER], 1), "dt": 1e-3})),
          {"acc 1": VALUES, "acc 2": OTHER}),
    Sound("groups.h5", h5(lambda f: put(f, {"run/acc": VALUES, "run/time": TIME}), libver="latest"), {"run/acc": VALUES}),
    Sound("half-floats.h5", h5(lambda f: put(f, {"acc": VALUES.astype("f4"), "fs": RATE})), ACC, tolerance=1e-6),
    Sound("big-endian.h5", h5(lambda f: put(f, {"acc": VALUES.astype(">f8"), "fs": np.array([RATE])})), ACC),
    Sound("pandas-hdf.h5", h5(lambda f: put(f, {"df/values": np.stack([VALUES, OTHER], 1), "df/fs": RATE,
          "df/columns": ["a", "b"]})), {"a": VALUES, "b": OTHER}),
    Sound("xarray.nc", netcdf(TIME), ACC, {"acc": "m/s2"}),
    Sound("xarray-ms.nc", netcdf(1e3 * TIME, "ms"), ACC),
    Sound("xarray-dates.nc", netcdf(np.datetime64("2026-01-01", "ns") + (TIME * 1e9).astype("timedelta64[ns]")), ACC),
    Sound("xarray-since.nc", netcdf(TIME, "seconds since 2020-01-01", axis="when"), ACC, {"acc": "m/s2"}),
    Sound("packed.nc", packed_netcdf, {"acc": np.round(VALUES, 2)}),
    Sound("wave-8.wav", waves(1), {"channel 1": VALUES / 5}, tolerance=1e-2),
    Sound("wave-16.wav", waves(2), {"channel 1": VALUES / 5}, tolerance=1e-4),
    Sound("wave-24.wav", waves(3, 2), {"channel 1": VALUES / 5, "channel 2": VALUES / 5}, tolerance=1e-6),
    Sound("scipy-float.wav", lambda path: wavfile.write(path, 1000, VALUES.astype("f4")), {"channel 1": VALUES}, tolerance=1e-6),
    Sound("matrix.npy", lambda path: np.save(path, np.stack([TIME, VALUES, OTHER], 1)),
          {"matrix 2": VALUES, "matrix 3": OTHER}, tolerance=1e-9),
    Sound("named.npz", npz(acc=VALUES, force=np.asfortranarray(OTHER.astype(">f4")), fs=RATE, acc_unit="g"),
          {"acc": VALUES, "force": OTHER}, {"acc": "g"}, tolerance=1e-6),
    Sound("packed.npz", lambda path: np.savez_compressed(path, acc=VALUES, t=TIME), ACC),
    Sound("records.npz", npz(run=np.rec.fromarrays([TIME, VALUES], names="t, acc")), {"run.acc": VALUES}),
    Sound("increment.tdms", tdms(VALUES, {"wf_increment": 1e-3, "unit_string": "g"}), ACC, {"acc": "g"}),
    Sound("linear-scaling.tdms", tdms(COUNTS.astype("i2"), LINEAR | {"wf_increment": 1e-3}), {"acc": 0.5 * COUNTS + 1}),
    Sound("time-channels.tdms", tdms_groups, {"a/acc": VALUES, "b/acc": OTHER}, {"a/acc": "m/s²"}),
    Sound("plain.mf4", mdf(), ACC, {"acc": "m/s²"}),
    Sound("packed.mf4", mdf(compression=2), ACC),
    Sound("linear.mf4", mdf({"a": 0.5, "b": 1.0}, COUNTS.astype("i2")), {"acc": 0.5 * COUNTS + 1}),
    Sound("text.uff", uff(), ACC, {"acc": "m/s^2"}, tolerance=1e-9),
    Sound("utf-8.uff", uff("1x : m/s²", "m/s²"), {"1x : m/s²": VALUES}, {"1x : m/s²": "m/s²"}),
    Sound("latin-1.uff", uff("1x : m/s²", "m/s²", encoding="latin-1"), {"1x : m/s²": VALUES}, {"1x : m/s²": "m/s²"}),
]  # fmt: skip
REFUSED = [
    Refused("decimal-commas.csv", text(table("t,acc", TIME, VALUES, decimal=",")), "decimal commas look like delimiters"),
    Refused("two-rates.csv", text("# fs = 500 Hz\n" + PLAIN), "states two sampling rates for 'acc': 500 Hz .* and 1000 Hz"),
    Refused("cut-row.csv", text(PLAIN[:-4]), "last line has no end"),
    Refused("missing.csv", text(table("t,a,b", TIME, VALUES, OTHER).replace(f"{VALUES[7]:.6f}", "")), "number, nothing found"),
    Refused("utf-16-bare.csv", text(PLAIN, "utf-16-le"), "byte 2 is zero"),
    Refused("counted-rows.csv", text("".join(f"{k},{v:.6f}\n" for k, v in enumerate(VALUES))), "must be given"),
    Refused("epoch-ms.csv", text(table("timestamp,acc", 1.7e12 + 1e3 * TIME, VALUES)), "in seconds or state their unit"),
    Refused("wide-digits.csv", text("t,acc\n0,１２\n1,１３\n"), "rows of numbers"),
    Refused("two-rates.mat", mat(acc=VALUES, fs=RATE, dt=1e-2), "two sampling rates for 'acc': 1000 Hz .fs. and 100 Hz .dt."),
    Refused("two-names.mat", twice, "holds 2 variables named"),
    Refused("rate-per-channel.mat", mat(acc=VALUES, fs=np.array([RATE, 2 * RATE])), "'fs' must be one sampling rate, 2 found"),
    Refused("complex.mat", mat(acc=VALUES + 1j, fs=RATE), r"found: acc \(.*complex128\), fs"),
    Refused("words.mat", mat(note="nothing here"), r"found: note \(text\)"),
    Refused("cut.mat", cut(mat(acc=VALUES, fs=RATE), 0.7), "readable MAT"),
    Refused("large-whole-numbers.mat", mat(n=np.arange(9, dtype="i8") + 2**60, fs=RATE), r"whole numbers up to 2\^53"),
    Refused("contradicted-time.h5", h5(lambda f: put(f, {"acc": VALUES, "fs": RATE, "time": 2 * TIME})), "two sampling rates"),
    Refused("gap.nc", netcdf(np.where(TIME > 0.2, TIME + 0.01, TIME)), "largest jitter"),
    Refused("nan.nc", netcdf(TIME, _FillValue=VALUES[3]), "finite numbers; 1 of 400"),
    Refused("cut.h5", cut(h5(lambda f: put(f, {"acc": VALUES, "fs": RATE})), 0.6), "readable HDF5"),
    Refused("objects.npy", lambda path: np.save(path, np.array([print], dtype=object)), "holds objects of Python"),
    Refused("cut.npy", cut(lambda path: np.save(path, VALUES), 0.9), "declares 3200 bytes of numbers and holds"),
    Refused("two-rates.npz", npz(acc=VALUES, fs=RATE, dt=1e-2), "two sampling rates for 'acc'"),
    Refused("cut.npz", cut(npz(acc=VALUES, fs=RATE), 0.9), "readable NumPy"),
    Refused("unfinished.wav", unfinished_wav, "declares 8 bytes in its RIFF header"),
    Refused("unknown-scaling.tdms", tdms(COUNTS.astype("i2"), UNKNOWN | {"wf_increment": 1e-3}), "scale type: Reciprocal"),
    Refused("cut.tdms", cut(tdms(VALUES, {"wf_increment": 1e-3}), 0.9), "declares to end at byte"),
    Refused("cut.mf4", cut(mdf(), 0.5), "readable MDF 4|declares|crashes"),
    Refused("gap.mf4", mdf(times=np.where(TIME > 0.2, TIME + 0.01, TIME)), "largest jitter"),
    Refused("cut.uff", cut(uff(), 0.9), "marks -1"),
    Refused("still.uff", uff(step=0.0), "positive time increment"),
]  # fmt: skip


@pytest.mark.parametrize("one", SOUND, ids=lambda one: one.name)
def test_a_sound_file_gives_the_values_that_were_written(one: Sound, tmp_path: Path) -> None:
    one.write(tmp_path / one.name)
    record = read_measurement(tmp_path / one.name, sampling=one.given)
    assert record.names == tuple(one.channels)
    for name, values in one.channels.items():
        channel = record.channel(name)
        np.testing.assert_allclose(channel.values, values, rtol=one.tolerance, atol=one.tolerance)
        assert channel.sampling == pytest.approx(one.rate, rel=1e-6)
        assert channel.unit == one.units.get(name, channel.unit)


@pytest.mark.parametrize("one", REFUSED, ids=lambda one: one.name)
def test_a_file_that_contradicts_itself_is_one_sentence(one: Refused, tmp_path: Path) -> None:
    one.write(tmp_path / one.name)
    with pytest.raises(GearplayError, match=one.words) as caught:
        read_measurement(tmp_path / one.name)
    assert str(caught.value).isprintable()


def test_the_rate_of_the_caller_decides_between_two(tmp_path: Path) -> None:
    savemat(tmp_path / "two.mat", {"acc": VALUES, "fs": RATE, "dt": 1e-2})
    assert read_measurement(tmp_path / "two.mat", sampling=100.05).channel().sampling == 100.0
    with pytest.raises(GearplayError, match="must agree with 1000 Hz"):
        read_measurement(tmp_path / "two.mat", sampling=300.0)


def test_units_are_given_where_a_file_has_none(tmp_path: Path) -> None:
    savemat(tmp_path / "bare.mat", {"acc": VALUES, "fs": RATE})
    channel = read_measurement(tmp_path / "bare.mat", units={"acc": "g"}).channel()
    assert channel.unit == "g"
    np.testing.assert_array_equal(channel.values, VALUES)
    with pytest.raises(GearplayError, match='units = "ac": must be a channel that is read'):
        read_measurement(tmp_path / "bare.mat", units={"ac": "g"})


def test_other_data__is_kept_or_named(tmp_path: Path) -> None:
    savemat(
        tmp_path / "run.mat", {"acc": VALUES, "fs": RATE, "rpm": 1797.0, "note": "cold", "z": VALUES + 1j}
    )
    attributes = read_measurement(tmp_path / "run.mat").attributes
    assert (attributes["rpm"], attributes["note"], attributes["left out"]) == ("1797.0", "cold", "z")
