"""Product of a sweep for drawing: axes in engineering units, tables of values, fixed coordinates."""

import warnings
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gearplay.pictures.scales import is_logarithmic
from gearplay.pictures.words import offset_in, short, shown_in
from gearplay.sweeps.running.evaluate import Sweep

if TYPE_CHECKING:
    import xarray as xr

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
Place = Mapping[str, int]
"""Positions along axes, by name."""

SAMPLE, MEMBER, DIRECTION = "sample", "member", "direction"
SPEED = "rad/s"
FIRM = "\N{NO-BREAK SPACE}"


@dataclass(frozen=True)
class Along:
    """An axis or a drawn parameter in display units: shown value = ``factor`` x SI value + ``offset``, in ``unit``.

    Categories have the values 0, 1, ... and ``labels``.
    """

    name: str
    unit: str
    factor: float
    values: Floats
    labels: tuple[str, ...] = ()
    log: bool = False
    scaled: bool = False
    offset: float = 0.0

    def shown(self, value: Any) -> Any:
        """Return values in SI, or factors, in display units."""
        return self.factor * value + self.offset

    def raw(self, shown: Any) -> Any:
        """Return shown values in SI, or as factors."""
        return (shown - self.offset) / self.factor

    @property
    def words(self) -> str:
        """The name as text."""
        return self.name.replace("_", " ") + (", factor" if self.scaled else "")

    @property
    def label(self) -> str:
        """Name and unit, for an axis of a picture."""
        return self.words if self.labels else f"{self.words} [{self.unit}]"

    def text(self, place: int) -> str:
        """Return one value as text with non-breaking blanks: ``speed 60 rpm``."""
        return f"{self.words}{FIRM}{self.value(place)}"

    def value(self, place: int) -> str:
        """Return one value with its unit."""
        if self.labels:
            return self.labels[place]
        return f"{self.values[place]:.4g}" + ("" if self.unit == "1" else f"{FIRM}{self.unit}")


def along_of(coordinate: "xr.DataArray", *, ordered: bool = True) -> Along:
    """Return a coordinate in display units; randomly sampled parameters are not ordered."""
    name, values = str(coordinate.name), np.asarray(coordinate.values)
    scaled = str(coordinate.attrs.get("long_name", "")).startswith("factor of ")
    if values.dtype.kind not in "if":
        labels = tuple(short(str(value), 30) for value in values)
        return Along(name, "1", 1.0, np.arange(float(len(values))), labels)
    numbers = values.astype(np.float64)
    unit, factor = shown_in(str(coordinate.attrs.get("units", "1")), float(np.max(np.abs(numbers))))
    log = is_logarithmic(numbers if ordered else np.quantile(numbers, np.linspace(0.0, 1.0, 9)))
    offset = offset_in(unit)
    if offset:
        log = False
    return Along(name, unit, factor, factor * numbers + offset, (), log, scaled, offset)


