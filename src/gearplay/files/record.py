"""Records: what a sensor or a simulation gives, channel by channel, with unit and sampling rate."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from difflib import get_close_matches
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from gearplay.vocabulary.errors import Fault, InputError

Floats = NDArray[np.float64]


@dataclass(frozen=True)
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
        As the source writes it, ``m/s^2`` or ``V``; empty where it does not say.
    start
        Time of the first sample [s].
    attributes
        What else the source says of the channel, as text.

    """

    name: str
    values: Floats
    sampling: float
    unit: str = ""
    start: float = 0.0
    attributes: Mapping[str, str] = field(default_factory=lambda: MappingProxyType({}))

    @property
    def duration(self) -> float:
        """Number of samples over the sampling rate [s]."""
        return float(self.values.size) / self.sampling

    @property
    def time(self) -> Floats:
        """Time of each sample [s], shape [time]."""
        return self.start + np.arange(self.values.size) / self.sampling


@dataclass(frozen=True)
class Record:
    """Channels taken together, measured or simulated.

    ``source`` is the file's name or the case's title, ``format`` the kind of file ("simulated" for the virtual rig),
    ``attributes`` what else the source says, as text.
    """

    channels: tuple[Channel, ...]
    source: str = ""
    format: str = "simulated"
    attributes: Mapping[str, str] = field(default_factory=lambda: MappingProxyType({}))

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the channels, in order."""
        return tuple(channel.name for channel in self.channels)

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
        shown = ", ".join(self.names[:12]) + (", ..." if len(self.names) > 12 else "")
        close = get_close_matches(name or "", self.names, 1)
        cure = f"Did you mean '{close[0]}'?" if close else f"Channels: {shown or 'none'}"
        raise InputError([Fault("channel", name, "must be a channel of the record", cure)])
