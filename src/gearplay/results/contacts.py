"""Table of the contacts of a run or an ensemble."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gearplay.parts.protocol import without_slots
from gearplay.solver.trajectory import Trajectory
from gearplay.vocabulary.quantities import CONTACT_STATISTICS

Floats = NDArray[np.float64]
RATES = ("share_of_time", "impacts_per_second")
SHOWN = (*RATES, "mean_impact_speed", "peak_force")
"""Statistics in short tables."""
ANGULAR = {"m/s": ("mrad/s", 1e3), "N": ("N m", 1.0), "m": ("mrad", 1e3)}
"""Display units and factors of contacts between rotations, by the unit that others have."""
LARGEST = ("max_impact_speed", "peak_force", "max_penetration")
"""Statistics of which an ensemble has the largest of its members'; of the others it has means over time or impacts."""


@dataclass(frozen=True)
class ContactTable:
    """Statistics of every contact over all members of an ensemble, SI, each of shape [contact].

    Shares and rates are means over the time of all members, impact speeds over all their impacts, the largest of all is the
    largest; of couplings, where ``angular`` is true, in rad/s, N m and rad. ``spread`` holds the standard deviation of each
    statistic over the members, NaN for one member.
    """

    labels: tuple[str, ...]
    members: int
    values: Mapping[str, Floats]
    spread: Mapping[str, Floats]
    impacts: Floats
    angular: NDArray[np.bool_]

    @property
    def words(self) -> str:
        """Note on the numbers: empty for one run, else the kind of average over members."""
        if self.members == 1:
            return ""
        return f"{self.members} members together: means over their time and impacts, the largest of all"

    def shown(self, name: str, at: int) -> str:
        """Return one number of one contact in display units, ``-`` where there is none."""
        value, quantity = float(self.values[name][at]), CONTACT_STATISTICS[name]
        if not np.isfinite(value):
            return "-"
        turned = ANGULAR.get(quantity.unit) if self.angular[at] else None
        unit, factor = turned or (quantity.display_unit, quantity.display_factor)
        return f"{factor * value:.3g} {unit}"

    def html(self) -> str:
        """Return the table that a notebook shows."""
        from gearplay.pictures.pages import html_table

        lines = [(label, *(self.shown(name, i) for name in SHOWN)) for i, label in enumerate(self.labels)]
        note = f"<p>{self.words}</p>" if self.words else ""
        return html_table(lines, ["contact", *(CONTACT_STATISTICS[name].long_name for name in SHOWN)]) + note


def contact_table(
    labels: Sequence[str],
    each: Mapping[str, Floats],
    spans: Floats,
    angular: NDArray[np.bool_] | None = None,
) -> ContactTable:
    """Return the table of members' statistics, each of shape [member, contact], recorded over ``spans`` [s], shape [member].

    A member that recorded nothing counts for nothing.

    >>> each = dict.fromkeys(CONTACT_STATISTICS, np.zeros((2, 1)))
    >>> each |= {"impacts_per_second": np.array([[1.0], [3.0]]), "mean_impact_speed": np.array([[0.1], [0.2]])}
    >>> found = contact_table(["ring"], each, np.array([1.0, 1.0]))
    >>> found.values["impacts_per_second"].tolist(), found.values["mean_impact_speed"].round(9).tolist()
    ([2.0], [0.175])
    """
    time = np.where(np.isfinite(spans) & (spans > 0.0), spans, 0.0)[:, None]
    each = {name: np.where(time > 0.0, table, 0.0) for name, table in each.items()}
    impacts = each["impacts_per_second"] * time
    whole, total = float(time.sum()), impacts.sum(axis=0)
    over_time = {name: (each[name] * time).sum(axis=0) / (whole or np.nan) for name in RATES}
    known = np.maximum(total, np.finfo(float).tiny)
    values = over_time | {
        "mean_impact_speed": (each["mean_impact_speed"] * impacts).sum(axis=0) / known,
        "rms_impact_speed": np.sqrt((each["rms_impact_speed"] ** 2 * impacts).sum(axis=0) / known),
        **{name: each[name].max(axis=0) for name in LARGEST},
    }
    lasting = time[:, 0] > 0.0
    none = np.full(len(labels), np.nan)  # of fewer than two members
    spread = {
        name: np.std(table[lasting], axis=0, ddof=1) if lasting.sum() > 1 else none
        for name, table in each.items()
    }
    turns = np.zeros(len(labels), dtype=bool) if angular is None else angular
    ordered = {name: values[name] for name in CONTACT_STATISTICS}
    return ContactTable(tuple(labels), len(spans), ordered, spread, total, turns)


def contacts_of(runs: Sequence[Trajectory]) -> ContactTable:
    """Return the table of all members' contacts, without slots."""
    first = runs[0].statistics
    labels = without_slots(first.labels)
    shown = np.isin(first.labels, labels)
    each = {
        name: np.array([getattr(run.statistics, name)[shown] for run in runs]) for name in CONTACT_STATISTICS
    }
    spans = np.array([run.reached - run.first_sample for run in runs])
    return contact_table(labels, each, spans, first.angular[shown])