class View:
    """Product of a sweep, prepared for pictures.

    Numeric axes are in order and without repetitions; an axis of one value is left out and named in ``alone``. ``axes`` are the
    dimensions that vary (``direction`` is one of categories), ``drawn`` the parameters along ``sample``; ``scalars`` are the
    numbers that differ between cases, frequencies of lines last; ``spectra`` and ``histories`` have a dimension of their own.
    """

    def __init__(self, sweep: Sweep, dataset: "xr.Dataset") -> None:
        self.sweep = sweep
        self.alone: dict[str, Along] = {}
        self.axes: dict[str, Along] = {}
        for dim in map(str, dataset["status"].dims):
            values = dataset[dim].values
            if values.dtype.kind in "if":
                order = np.unique(values, return_index=True)[1]
                if not np.array_equal(order, np.arange(len(values))):
                    dataset = dataset.isel({dim: order})
            if dataset.sizes[dim] == 1:
                dataset = dataset.isel({dim: 0})
                self.alone |= {} if dim in (SAMPLE, MEMBER) else {dim: _alone(dataset[dim])}
            elif dim not in (SAMPLE, MEMBER):
                self.axes[dim] = along_of(dataset[dim])
        self.dataset = dataset
        points = set(dataset["status"].dims)
        self.members, self.samples = (int(dataset.sizes.get(d, 1)) for d in (MEMBER, SAMPLE))
        self.drawn = {
            str(name): along_of(coordinate, ordered=False)
            for name, coordinate in dataset.coords.items()
            if coordinate.dims == (SAMPLE,) and name != SAMPLE and np.ptp(coordinate.values) > 0
        }
        self._units: dict[str, tuple[str, float]] = {}
        scalars, self.spectra, self.histories = [], [], []
        for name, variable in dataset.data_vars.items():
            if variable.dtype.kind != "f" or not self._measure(str(name)):
                continue
            own = [d for d in variable.dims if d not in points]
            if not own:
                scalars.append(str(name))
            elif dataset[own[0]].attrs.get("units") == "Hz":
                self.spectra.append(str(name))
            else:
                self.histories.append(str(name))
        self.scalars = sorted(scalars, key=lambda name: dataset[name].attrs.get("units") == "Hz")

    def _measure(self, name: str) -> bool:
        """Note the unit of a variable; return whether it has different values."""
        values = self.dataset[name].values
        known = values[np.isfinite(values)]
        if not known.size:
            return False
        low, high = float(known.min()), float(known.max())
        self._units[name] = shown_in(str(self.dataset[name].attrs.get("units", "1")), max(-low, high))
        return high - low > 1e-9 * max(-low, high)

    @property
    def numeric(self) -> list[str]:
        """Numeric axes, speeds first, then the longest."""
        found = [name for name, axis in self.axes.items() if not axis.labels]
        return sorted(
            found, key=lambda n: (self.dataset[n].attrs.get("units") != SPEED, -len(self.axes[n].values))
        )

    @property
    def categories(self) -> list[str]:
        """Axes of categories, ``direction`` last."""
        found = [name for name, axis in self.axes.items() if axis.labels]
        return sorted(found, key=lambda name: name == DIRECTION)

    def label(self, name: str) -> str:
        """Return the long name of a variable with its unit."""
        return f"{self.dataset[name].attrs.get('long_name', name)} [{self._units[name][0]}]"

    def unit(self, name: str) -> str:
        """Return the unit in which a variable is shown."""
        return self._units[name][0]

    def held(self, free: Iterable[str]) -> dict[str, int]:
        """Return the middle of every axis but the ``free`` ones."""
        left = set(free)
        return {name: len(axis.values) // 2 for name, axis in self.axes.items() if name not in left}

    def raw(self, name: str, at: int) -> Any:
        """Return one value of an axis as the case takes it, SI or a factor."""
        return self.dataset[name].values[at].item()

    def where(self, place: Place) -> str:
        """Return positions as text: ``model coupled, speed 60 rpm``."""
        return ", ".join(self.axes[name].text(at) for name, at in place.items())

    def brief(self, place: Place) -> str:
        """Return positions in few letters: ``coupled, 60 rpm``."""
        return ", ".join(self.axes[name].value(at) for name, at in place.items())

    def held_words(self, held: Place) -> str:
        """Return a text of the constants of a picture: positions held, and axes of one value."""
        alone = [axis.text(0) for axis in self.alone.values()]
        return ", ".join(words for words in (self.where(held), *alone) if words)

    def values(self, name: str, dims: Sequence[str], place: Place) -> Floats:
        """Return a variable in its unit over ``dims`` at a place, all members and drawn points, NaN where not finite."""
        chosen = self.dataset[name].isel(dict(place))
        kept = [*dims, *(d for d in (SAMPLE, MEMBER) if d in chosen.dims and d not in dims)]
        found = self._units[name][1] * chosen.transpose(*kept).values
        return np.where(np.isfinite(found), found, np.nan)

    def bands(self, name: str, dims: Sequence[str], place: Place) -> tuple[Floats, Floats, Floats]:
        """Return mean, least and greatest of the members; median, 5 % and 95 % of drawn points."""
        found = self.values(name, dims, place)
        if self.samples > 1 and SAMPLE not in dims:
            if self.members > 1:
                found = _quietly(np.nanmean, found)
            median, low, high = _quietly(np.nanquantile, found, q=[0.5, 0.05, 0.95])
            return median, low, high
        if self.members > 1:
            return _quietly(np.nanmean, found), _quietly(np.nanmin, found), _quietly(np.nanmax, found)
        return found, found, found

    def table(self, name: str, dims: Sequence[str], place: Place) -> Floats:
        """Return a variable over ``dims``: the mean of the members, the median of drawn points."""
        return self.bands(name, dims, place)[0]

    def at_cases(self, name: str, places: Mapping[str, NDArray[np.intp]]) -> Floats:
        """Return a variable in its unit at listed positions along every axis and ``sample``, the mean of the members."""
        import xarray as xr

        pointed = {dim: xr.DataArray(at, dims="case") for dim, at in places.items()}
        found = self._units[name][1] * self.dataset[name].isel(pointed).transpose("case", ...).values
        found = np.where(np.isfinite(found), found, np.nan)
        return np.asarray(_quietly(np.nanmean, found)) if found.ndim > 1 else found

    def failed(self, dims: Sequence[str], place: Place) -> Flags:
        """Return where cases failed and none was finished, over ``dims``; cases that were not run yet are no failure."""
        status = self.dataset["status"].isel(dict(place))
        over = [d for d in status.dims if d not in dims]
        wrong = (status != 0).all(over) & (status > 0).any(over)
        return np.asarray(wrong.transpose(*dims).values)

    @property
    def band_words(self) -> str:
        """Meaning of a curve and its band, empty where there is one case per point."""
        if self.samples > 1:
            return f"median and 5 to 95 % of {self.samples} drawn points"
        return f"mean and range of {self.members} members" if self.members > 1 else ""

    @property
    def member_words(self) -> str:
        """Meaning of the number of a case, empty where it has one member."""
        return f"mean of {self.members} members" if self.members > 1 else ""

    @property
    def mean_words(self) -> str:
        """Meaning of a number of a table, empty where there is one case per point."""
        return self.band_words.replace("and 5 to 95 % ", "").replace("and range ", "")


def _alone(coordinate: "xr.DataArray") -> Along:
    return along_of(coordinate.expand_dims("one"))


def _quietly(reduce: Any, values: Floats, **more: Any) -> Any:
    """Reduce the last dimension; where all cases failed there is no number, and no warning."""
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", r"All-NaN|Mean of empty", RuntimeWarning)
        return reduce(values, axis=-1, **more)
