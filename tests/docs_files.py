"""Files that README and docs take for granted: small ones of the kinds that a reader would have."""

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np

import gearplay as gp
from gearplay.model.reading import to_toml
from machine_records import bearing_record, machine_record

ROOT = Path(__file__).resolve().parents[1]


def make_record(path: Path, duration: int = 2) -> None:
    """Write a channel with the two lines that examples look for, of two seconds."""
    t = np.arange(duration * 12800) / 12800.0
    noise = np.random.default_rng(0).normal(size=t.size)
    acc = np.sin(2 * np.pi * 40.0 * t) + 0.2 * np.sin(2 * np.pi * 80.0 * t) + 0.1 * noise
    from nptdms import ChannelObject, TdmsWriter

    properties = {"wf_increment": 1.0 / 12800.0, "wf_start_offset": 0.0}
    with TdmsWriter(path) as writer:
        writer.write_segment(
            [
                ChannelObject("run", "acc", acc, properties | {"unit_string": "m/s^2"}),
                ChannelObject("run", "force", 0.1 * acc, properties | {"unit_string": "N"}),
            ]
        )


def make_long_record(path: Path) -> None:
    """Write four seconds, so that an order map of a slow shaft has several stretches."""
    make_record(path, 4)


def make_bare(path: Path) -> None:
    path.write_text(
        "acc\n" + "\n".join(f"{np.sin(0.1 * k):.6f}" for k in range(2000)) + "\n", encoding="utf-8"
    )


def make_bare_mat(path: Path) -> None:
    from scipy.io import savemat

    savemat(path, {"X1_DE_time": np.sin(0.1 * np.arange(2000.0)), "fs": 12000.0, "X1RPM": 1797.0})


def make_tacho(path: Path) -> None:
    """Write an acceleration beside a tacho with 8 pulses a revolution of a shaft at 20 Hz."""
    t = np.arange(16000) / 8000.0
    acc, tacho = np.sin(2 * np.pi * 60.0 * t), (np.sin(2 * np.pi * 160.0 * t + 0.3) > 0.0) * 5.0
    rows = "".join(f"{a:.6f},{b:.6f},{c:.1f}\n" for a, b, c in zip(t, acc, tacho, strict=True))
    path.write_text(f"time [s],acc [m/s^2],tacho [V]\n{rows}", encoding="utf-8")


def make_sound(path: Path) -> None:
    values = 0.5 * np.sin(0.1 * np.arange(8000.0))
    gp.write_record(gp.Record((gp.Channel("channel 1", values, 8000.0, "Pa"),)), path)


def make_case(path: Path) -> None:
    path.write_text(
        to_toml(gp.torsional_pair(0.8, mean_force=0.1, force=0.2, damping_ratio=0.1)), encoding="utf-8"
    )


def make_rig(path: Path) -> None:
    text = (ROOT / "docs" / "rig.md").read_text(encoding="utf-8")
    path.write_text(re.findall(r"```toml\n(.*?)```", text, re.DOTALL)[0], encoding="utf-8")


def make_gear(path: Path, seed: int = 100) -> None:
    """Write a second of a gear of 20 teeth at 20 turns a second, with its own noise over the turn."""
    rng = np.random.default_rng(seed)
    turn = np.arange(8000.0) / 8000.0 * 20.0 % 1.0
    own = np.interp(turn, np.arange(200) / 200.0, rng.normal(size=200), period=1.0)
    acc = np.sin(2.0 * np.pi * 20.0 * turn) + 0.05 * own
    gp.write_record(gp.Record((gp.Channel("acc", acc, 8000.0, "m/s^2"),)), path)


def make_gears(path: Path) -> None:
    path.mkdir()
    for seed in range(49):
        make_gear(path / f"{seed}.h5", seed)


def make_housing_rig(path: Path) -> None:
    text = (ROOT / "docs" / "rig.md").read_text(encoding="utf-8")
    path.write_text(re.findall(r"```toml\n(.*?)```", text, re.DOTALL)[1], encoding="utf-8")


def make_my_rig(path: Path) -> None:
    text = (ROOT / "docs" / "how-to" / "measure.md").read_text(encoding="utf-8")
    path.write_text(re.findall(r"```toml\n(.*?)```", text, re.DOTALL)[0], encoding="utf-8")


def make_drawn_gears(path: Path) -> None:
    """Write the wind stage, or the pair with pairs of teeth, of the page on gears as drawn."""
    text = (ROOT / "docs" / "teeth.md").read_text(encoding="utf-8")
    wind, pairs, *_ = re.findall(r"```toml\n(.*?)```", text, re.DOTALL)
    path.write_text(pairs if path.stem == "pairs" else wind, encoding="utf-8")


def make_backlash_map(path: Path) -> None:
    text = (ROOT / "docs" / "how-to" / "gearbox-program.md").read_text(encoding="utf-8")
    path.write_text(re.findall(r"```toml\n(.*?)```", text, re.DOTALL)[0], encoding="utf-8")


def make_drawn(path: Path) -> None:
    """Write the case or the plan of the page on drawings."""
    text = (ROOT / "docs" / "how-to" / "drawing.md").read_text(encoding="utf-8")
    case, plan = re.findall(r"```toml\n(.*?)```", text, re.DOTALL)
    path.write_text(plan if "map" in path.stem else case, encoding="utf-8")


def make_motor(path: Path) -> None:
    """Write a motor's bearing with a damaged inner ring, as public records are."""
    from scipy.io import savemat

    channel = bearing_record()
    savemat(path, {channel.name: channel.values, "fs": channel.sampling})


def make_gearbox(path: Path) -> None:
    gp.write_record(gp.Record((machine_record("tooth 2", 5)[0],)), path)


def make_new_gearbox(path: Path) -> None:
    gp.write_record(gp.Record((machine_record("healthy", 6)[0],)), path)


FILES: dict[str, Callable[[Path], None]] = {
    "backlash-map.toml": make_backlash_map,
    "drawn.toml": make_drawn,
    "drawn-map.toml": make_drawn,
    "run 7.tdms": make_record,
    "run.tdms": make_long_record,
    "bare.csv": make_bare,
    "bare.mat": make_bare_mat,
    "tacho.csv": make_tacho,
    "loud.wav": make_sound,
    "my-case.toml": make_case,
    "rig.toml": make_rig,
    "my-rig.toml": make_my_rig,
    "housing.toml": make_housing_rig,
    "pairs.toml": make_drawn_gears,
    "wind-stage.toml": make_drawn_gears,
    "motor.mat": make_motor,
    "now.h5": make_gear,
    "sound-records": make_gears,
    "gearbox.h5": make_gearbox,
    "gearbox-new.h5": make_new_gearbox,
}
