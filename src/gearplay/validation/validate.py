"""`validate`: every published number that gearplay reproduces, with the computed one."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from gearplay.results.base import OfDataset
from gearplay.vocabulary.progress import Progress
from gearplay.vocabulary.version import VERSION

if TYPE_CHECKING:
    import xarray as xr


class Validation(OfDataset):
    """Published numbers with the computed ones.

    ``ds`` has over ``number``: ``published``, ``computed``, ``deviation`` and ``tolerance`` in ``unit``; ``topic``, ``title``,
    ``name``, ``source``; ``within``, 1 where the deviation is within its tolerance. ``str`` of it is the table.
    """

    result_kind: ClassVar[str] = "validation"

    @property
    def passed(self) -> bool:
        """Whether every deviation is within its tolerance."""
        return bool(np.all(self.ds["within"].values))

    @property
    def message(self) -> str:
        """Count of the numbers that agree, and the names of the others."""
        within = self.ds["within"].values.astype(bool)
        sources = len(set(self.ds["source"].values.tolist()))
        words = f"{int(within.sum())} of {within.size} numbers, of {sources} sources, within their tolerances"
        beyond = [
            f"{title}: {name}" for (title, name), fits in zip(self._names(), within, strict=True) if not fits
        ]
        return words + (f". Beyond: {'; '.join(beyond)}." if beyond else ".")

    def _names(self) -> list[tuple[str, str]]:
        return list(zip(self.ds["title"].values.tolist(), self.ds["name"].values.tolist(), strict=True))

    def numbers(self) -> list[dict[str, Any]]:
        """Return one mapping for each number, JSON-able: its variables by name."""
        names = (
            "topic", "title", "name", "published", "computed", "deviation", "tolerance", "unit", "within", "source",
        )  # fmt: skip
        columns = [self.ds[name].values.tolist() for name in names]
        rows = [dict(zip(names, values, strict=True)) for values in zip(*columns, strict=True)]
        return [row | {"within": bool(row["within"])} for row in rows]

    def rows(self) -> Sequence[tuple[str, str]]:
        """Return a row for each number: its name, and published and computed value as text."""
        return [
            (
                f"{row['title']}: {row['name']}",
                f"{_shown(row['published'])}, ours {row['computed']:.8g} {row['unit']}",
            )
            for row in self.numbers()
        ]

    def __str__(self) -> str:
        """Return the table as text, then the message."""
        lines, head = [], ("", "published", "computed", "deviation", "tolerance", "")
        found = self.numbers()
        cells = [_cells(row) for row in found]
        widths = [max(len(row[k]) for row in [head, *cells]) for k in range(len(head))]
        last = ""
        for row, texts in zip(found, cells, strict=True):
            part = f"{row['topic']}: {row['title']} ({row['source']})"
            if part != last:
                lines += ["", part, _line(head, widths)]
                last = part
            lines.append(_line(texts, widths) + ("" if row["within"] else "  BEYOND ITS TOLERANCE"))
        return "\n".join([*lines, "", self.message]).lstrip()

    def plot(self) -> Any:
        """Return a figure: each deviation over its tolerance."""
        from gearplay.validation.figures import draw_deviations

        return draw_deviations(self)


def _shown(value: float) -> str:
    return f"{value:.10g}"


def _cells(row: dict[str, Any]) -> tuple[str, ...]:
    numbers = (f"{row['computed']:.10g}", f"{row['deviation']:+.1e}", f"{row['tolerance']:.1e}")
    return f"  {row['name']}", _shown(row["published"]), *numbers, row["unit"]


def _line(texts: Sequence[str], widths: Sequence[int]) -> str:
    first, *middle, last = texts
    cells = [first.ljust(widths[0])]
    cells += [text.rjust(width) for text, width in zip(middle, widths[1:], strict=False)]
    return "  ".join([*cells, last]).rstrip()


def validate(*, progress: Progress | None = None) -> Validation:
    """Compute every published number that the product reproduces, by its public functions.

    Gear geometry, backlash from allowances, stiffness of teeth, natural frequencies, rolling bearings, events, temperature.

    Parameters
    ----------
    progress
        Called with a label, the comparisons done and their number.

    Returns
    -------
    Validation
        ``.ds``, ``.passed``, ``.numbers()``, ``.plot()``; as text the table.

    Raises
    ------
    InputError
        For a ``progress`` that is not a function.

    Examples
    --------
    >>> import gearplay as gp
    >>> gp.validate().passed
    True

    """
    from gearplay.validation.published import COMPARISONS

    computed: list[float] = []
    for k, comparison in enumerate(COMPARISONS):
        if progress is not None:
            progress(f"{comparison.topic}: {comparison.title}", k, len(COMPARISONS))
        values = list(comparison.measure())
        missing = len(comparison.numbers) - len(values)
        computed += values[: len(comparison.numbers)] + [float("nan")] * missing
    return Validation(_dataset(np.array(computed)))


def _dataset(computed: Any) -> xr.Dataset:
    import xarray as xr

    from gearplay.validation.published import COMPARISONS

    rows = [(each, number) for each in COMPARISONS for number in each.numbers]
    published = np.array([number.value for _, number in rows])
    tolerance = np.array([number.tolerance for _, number in rows])
    deviation = computed - published
    variables: dict[str, tuple[Any, str]] = {
        "published": (published, "value as published, in its unit"),
        "computed": (computed, "value computed, in its unit"),
        "deviation": (deviation, "computed less published, in its unit"),
        "tolerance": (tolerance, "largest deviation that is accepted, in its unit"),
        "within": ((np.abs(deviation) <= tolerance).astype(np.int8), "1 where within the tolerance"),
    }
    texts = {
        "topic": ([each.topic for each, _ in rows], "topic"),
        "title": ([each.title for each, _ in rows], "what the numbers belong to"),
        "name": ([number.name for _, number in rows], "quantity"),
        "unit": ([number.unit for _, number in rows], "unit"),
        "source": ([each.source for each, _ in rows], "source"),
    }
    variables |= {name: (np.array(values, dtype=object), words) for name, (values, words) in texts.items()}
    return xr.Dataset(
        {name: ("number", values, {"long_name": words}) for name, (values, words) in variables.items()},
        attrs={"title": "Published numbers", "Conventions": "CF-1.11", "gearplay_version": VERSION},
    )
