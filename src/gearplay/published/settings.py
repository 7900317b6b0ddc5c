"""Parameters and durations of the study: variants of the case under each condition.

Each model runs with its own best parameters. What the choice of the model alone changes is told by a third run: the
uncoupled model with the coupled one's parameters ("switched").
"""

from dataclasses import dataclass
from typing import Any

from gearplay.model.case import Case
from gearplay.model.reading import load_case, replace
from gearplay.published.article import Condition

MODELS = ("coupled", "uncoupled")
SWITCHED = "switched"


@dataclass(frozen=True)
class Variant:
    """One run of all conditions: its name, the backlash model, and the bundled case that gives the parameters."""

    name: str
    model: str
    case: str


CALIBRATED, ASSUMED = "calibrated", "assumed"
PARAMETERS: dict[str, tuple[Variant, ...]] = {
    CALIBRATED: (
        Variant("coupled", "coupled", "han2021-calibrated"),
        Variant("uncoupled", "uncoupled", "han2021-calibrated-uncoupled"),
        Variant(SWITCHED, "uncoupled", "han2021-calibrated"),
    ),
    ASSUMED: tuple(Variant(model, model, "han2021") for model in MODELS),
    "geometric-inertia": tuple(Variant(model, model, "han2021-geometric-inertia") for model in MODELS),
}
"""Sets of parameters by name: fitted to the test, assumed with the printed inertias, assumed with those of discs."""
FRESH_SEED = 30_000_001
"""Of the study's initial states: no calibration has seen them."""


@dataclass(frozen=True)
class Settings:
    """How the study is run. Record, transient and sampling are those of the calibration."""

    parameters: str = CALIBRATED
    members: int = 24
    duration: float = 4.0  # s, per member
    transient: float = 8.0  # s
    sampling: float = 1000.0  # Hz, of the recorded mean acceleration
    history: float = 1.0  # s, of the recorded orbit
    seed: int = FRESH_SEED
    drag: float | None = None  # N m s/rad, replaces the case's

    @property
    def variants(self) -> tuple[Variant, ...]:
        """What is run."""
        return PARAMETERS[self.parameters]


def condition_case(base: Case, condition: Condition, model: str) -> Case:
    """Return the base case at one condition with one backlash model."""
    return replace(
        base,
        {
            "title": f"Han 2021, {condition.label}, {model}",
            "backlash_model": model,
            "rotors.pinion.drive.speed": f"{condition.speed_rpm:g} rpm",
            "sleeves.ring.radial_clearance": f"{condition.radial_clearance_um:g} um",
            "meshes.0.backlash": f"{condition.backlash_um:g} um",
        },
    )


def base_case(variant: Variant, settings: Settings) -> Case:
    """Return a variant's base case with the settings' seed and drag."""
    changes: dict[str, Any] = {"run.seed": settings.seed}
    if settings.drag is not None:
        changes["rotors.ring.load.drag"] = settings.drag
    return replace(load_case(variant.case), changes)
