"""Reductions of a sweep plan."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Literal

from pydantic import AfterValidator, Field, Tag, model_validator

from gearplay.results.planet_loads import FACTORS
from gearplay.schema.fields import ByKind, Listed, Measure, Name, Part, Problem, refuse
from gearplay.sweeps.plans.design import Text
from gearplay.vocabulary import quantities as q
from gearplay.vocabulary.quantities import CONTACT_STATISTICS, OUTPUT_STATISTICS

Frequency = Annotated[float, Measure(q.FREQUENCY, "frequency", gt=0.0)]


def _rising(band: tuple[float, float]) -> tuple[float, float]:
    if not band[0] < band[1]:
        refuse([Problem((), "must rise from the lowest to the highest frequency", "Swap the two")])
    return band


Band = Annotated[
    tuple[Frequency, Frequency], Listed(2, 2, "lowest and highest frequency"), AfterValidator(_rising)
]


class _Reduction(Part):
    name: Name


class _OfSignal(_Reduction):
    """One sampled signal. ``ax`` and ``ay`` are increments of velocity over a sampling interval: impacts do not alias."""

    signal: Text
    at: Text  # rotor, sleeve or mesh


class StatisticReduction(_OfSignal):
    """A statistic of the whole record."""

    kind: Literal["statistic"] = "statistic"
    statistic: Literal["rms", "mean", "peak", "peak_to_peak", "kurtosis", "crest_factor"] = "rms"


class LineReduction(_OfSignal):
    """Amplitude and frequency of a line near ``order`` times the first mesh's frequency, or near ``near`` [Hz]."""

    kind: Literal["line"] = "line"
    order: Annotated[int, Field(ge=1, le=64)] | None = None
    near: Frequency | None = None
    search: Annotated[float, Measure(None, "relative half-width of the search", gt=0.0, lt=1.0)] = 0.03

    @model_validator(mode="after")
    def _check(self) -> LineReduction:
        if (self.order is None) == (self.near is None):
            refuse([Problem(("order",), "must be given, or near, but not both", "Say which line is meant")])
        return self


class HumpReduction(_OfSignal):
    """Amplitude and frequency of the highest broad hump within a band."""

    kind: Literal["hump"] = "hump"
    band: Band
    width: Annotated[float, Measure(None, "relative width of the smoothing", gt=0.0, lt=1.0)] = 0.08


class LevelReduction(_OfSignal):
    """The rms value within a band."""

    kind: Literal["level"] = "level"
    band: Band


class SpectrumReduction(_OfSignal):
    """The rms value within each of ``count`` equal parts of a band: a spectrum on one grid for all cases."""

    kind: Literal["spectrum"] = "spectrum"
    band: Band
    count: Annotated[int, Field(ge=2, le=100_000)] = 200


class ContactReduction(_Reduction):
    """A statistic of one contact (``contact`` = ``ring`` or ``pinion-ring:drive``)."""

    kind: Literal["contact"] = "contact"
    contact: Text
    statistic: Literal[tuple(CONTACT_STATISTICS)]  # type: ignore[valid-type]


class OutputReduction(_Reduction):
    """A statistic of the output shaft, of the loaded rotor or of ``at``: ``transmission_error``, ``speed_ripple``."""

    kind: Literal["output"] = "output"
    statistic: Literal[tuple(OUTPUT_STATISTICS)]  # type: ignore[valid-type]
    at: Text | None = None


class JamReduction(_Reduction):
    """Share of time in which both flanks of a mesh are pressed at once."""

    kind: Literal["jam"] = "jam"
    mesh: Text


class LoadSharingReduction(_Reduction):
    """A load-sharing factor of the planets of a set, of their forces on the sun: ``factor``, the mean of the most loaded planet,
    or ``peak``, the largest force over the mean share. ``planetary`` names the set where there are several.
    """

    kind: Literal["load_sharing"] = "load_sharing"
    planetary: Text | None = None
    statistic: Literal[tuple(FACTORS)] = "factor"  # type: ignore[valid-type]


class HistoryReduction(_OfSignal):
    """The raw samples of one signal: only for few cases."""

    kind: Literal["history"] = "history"


Reduction = Annotated[
    Annotated[StatisticReduction, Tag("kind:statistic")]
    | Annotated[LineReduction, Tag("kind:line")]
    | Annotated[HumpReduction, Tag("kind:hump")]
    | Annotated[LevelReduction, Tag("kind:level")]
    | Annotated[SpectrumReduction, Tag("kind:spectrum")]
    | Annotated[ContactReduction, Tag("kind:contact")]
    | Annotated[OutputReduction, Tag("kind:output")]
    | Annotated[JamReduction, Tag("kind:jam")]
    | Annotated[LoadSharingReduction, Tag("kind:load_sharing")]
    | Annotated[HistoryReduction, Tag("kind:history")],
    ByKind(
        "statistic",
        "line",
        "hump",
        "level",
        "spectrum",
        "contact",
        "output",
        "jam",
        "load_sharing",
        "history",
    ),
]


def scalar_names(reductions: Sequence[Reduction]) -> list[str]:
    """Return the names of the variables with one number per case."""
    found: list[str] = []
    for each in reductions:
        if each.kind in ("line", "hump"):
            found += [f"{each.name}_amplitude", f"{each.name}_frequency"]
        elif each.kind not in ("spectrum", "history"):
            found.append(each.name)
    return found
