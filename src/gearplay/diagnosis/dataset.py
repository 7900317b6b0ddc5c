"""Dataset of a diagnosis: conclusion, hypotheses with their evidence, simulated causes, lines, indices, spectra."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from gearplay.diagnosis.checks import Checks
from gearplay.diagnosis.doubts import doubts
from gearplay.diagnosis.evidence import Hypothesis
from gearplay.diagnosis.hypotheses import HEALTHY, TOLD, stated
from gearplay.diagnosis.machine import Machine
from gearplay.diagnosis.measures import GearMeasure, Measures
from gearplay.diagnosis.named_lines import NamedLine
from gearplay.diagnosis.result import texts
from gearplay.diagnosis.shaft_speed import FoundSpeed
from gearplay.files.record import Channel
from gearplay.vocabulary.version import VERSION

if TYPE_CHECKING:
    import xarray as xr


def summary(every: Sequence[Hypothesis], found: FoundSpeed) -> str:
    """Return the conclusion as a sentence, with the speed."""
    first, second = every[0], every[1]
    speed = f"first shaft {found.words}"
    causes = stated(every)
    if first.kind == "none":
        return f"{HEALTHY[0].upper()}{HEALTHY[1:]} (confidence {first.confidence:.2f}); {speed}."
    if causes:
        words = "; together with ".join(map(_with_evidence, causes))
        return f"{words[0].upper()}{words[1:]}; {speed}."
    return (
        f"It cannot be told: {first.name} (confidence {first.confidence:.2f}) comes first, "
        f"{second.name} ({second.confidence:.2f}) second; {speed}."
    )


def _with_evidence(h: Hypothesis) -> str:
    words = h.strongest
    return f"{h.name}, confidence {h.confidence:.2f}: {words.words} {words.value:.3g}, counting from {words.threshold:.3g}"


def _indices(machine: Machine, result: Measures) -> dict[str, float]:
    s = result.statistics
    found = {"rms": s.rms, "peak": s.peak, "kurtosis": s.kurtosis, "crest factor": s.crest_factor,
             "share that repeats with no shaft": result.rest_share,
             "kurtosis of the most impulsive band, less that of noise": result.impulsive,
             "kurtosis of the mean mesh period": result.waveform}  # fmt: skip
    for k, gear in result.gears.items():
        found |= {f"{name} of {machine.gears[k].name}": value for name, value in _gear_rows(gear).items()}
    for each, own in zip(machine.sets, result.sets, strict=False):
        found |= {f"lines of {name} of {each.name}": value for name, value in own.rows().items()}
    return found


def _gear_rows(gear: GearMeasure) -> dict[str, float]:
    """Return the indices of a gear by name."""
    own = gear.indicators
    return {
        "rms": own.rms, "kurtosis": own.kurtosis, "crest factor": own.crest_factor, "FM0": own.fm0, "FM4": own.fm4,
        "M6A": own.m6a, "M8A": own.m8a, "NA4": own.na4, "NB4": own.nb4, "energy ratio": own.energy_ratio,
        "sideband index": own.sideband_index, "sideband level factor": own.sideband_level_factor,
        "tooth event": gear.event, "modulation": gear.modulation,
    }  # fmt: skip


def dataset_of(
    source: str,
    channel: Channel,
    machine: Machine,
    result: Measures,
    before: Measures | None,
    every: Sequence[Hypothesis],
    named: Sequence[NamedLine],
    old: dict[tuple[str, str], float],
    shown: dict[str, Any],
    checks: Checks,
) -> xr.Dataset:
    """Return the dataset of a diagnosis."""
    import xarray as xr

    evidence = [(k, each) for k, h in enumerate(every) for each in h.evidence]
    indices, healthy = _indices(machine, result), _indices(machine, before) if before is not None else {}
    unit = channel.unit or "1"

    def column(dim: str, values: Any, words: str, units: str = "1") -> tuple[str, Any, dict[str, str]]:
        return dim, values, {"long_name": words} if units == "" else {"units": units, "long_name": words}

    def words_of(dim: str, values: Sequence[str], words: str) -> tuple[str, Any, dict[str, str]]:
        return column(dim, texts(values), words, "")

    variables: dict[str, Any] = {
        "confidence": column("hypothesis", np.array([h.confidence for h in every]), "confidence"),
        "strength": column("hypothesis", np.array([h.strength for h in every]), "decades of the evidence above its threshold"),
        "evidence_of": column("evidence", np.array([k for k, _ in evidence], dtype=np.int64), "place of the hypothesis"),
        "evidence_words": words_of("evidence", [e.words for _, e in evidence], "kind of evidence"),
        "evidence_value": column("evidence", np.array([e.value for _, e in evidence]), "value of the evidence"),
        "evidence_threshold": column("evidence", np.array([e.threshold for _, e in evidence]), "value from which it counts"),
        "line_name": words_of("line", [line.name for line in named], "name of the line"),
        "line_domain": words_of("line", [line.domain for line in named], "spectrum or envelope spectrum"),
        "line_expected": column("line", np.array([line.expected for line in named]), "expected frequency", "Hz"),
        "line_frequency": column("line", np.array([line.frequency for line in named]), "frequency found", "Hz"),
        "line_amplitude": column("line", np.array([line.amplitude for line in named]), "amplitude", unit),
        "line_prominence": column("line", np.array([line.prominence for line in named]), "height over the median around"),
        "line_healthy": column("line", np.array([old.get((n.domain, n.name), math.nan) if n.name != "unnamed" else math.nan
                                                 for n in named]), "amplitude in the healthy record", unit),
        "index_name": words_of("index", list(indices), "name of the index"),
        "index_value": column("index", np.array(list(indices.values())), "index"),
        "index_healthy": column("index", np.array([healthy.get(name, math.nan) for name in indices]),
                                "index of the healthy record"),
        "shaft_speed": ((), result.speed.frequency, {"units": "Hz", "long_name": "turns of the first shaft per second"}),
        "shaft_speed_uncertainty": ((), result.speed.uncertainty, {"units": "Hz", "long_name": f"its {result.speed.kind}"}),
        "spectrum": column("frequency", shown["spectrum"], "amplitude spectrum", unit),
        "envelope": column("envelope_frequency", shown["envelope"], "amplitude spectrum of the envelope", unit),
    }  # fmt: skip
    coordinates = {
        "hypothesis": ("hypothesis", texts([h.name for h in every]), {"long_name": "hypothesis"}),
        "frequency": ("frequency", shown["frequency"], {"units": "Hz", "long_name": "frequency"}),
        "envelope_frequency": (
            "envelope_frequency",
            shown["envelope_frequency"],
            {"units": "Hz", "long_name": "frequency"},
        ),
    }
    conclusion = " ".join(filter(None, (summary(every, result.speed), checks.conclusion)))
    attributes = {
        "title": source, "channel": channel.name, "gearplay_version": VERSION, "Conventions": "CF-1.11",
        "summary": conclusion, "told": int(bool(stated(every))), "causes": json.dumps([h.name for h in stated(every)]),
        "stated_confidence": TOLD,
        "cannot_be_told": json.dumps(doubts(machine, result, every, before, checks)),
        "speed_source": result.speed.source, "speed": result.speed.words,
        "envelope_low": float(shown["low"]), "envelope_high": float(shown["high"]),
    }  # fmt: skip
    if checks.record is not None:
        variables |= _check_variables(checks, column, words_of)
        coordinates["check"] = (
            "check",
            texts([row.name for row in checks.rows]),
            {"long_name": "simulated cause"},
        )
        coordinates["feature"] = ("feature", texts(checks.features), {"long_name": "feature"})
    return xr.Dataset(variables, coords=coordinates, attrs=attributes)


def _check_variables(checks: Checks, column: Any, words_of: Any) -> dict[str, Any]:
    """Return the variables of the simulated causes."""
    results = [row.result for row in checks.rows]
    return {
        "check_deviation": column("check", np.array([r.deviation for r in results]),
                                  "root mean square deviation of the features over spread and allowed error"),
        "check_spread": column("check", np.array([r.spread for r in results]), "standard error of the deviation"),
        "check_alike": column("check", np.array([int(r.alike) for r in results]), "1 where no cause agrees better"),
        "check_level": words_of("check", [row.level for row in checks.rows], "severity of best agreement"),
        "check_hypothesis": words_of("check", ["; ".join(row.hypotheses) for row in checks.rows],
                                     "hypotheses that it stands for"),
        "feature_record": column("feature", checks.record, "decimal logarithm of the feature of the record"),
        "feature_spread": column("feature", checks.spread, "its standard deviation over simulated records"),
        "feature_simulated": (("check", "feature"), np.array([r.expected for r in results]),
                              {"units": "1", "long_name": "decimal logarithm of the feature at best agreement"}),
    }  # fmt: skip
