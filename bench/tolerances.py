"""What a tolerance gives: error after 0.1 s, bias of an ensemble's statistics, cost; `python -m bench.tolerances`.

The default tolerance is chosen from this table (docs/performance). Errors are against a run at 1e-13; statistics against an
ensemble of other members at 1e-11, in standard errors of the difference.
"""

import sys

import numpy as np

import gearplay as gp
from bench.loaded import LEAD, PROBLEMS, Loaded
from gearplay.solver.simulate import run_members

TOLERANCES = (1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9)
MEMBERS, SPAN = 48, 1.0
PRESSED_BY_DRAG = {
    "gravity": [-3.592e-4, 8.979e-3],
    "rotors.pinion.drive.speed": "60 rpm",
    "rotors.pinion.drive.ripple": [{"order": 1, "amplitude": 3.802e-5}],
    "rotors.pinion.runout.amplitude": "4.827 um",
    "rotors.ring.runout.amplitude": "0.2658 um",
    "rotors.ring.load.drag": 4.441e-4,
    "rotors.ring.radial_damping": 0.1172,
    "sleeves.ring.restitution": 0.3011,
    "meshes.0.transmission_error": [
        {"order": 1, "amplitude": "0.03979 um", "phase": "340.1 deg"},
        {"order": 2, "amplitude": "0.01045 um", "phase": "203.8 deg"},
    ],
}
ALL = {
    "han2021": lambda: gp.load_case("han2021"),
    "pressed by drag": lambda: gp.replace(gp.load_case("han2021"), PRESSED_BY_DRAG),
} | PROBLEMS


def statistics(case, tolerance, members):
    """Return statistics of members, shape [statistic, member]."""
    runs = run_members(
        gp.replace(case, {"run.tolerance": tolerance}), members, duration=SPAN, transient=LEAD, sampling=1e4
    )
    names = ("share_of_time", "impacts_per_second", "rms_impact_speed", "peak_force")
    found = [np.concatenate([getattr(run.statistics, name) for name in names]) for run in runs]
    found = [
        np.concatenate(
            [
                each,
                run.values[:, [at for at, c in enumerate(run.columns) if c.signal in ("vx", "vy")]].std(
                    axis=0
                ),
            ]
        )
        for each, run in zip(found, runs, strict=True)
    ]
    return np.array(found).T


def bias(case, tolerance, reference):
    """Return the largest difference of a statistic from the reference: of those that vary, in standard errors; its share."""
    found = statistics(case, tolerance, range(1, MEMBERS + 1))
    spread = np.sqrt((found.var(axis=1, ddof=1) + reference.var(axis=1, ddof=1)) / MEMBERS)
    difference = np.abs(found.mean(axis=1) - reference.mean(axis=1))
    size = np.maximum(np.abs(reference.mean(axis=1)), 1e-300)
    varies = spread > 1e-6 * size
    largest = float(np.max(difference[varies] / spread[varies])) if varies.any() else 0.0
    return largest, int(varies.sum()), float(np.max(difference[~varies] / size[~varies], initial=0.0))


def main():
    """Print the table, for the problems named or all."""
    print(
        "| problem | tolerance | steps/s | error after 2 ms | after 0.1 s | largest difference of statistics |"
    )
    print("|---|---|---:|---:|---:|---|")
    for name, make in ALL.items():
        if len(sys.argv) > 1 and name not in sys.argv[1:]:
            continue
        case = make()
        parts = [Loaded(name, case, span, (0,), begin=LEAD) for span in (2e-3, 0.1)]
        many = name != "planetary"
        reference = statistics(case, 1e-11, range(MEMBERS + 1, 2 * MEMBERS + 1)) if many else None
        for tolerance in TOLERANCES:
            errors = []
            for part in parts:
                found, _, steps = part.timed(tolerance)
                errors.append(part.error(0, found))
            words = ""
            if many:
                t, count, rest = bias(case, tolerance, reference)
                words = f"{t:.1f} standard errors of {count}; {rest:.1g} of those without spread"
            print(
                f"| {name} | {tolerance:.0e} | {steps:.0f} | {errors[0]:.1e} m | {errors[1]:.1e} m | {words} |",
                flush=True,
            )


if __name__ == "__main__":
    main()
