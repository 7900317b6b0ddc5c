"""Case of a point of a sweep, and the key of its stored result."""

import hashlib
import json
from typing import Any

from gearplay.model.case import Case
from gearplay.model.item_names import numbered
from gearplay.model.plan_values import changed, value_at
from gearplay.model.policy import LIMITS
from gearplay.model.reading import load_case, replace
from gearplay.sweeps.cases.chains import Chain
from gearplay.sweeps.cases.points import Points, points_of
from gearplay.sweeps.plans.plan import SweepPlan
from gearplay.vocabulary.errors import Fault, InputError
from gearplay.vocabulary.version import VERSION

MARK = "\x00"


class Template:
    """A plan's base case and points.

    The address of a point is a digest of the resolved case, the member, what is kept and the version of gearplay. A case's
    JSON differs from the base's only in the varied fields, so its digest is made from pieces: 5 us against 150.

    Raises `InputError` for a case, path or value that does not fit.
    """

    def __init__(self, plan: SweepPlan) -> None:
        self.plan = plan
        self.base: Case = changed(load_case(plan.case), plan.set, "set")
        self.points: Points = points_of(plan, self.base)
        drawn = plan.design.parameters if plan.design else ()
        self.fields: list[tuple[str, str, float | None]] = [  # path, name, base value of what scales
            (path, each.name, _number_at(self.base, path) if each.mode == "scale" else None)
            for each in (*plan.axes, *drawn)
            for path in (each.path, *each.also)
        ]
        kept = json.dumps(plan.model_dump(mode="json", include={"reduce"}), sort_keys=True)
        self.kept = hashlib.sha256(f"{VERSION}\n{kept}".encode()).hexdigest()
        self.chain: Chain | None = None
        if plan.carry is not None:
            axis = plan.axes[self.points.carried]
            self.chain = Chain(plan.carry, axis.path, self.points.values[self.points.carried], self.base)
        self.pieces: list[str] = []
        self.limited = any(path in (f"run.{name}" for name in LIMITS) for path, _, _ in self.fields)
        if self.chain is None and not self.limited:
            self._cut()

    def changes(self, values: dict[str, Any]) -> dict[str, Any]:
        """Return the changes of the base case, by path, at varied values by name."""
        found = {
            path: values[name] if base is None else base * values[name] for path, name, base in self.fields
        }
        if self.chain is not None and self.plan.carry is not None:
            found |= self.chain.changes(values[self.plan.carry.axis], values["direction"])
        return found

    def case_at(self, index: int) -> tuple[Case, int]:
        """Return the case and the member of a point; `InputError` where the case does not take its values."""
        values, member = self.points.at(index)
        return replace(self.base, self.changes(values)), member

    def _cut(self) -> None:
        """Cut the base's JSON at the varied fields, where that gives every case's own JSON."""
        document = self.base.identity()
        for at, (path, _, _) in enumerate(self.fields):
            place: Any = document
            *way, last = numbered(document, path).split(".")
            for part in way:
                if isinstance(place, dict) and place.get(part) is None:
                    return  # a table that the base does not have
                place = place[int(part)] if isinstance(place, list) else place[part]
            if isinstance(place, dict) and last not in place:
                return  # a field that the base does not write out, or the file of a table
            place[int(last) if isinstance(place, list) else last] = f"{MARK}{at}{MARK}"
        text = _json(document)
        mark = json.dumps(MARK)[1:-1]
        parts = text.split(f'"{mark}')
        self.pieces, self.turn = [parts[0]], []
        for part in parts[1:]:
            number, rest = part.split(f'{mark}"', 1)
            self.turn.append(int(number))
            self.pieces.append(rest)
        count = len(self.points)
        for index in {0, count // 3, count - 1}:
            try:
                if self._text(index) != _json(self.case_at(index)[0].identity()):
                    self.pieces = []
                    return
            except InputError:  # a point that the case does not take has no JSON to compare with
                continue

    def _text(self, index: int) -> str:
        changes = list(self.changes(self.points.at(index)[0]).values())
        words = [self.pieces[0]]
        for at, rest in zip(self.turn, self.pieces[1:], strict=True):
            words += [json.dumps(changes[at]), rest]
        return "".join(words)

    def digest_of(self, index: int) -> str:
        """Return the SHA-256 of a point's resolved case (`Case.sha256`)."""
        if not self.pieces:
            return self.case_at(index)[0].sha256
        return hashlib.sha256(self._text(index).encode("ascii")).hexdigest()

    def _limits(self, index: int) -> str:
        """Return the limits of a point, no part of its case's digest, that may have ended it: empty where it has none."""
        try:
            case = self.case_at(index)[0] if self.limited else self.base
        except InputError:
            return ""
        limits = {name: getattr(case.run, name) for name in LIMITS}
        return f" {limits}" if any(value is not None for value in limits.values()) else ""

    def address_of(self, index: int) -> bytes:
        """Return the address of a point's result, 32 bytes; one that the case refuses goes by its values."""
        values, member = self.points.at(index)
        try:
            digest = self.digest_of(index)
        except InputError:
            digest = f"{self.base.sha256} {values}"
        words = f"{digest} {member} {self.kept}{self._limits(index)}"
        if self.chain is not None and self.plan.carry is not None:
            words += f" {self.chain.story(values[self.plan.carry.axis], values['direction'])}"
        return hashlib.sha256(words.encode()).digest()


def _number_at(case: Case, path: str) -> float:
    """Return the number that factors multiply; `InputError` where there is none."""
    value = value_at(case, path)
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        rule = "must be a number in the case, to be multiplied"
        raise InputError(Fault(path, value, rule, 'Take mode = "set", or correct the path'))
    return float(value)


def _json(document: Any) -> str:
    """Return the text whose digest is `Case.sha256`."""
    return json.dumps(document, separators=(",", ":"), allow_nan=False, ensure_ascii=True)
