"""Lost motion on the page: the hysteresis curve of a shaft while others are held, its key numbers, and both over a turn."""

import threading
from typing import Any

import numpy as np

from gearplay.hysteresis.cycle import SMALL
from gearplay.model.case import Case
from gearplay.results.output_shaft import input_of, output_of
from gearplay.vocabulary.errors import InputError
from gearplay.vocabulary.progress import Tick
from gearplay.web.frames import pack_frame
from gearplay.web.jobs import Job, heading, limited_case, number_of, whole

MOST_POSITIONS = 100
USUAL_TORQUE = 10.0
"""Rated torque that the page suggests for a shaft without load [N m]."""


def suggested(case: Case) -> dict[str, Any]:
    """Return the initial values of the page's form: shaft, held shaft, rated torque [N m].

    >>> from gearplay.model.reading import load_case
    >>> suggested(load_case("two-stage-reducer"))
    {'at': 'output', 'hold': 'input', 'torque': 50.0}
    """
    at = output_of(case)
    return {"at": at, "hold": input_of(case), "torque": abs(case.rotors[at].load.torque) or USUAL_TORQUE}


def lost_motion(job: Job, report: Tick, stop: threading.Event) -> bytes:
    """Return the hysteresis curve of a case as its frame, with the numbers over a turn of the shaft from 2 positions on."""
    from gearplay.hysteresis.cycle import drawn_branch
    from gearplay.hysteresis.lost_motion import lost_motion as computed

    case = limited_case(job)
    at, hold, torque = str(job.get("at", "")), str(job.get("hold", "")), number_of(job.get("torque"))
    if not torque > 0.0:
        raise InputError.of("torque", job.get("torque"), "must be a number above 0", "Give the rated torque")
    positions = whole(job, "positions", 1, MOST_POSITIONS)

    def progress(_: str, done: int, total: int) -> None:
        report(done, total)
        if stop.is_set():
            raise KeyboardInterrupt

    found = computed(
        case,
        at=at,
        hold=hold,
        torque=torque,
        positions=positions if positions > 1 else None,
        progress=progress,
    )
    ds = found.ds
    centre = ds["angle"].mean("branch")
    ends = [float(centre.interp(torque=sign * SMALL * torque)) for sign in (-1.0, 1.0)]
    turn = {
        "position": ds["position"].values,
        **{name: ds[f"{name}_by_position"].values for name in ("lost_motion", "backlash")},
    } if "position" in ds.dims else {}  # fmt: skip
    return pack_frame(
        {
            **heading("lost_motion", job, case),
            "at": at,
            "hold": hold,
            "torque": torque,
            "rows": found.rows(),
            "message": found.message,
            "branches": {name: np.stack(drawn_branch(ds, name)) for name in ("unloading", "loading")},
            "ends": np.array(ends),
            "small": SMALL * torque,
            "stage_end": ds["stage_end"].values,
            **{
                name: float(ds[name])
                for name in ("lost_motion", "backlash", "torsional_stiffness", "hysteresis_loss")
            },
            "stiffness": ds["stiffness"].values,
            "turn": turn,
        }
    )
