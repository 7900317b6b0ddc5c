"""Result of `sweep`."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Self

from gearplay.results.base import OfDataset
from gearplay.results.outcomes import Account
from gearplay.sweeps.plans.plan import SweepPlan
from gearplay.sweeps.plans.reading import load_sweep
from gearplay.sweeps.running.evaluate import Sweep
from gearplay.vocabulary.errors import InputError

if TYPE_CHECKING:
    import xarray as xr

    from gearplay.sweeps.report.figures import Picture


@dataclass(frozen=True, repr=False)
class SweepResult(OfDataset):
    """A sweep's product: a dimension per axis, the kept numbers of each case, ``status`` and ``reason``.

    Attributes: ``ds``, SI, its dimensions the axes, ``sample`` and ``member`` where there are any; ``plan``,
    ``account`` (how many cases ended how), ``message``.
    """

    result_kind = "sweep"

    @classmethod
    def from_dataset(cls, dataset: xr.Dataset) -> Self:
        """Return the sweep whose product it is."""
        found = super().from_dataset(dataset)
        if "plan" not in dataset.attrs:
            raise InputError.of("dataset", "no plan", "must be a sweep's product", "Run the sweep again")
        return found

    @cached_property
    def plan(self) -> SweepPlan:
        """The plan of the sweep."""
        return load_sweep(json.loads(self.dataset.attrs["plan"]))

    @property
    def account(self) -> Account:
        """Number of cases by status."""
        return Account.of(self.dataset["status"].values, self.dataset["reason"].values)

    @property
    def message(self) -> str:
        """Title and account as text."""
        title = str(self.dataset.attrs.get("title", ""))
        return f"{title}: {self.account}" if title else str(self.account)

    def rows(self) -> Sequence[tuple[str, str]]:
        """Return axes, variables, and reasons of failures."""
        axes = [
            (str(dim), f"{size} values")
            for dim, size in self.dataset.sizes.items()
            if dim in self.dataset["status"].dims
        ]
        kept = [
            (str(name), f"{variable.attrs.get('long_name', '')} [{variable.attrs.get('units', '1')}]")
            for name, variable in self.dataset.data_vars.items()
            if name not in ("status", "reason")
        ]
        return [*axes, *kept, *((f"{count} failed", reason) for reason, count in self.account.reasons)]

    def pictures(self) -> list[Picture]:
        """Return the applicable pictures, each a PNG with a caption; none where nothing varies."""
        from gearplay.sweeps.report.figures import pictures_of

        return pictures_of(Sweep(self.plan), self.dataset)

    def plot(self, name: str | None = None) -> Picture:
        """Return one of `pictures`, the first if not named; a notebook shows it, ``.save(path)`` writes it.

        Raises `InputError` where there is none, or none of that name.
        """
        drawn = {picture.name: picture for picture in self.pictures()}
        wanted = next(iter(drawn), None) if name is None else name
        if wanted in drawn:
            return drawn[wanted]
        known = ", ".join(drawn) or "none: nothing varies, or no case was finished"
        raise InputError.of(
            "plot", name or "picture", "must be a picture of this sweep", f"Pictures: {known}"
        )
