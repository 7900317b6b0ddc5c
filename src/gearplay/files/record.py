"""Records of a sensor or a simulation: channels with unit and sampling rate."""

import html
import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from difflib import get_close_matches
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from gearplay.vocabulary.errors import NO_VALUE, InputError
from gearplay.vocabulary.suggestions import listed

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

Floats = NDArray[np.float64]


@dataclass(frozen=True, repr=False)
class Channel:
    """One evenly sampled signal.

    Parameters
    ----------
    name
        As the file or the rig calls it.
    values
        Samples, shape [time], in ``unit``.
    sampling
        Sampling rate [Hz].
    unit
        As in the source, ``m/s^2`` or ``V``; empty where the source has none.
    start
        Time of the first sample [s].
    attributes
        Further metadata of the channel in the source, as text.

    Examples
    --------
    >>> channel = Channel("acc", np.zeros(500), 1000.0, "m/s^2")
    >>> channel.duration, float(channel.time[1])
    (0.5, 0.001)

    """

    name: str
    values: Floats
    sampling: float
    unit: str = ""
    start: float = 0.0
    attributes: Mapping[str, str] = field(default_factory=dict)

    def __repr__(self) -> str:
        unit = f", {self.unit}" if self.unit else ""
        return f"<gearplay channel {self.name}: {self.size} samples at {self.sampling:g} Hz{unit}>"

    @property
    def size(self) -> int:
        """Number of samples."""
        return self.values.size

    @property
    def duration(self) -> float:
        """Number of samples over the sampling rate [s]."""
        return float(self.size) / self.sampling

    @property
    def time(self) -> Floats:
        """Time of each sample [s], shape [time]."""
        return self.start + np.arange(self.size) / self.sampling


@dataclass(frozen=True, repr=False)
class Record:
    """Channels taken together, measured or simulated.

    Parameters
    ----------
    channels
        The signals, which may differ in length and rate.
    source
        The file's name or the case's title.
    format
        The kind of file, "simulated" for the virtual rig.
    attributes
        Further metadata of the source, as text.

    Attributes
    ----------
    ds : xarray.Dataset
        A variable for each channel over ``time`` [s]; channels of different lengths or rates have times of their own.
    message : str

    Examples
    --------
    >>> record = Record((Channel("acc", np.sin(np.arange(8.0)), 1000.0, "m/s^2"),), source="bench")
    >>> record.message, record.ds["acc"].attrs["units"]
    ('bench: 1 channel, 0.008 s', 'm/s^2')

    """

    channels: tuple[Channel, ...]
    source: str = ""
    format: str = "simulated"
    attributes: Mapping[str, str] = field(default_factory=dict)

    def __repr__(self) -> str:
        return f"<gearplay record {self.message}; channels {self._shown_names() or 'none'}>"

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the channels, in order."""
        return tuple(channel.name for channel in self.channels)

    def _shown_names(self) -> str:
        return listed(self.names)

    def channel(self, name: str | None = None) -> Channel:
        """Return one channel by its name; without a name the only one.

        Raises `InputError` for a name that is not there, or none where there are several.

        >>> record = Record((Channel("acc", np.zeros(4), 1000.0, "m/s^2"),))
        >>> record.channel().unit, record.channel("acc").duration
        ('m/s^2', 0.004)
        """
        if name is None and len(self.channels) == 1:
            return self.channels[0]
        for channel in self.channels:
            if channel.name == name:
                return channel
        channels = f"Channels: {self._shown_names() or 'none'}"
        if name is None:
            rule = (
                "is required: the record has several channels"
                if self.channels
                else "there is none in the record"
            )
            raise InputError.of(
                "channel", NO_VALUE, rule, channels if self.channels else "Take another record"
            )
        close = get_close_matches(name, self.names, 1)
        cure = f"Did you mean '{close[0]}'?" if close else channels
        raise InputError.of("channel", name, "must be a channel of the record", cure)

    @property
    def message(self) -> str:
        """Summary of the record as text."""
        longest = max((channel.duration for channel in self.channels), default=0.0)
        count = f"{len(self.channels)} channel{'s' if len(self.channels) != 1 else ''}"
        return f"{self.source or 'record'}: {count}, {longest:.4g} s"

    @property
    def ds(self) -> "xr.Dataset":
        """The channels as a dataset; ``time`` in s, numbered where channels differ in length, rate or start."""
        import xarray as xr

        grids = list(dict.fromkeys((c.size, c.sampling, c.start) for c in self.channels))
        names = ["time"] if len(grids) == 1 else [f"time_{at}" for at in range(len(grids))]
        variables, coordinates = {}, {}
        for c in self.channels:
            own = names[grids.index((c.size, c.sampling, c.start))]
            words = {"units": c.unit, "long_name": c.name, "sampling": c.sampling, **c.attributes}
            variables[c.name] = (own, c.values, words)
            coordinates[own] = (own, c.time, {"units": "s", "long_name": "time"})
        attributes = {"title": self.source, "format": self.format, **self.attributes}
        return xr.Dataset(variables, coordinates, attributes)

    def plot(self, channel: str | None = None, *, ax: "Axes | None" = None) -> "Axes":
        """Draw a channel over time, the last one if not named; of many samples the lowest and highest."""
        from gearplay.pictures.style import new_axes, plot_curve

        chosen = self.channel(channel) if channel is not None else self.channels[-1]
        axes, words = ax if ax is not None else new_axes(), f"signal [{chosen.unit or '1'}]"
        plot_curve(axes, chosen.time, np.asarray(chosen.values, dtype=np.float64), words)
        axes.set_title(chosen.name, fontsize=9, loc="left")
        return axes

    def save(self, path: str | os.PathLike[str], *, overwrite: bool = False) -> None:
        """Write the record as `gearplay.write_record` does, its kind by the extension; `gearplay.read_result` reads it back."""
        from gearplay.files.measurements.writing import write_record

        write_record(self, path, overwrite=overwrite)

    def _repr_html_(self) -> str:
        from gearplay.pictures.pages import html_table

        head = ("channel", "unit", "sampling", "length")
        rows = [(c.name, c.unit or "1", f"{c.sampling:g} Hz", f"{c.size} samples") for c in self.channels]
        return f"<p>{html.escape(self.message)}</p>" + html_table(rows, head)
