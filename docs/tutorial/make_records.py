"""Make the tutorial's records with the virtual rig: known parameters, one record at each of three speeds."""

from pathlib import Path

from gearplay.files.measurements import write_record
from gearplay.files.record import Record
from gearplay.model.reading import load_case, replace
from gearplay.rig import measure
from gearplay.rig.plan import load_rig

FOLDER = Path(__file__).parents[2] / "src/gearplay/calibration/plans/records"
TRUE = {
    "sleeves.ring.radial_clearance": "85 um",
    "meshes.0.backlash": "150 um",
    "rotors.ring.load.drag": "4e-4 N m s/rad",
    "meshes.0.stiffness.mean": "1e8 N/m",
    "sleeves.ring.restitution": 0.7,
}


def main() -> None:
    rig = load_rig(FOLDER / "tutorial-rig.toml")
    for rpm in (60, 120, 180):
        case = replace(
            load_case("han2021"),
            {
                **TRUE,
                "rotors.pinion.drive.speed": f"{rpm} rpm",
                "run.seed": 700 + rpm,
                "run.transient": "5 s",
            },
        )
        record = measure(case, rig, duration=48.0, seed=rpm)
        kept = tuple(c for c in record.channels if c.name == "shaft.recorded")
        # Only what a test engineer would have: not the case, which is the answer.
        told = {k: v for k, v in record.attributes.items() if not k.startswith("case")}
        write_record(
            Record(kept, source=f"tutorial, {rpm} rpm", attributes=told),
            FOLDER / f"tutorial-{rpm}rpm.h5",
            overwrite=True,
        )


if __name__ == "__main__":
    main()
