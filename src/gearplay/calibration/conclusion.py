"""Conclusion of a model comparison, per reading of the ordinate and overall."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from gearplay.calibration.model_comparison import OPEN, Duel, Standing, duels


@dataclass(frozen=True)
class ReadingStatement:
    """Conclusion for one reading of the ordinate: the model that beats every other, or that the data cannot decide."""

    reading: str
    models: tuple[str, ...]
    duels: tuple[Duel, ...]

    @property
    def winner(self) -> str:
        """The model that wins all its pairwise comparisons, else `OPEN`; also `OPEN` for a single model."""
        for model in self.models:
            own = [duel for duel in self.duels if model in (duel.first, duel.second)]
            if own and all(duel.winner == model for duel in own):
                return model
        return OPEN

    @property
    def words(self) -> str:
        """The conclusion in one sentence."""
        if len(self.models) < 2:
            return f"{OPEN}: {self.models[0]} is the only model, so there is nothing to compare."
        if self.winner == OPEN:
            return f"{OPEN}: no model beats every other."
        return f"{self.winner} explains the data better than {_others(len(self.models))}."


@dataclass(frozen=True)
class Statement:
    """The conclusions of each reading, and the overall one.

    ``overall`` is a model's name only where it beats every other model in every reading, else `OPEN`.
    """

    readings: tuple[ReadingStatement, ...]
    overall: str
    words: str


def statement_of(standings: Mapping[str, Sequence[Standing]]) -> Statement:
    """Return the conclusion from the standings of the models, by reading.

    >>> from gearplay.calibration.model_comparison import Standing
    >>> good, bad = (Standing(n, 0.0, e, 0.1, {"a": e, "b": e - 1}) for n, e in (("good", 0.0), ("bad", -9.0)))
    >>> statement_of({"absolute": [good, bad]}).overall
    'good'
    >>> statement_of({"absolute": [good, bad], "displacement": [good]}).overall  # nobody beaten there
    'cannot be told'
    """
    readings = tuple(
        ReadingStatement(reading, tuple(s.model for s in found), tuple(duels(found)))
        for reading, found in standings.items()
    )
    winners = {each.winner for each in readings}
    overall = next(iter(winners)) if len(winners) == 1 and _same_models(readings) else OPEN
    return Statement(readings, overall, _words(readings, overall))


def _same_models(readings: Sequence[ReadingStatement]) -> bool:
    return len({frozenset(each.models) for each in readings}) == 1


def _words(readings: Sequence[ReadingStatement], overall: str) -> str:
    if not readings:
        return f"{OPEN}: nothing was calibrated."
    if overall != OPEN:
        where = "" if len(readings) == 1 else f", in every reading ({', '.join(r.reading for r in readings)})"
        return f"{overall} explains the data better than {_others(len(readings[0].models))}{where}."
    if len(readings) == 1:
        return readings[0].words
    if all(len(each.models) < 2 for each in readings):
        return readings[0].words
    each_says = "; ".join(f"{each.reading}: {each.winner}" for each in readings)
    won = {each.winner for each in readings} - {OPEN}
    reason = "the readings disagree" if len(won) > 1 else "not every reading has one model ahead of all"
    if not _same_models(readings):
        reason = "not every model was compared in every reading"
    return f"{OPEN}: {reason} ({each_says})."


def _others(models: int) -> str:
    return "the other model" if models == 2 else "every other model"
