"""Write the calibrated cases and their provenance from a finished calibration: python docs/write_calibrated.py FOLDER.

FOLDER is what `gearplay calibrate han2021 --out FOLDER` wrote.
"""

import json
import math
import sys
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np

from gearplay.calibration.model_comparison import PairComparison
from gearplay.calibration.reading import load_plan
from gearplay.calibration.result import Calibration
from gearplay.calibration.store import digest_of

SOURCE = Path(__file__).parents[1] / "src" / "gearplay"
CASES = {"coupled": "han2021-calibrated", "uncoupled": "han2021-calibrated-uncoupled"}
TEXT = """\
# The rig of Han, Liang, Zhang, Zhao, Entropy 2021, 23, 834, with the parameters that fit its test best: {model} backlash.
# Found by `gearplay calibrate han2021`: {trials} trials, seed {seed}, plan digest {digest}; errors of the 18 amplitudes with
# one common factor: {fresh:.0f} % on fresh members, {left_out:.0f} % under conditions left out.
# "fitted" marks what was free; most of it is not identified (docs/validation). The rest is as in han2021. The floor stands for
# whatever keeps the swing f_r up: nothing in the article's equations does.

title = "Han 2021, calibrated{of}, 120 rpm, 100/100 um"
formulation = "geometric"
backlash_model = "{model}"
gravity = ["{tilt_along:.4g} m/s^2", "{tilt_across:.4g} m/s^2"]    # fitted: a rig that is not quite level
accepted = ["rotors.pinion.inertia", "rotors.ring.inertia"]    # as the article gives them

[rotors.pinion]
teeth = 20
mass = "0.235 kg"
inertia = "0.0189 kg m^2"
drive = {{ kind = "speed", speed = "120 rpm", ripple = [ {{ order = 1, amplitude = {ripple:.4g} }} ] }}    # ripple: fitted
runout = {{ amplitude = "{pinion_runout_um:.4g} um" }}        # fitted

[rotors.ring]
teeth = 60
internal = true
mass = "0.8 kg"
inertia = "0.0612 kg m^2"
load = {{ drag = "{drag:.4g} N m s/rad" }}               # fitted
runout = {{ amplitude = "{ring_runout_um:.4g} um" }}          # fitted
radial_damping = "{radial_damping:.4g} N s/m"            # fitted

[sleeves.ring]
radial_clearance = "100 um"
law = "lankarani-nikravesh"
shaft_radius = "10 mm"
material = {{ modulus = "207 GPa", poisson = 0.3 }}
restitution = {restitution:.4g}                          # fitted
minimum_impact_speed = "1e-4 m/s"

[[meshes]]
driver = "pinion"
driven = "ring"
module = "4 mm"
pressure_angle = "20 deg"
backlash = "100 um"
stiffness = {{ kind = "harmonic", mean = "1.3e8 N/m", amplitude = "6.5e6 N/m", phase = "0 deg" }}
damping = {{ maximum = "3003.12 N s/m", depth = "1 um" }}
transmission_error = [                           # fitted
    {{ order = 1, amplitude = "{tooth_error_um:.4g} um", phase = "{tooth_phase_deg:.4g} deg" }},
    {{ order = 2, amplitude = "{tooth_error_2_um:.4g} um", phase = "{tooth_phase_2_deg:.4g} deg" }},
]

[base.acceleration]                              # its density is fitted
kind = "spectral-density"
density = [ ["0.5 Hz", {floor:.4g}], ["8 Hz", {floor:.4g}] ]    # m^2/s^4/Hz
direction = "45 deg"
per_member = true

[run]
duration = "2 s"
transient = "{transient:g} s"
sampling = "100 kHz"
tolerance = {tolerance}
"""


KEPT = (
    "name",
    "unit",
    "shown_unit",
    "shown_factor",
    "scale",
    "searched",
    "best",
    "low",
    "high",
    "identified",
)
DUEL = (*(field.name for field in fields(PairComparison)), "winner")
READING = "unnormalised"


def shown(best: dict[str, float]) -> dict[str, float]:
    """Return the best values in the units of the text."""
    micro = ("pinion_runout", "ring_runout", "tooth_error", "tooth_error_2")
    degrees = ("tooth_phase", "tooth_phase_2")
    return (
        best
        | {f"{name}_um": 1e6 * best[name] for name in micro}
        | {f"{name}_deg": math.degrees(best[name]) for name in degrees}
    )


def fit_part(fit: dict[str, Any]) -> dict[str, Any]:
    """Return what is kept of one fit."""
    return {
        "trials": fit["trials"],
        "failed": fit["failed"],
        "factor": fit["factor"],
        "in_sample": fit["found_errors"],
        "fresh": [fit["amplitude_error"], fit["frequency_error"]],
        "held_out": [fit["left_out_amplitude_error"], fit["left_out_frequency_error"]],
        "left_out": {
            each["condition"]: {
                label.removeprefix(f"{each['condition']}, "): residual
                for label, residual in zip(each["labels"], each["residuals"], strict=True)
            }
            for each in fit["left_out"]
        },
        "parameters": [{k: p[k] for k in KEPT} for p in fit["parameters"]],
    }


def main(folder: Path) -> None:
    """Write both cases and the provenance."""
    document = Calibration.from_document(folder / "calibration.json").document
    plan = load_plan("han2021")
    digest, seed = digest_of(plan)[:16], plan.effort.seed
    fits = {fit["model"]: fit for fit in document["fits"] if fit["reading"] == READING}
    winner = document["statement"]["overall"]
    provenance = {
        "plan": "han2021",
        "digest": digest,
        "seed": seed,
        "readings": list(plan.readings),
        "check_members": plan.effort.check_members,
        "statement": document["statement"]["words"][0],
        "winner": winner if winner in fits else None,
        "duels": [{k: d[k] for k in DUEL} for d in document["duels"] if d["reading"] == READING],
        "versions": document["versions"],
        "fits": {name: fit_part(fit) for name, fit in fits.items()},
    }
    text = json.dumps(provenance, indent=1, allow_nan=False) + "\n"
    (SOURCE / "studies" / "han2021" / "calibration.json").write_text(text, encoding="utf-8")
    for model, name in CASES.items():
        fit = fits[model]
        numbers = {
            "trials": fit["trials"],
            "seed": seed,
            "digest": digest,
            "model": model,
            "of": "" if model == "coupled" else f" {model}",
            "transient": plan.simulation.transient,
            "tolerance": np.format_float_scientific(plan.set["run.tolerance"], trim="-", exp_digits=1),
        }
        errors = {"fresh": fit["amplitude_error"], "left_out": fit["left_out_amplitude_error"]}
        filled = TEXT.format(**numbers, **errors, **shown(fit["best"]))
        (SOURCE / "model" / "cases" / f"{name}.toml").write_text(filled, encoding="utf-8")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
