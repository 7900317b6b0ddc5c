"""Signals and spectra of the members of a simulation."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from gearplay.model.variables import RESULT_VARIABLES
from gearplay.results.base import AnalysisResult
from gearplay.results.plain_samples import Lack
from gearplay.solver.kept_samples import KeptSamples
from gearplay.solver.status import Status
from gearplay.solver.trajectory import Trajectory
from gearplay.vocabulary.errors import InputError

if TYPE_CHECKING:
    from gearplay.results.spectra import Spectrum

Floats = NDArray[np.float64]


class MemberSignals(AnalysisResult):
    """Members of a simulation with their signals: stored samples, or computed from the motion on request."""

    runs: Sequence[Trajectory]
    _lack: Lack

    @property
    def members(self) -> int:
        """Number of runs."""
        return len(self.runs)

    @property
    def statuses(self) -> list[Status]:
        """Status of each member."""
        return [run.status for run in self.runs]

    @property
    def status(self) -> Status:
        """The worst status of all members."""
        return max(self.statuses, key=int)

    @property
    def sampling(self) -> float:
        """Samples per second [Hz]."""
        return self.runs[0].sampling

    def time(self, member: int = 0) -> Floats:
        """Return the times of the samples [s] of the member with an index, shape [time]; fewer where it stopped early."""
        return self.runs[member].time

    def held(self, signal: str | None = None) -> list[tuple[str, str]]:
        """Return the kept signals, as (signal, element); only those of one name if given."""
        found = [(c.signal, c.label) for c in self.runs[0].columns]
        return [each for each in found if signal in (None, each[0])]

    def signal(
        self,
        signal: str,
        label: str | None = None,
        member: int = 0,
        *,
        sampling: float | None = None,
        window: tuple[float, float] | None = None,
    ) -> Floats:
        """Return one signal of one element of the member at a place, computed from the motion on request.

        Parameters
        ----------
        signal
            Its name: ``ax``, ``ring.ax``, ``backlash``.
        label
            The rotor, sleeve or mesh; optional where only one has the signal, or the signal's name includes it.
        member
            Place of the member, 0 for the first.
        sampling
            Samples per second [Hz]; the record's if not given.
        window
            First time and the one that no sample reaches [s], counted from the start of the run; the record if not given.

        Returns
        -------
        numpy.ndarray
            Samples [SI], shape [time]; fewer where the member stopped early.

        Raises
        ------
        InputError
            For a signal or element that the result does not hold, a window outside the run, or another rate or window of a
            file's result that the case does not give again.
        ResourceError
            For more samples than fit into the memory.

        Examples
        --------
        >>> import gearplay as gp
        >>> result = gp.simulate("han2021", duration=0.1, transient=0.0)
        >>> len(result.signal("ring.ax")), len(result.signal("ring.ax", sampling=1e6, window=(0.02, 0.03)))
        (10000, 10000)

        """
        if label is None and "." in signal:
            label, _, signal = signal.rpartition(".")
        signal, label = self.only(signal, label)
        if sampling is not None or window is not None:
            run = self.runs[member]
            if not isinstance(run.samples, KeptSamples):
                name, value = ("window", str(window)) if sampling is None else ("sampling", sampling)
                raise self._lack.error(name, value)
            if sampling is not None and not (0.0 < sampling < np.inf):
                cure = "Give samples per second"
                raise InputError.of("sampling", sampling, "must be positive [Hz]", cure)
            at = [(c.signal, c.label) for c in run.columns].index((signal, label))
            return run.samples.at_rate(at, sampling, window)
        return self.runs[member].signal(signal, label)

    def only(self, signal: str, label: str | None) -> tuple[str, str]:
        """Return the one stored signal and element of these names; `InputError` where none or several match."""
        chosen = [each for each in self.held(signal) if label in (None, each[1])]
        if len(chosen) == 1:
            return chosen[0]
        known = sorted({f"{element}.{name}" for name, element in self.held(signal) or self.held()})
        shown = f"{label or ''}.{signal}".lstrip(".")
        if self._lack != Lack() and not chosen:
            raise self._lack.error("signal", shown)
        cure = f"Choose from: {', '.join(known) or 'none'}"
        raise InputError.of("signal", shown, "must name one signal that was kept", cure)

    def spectrum(
        self, signal: str, *, rotor: str | None = None, label: str | None = None, window: str = "hann"
    ) -> Spectrum:
        """Return the one-sided amplitude spectrum of a signal, averaged over the members that reached their end.

        Parameters
        ----------
        signal
            Its name: ``ax``.
        rotor, label
            The element, by either name; may be left out where only one has the signal.
        window
            Name of a window of `scipy.signal`.

        Returns
        -------
        Spectrum
            ``frequency`` [Hz] and ``amplitude`` [unit of the signal], shape [line]; of several members their rms average.

        Raises
        ------
        InputError
            For a signal or element that the result does not hold, a record that is too short, or where no member finished.

        Examples
        --------
        >>> import gearplay as gp
        >>> s = gp.simulate("han2021", duration=0.1, transient=0.0).spectrum("ax", rotor="ring")
        >>> round(s.resolution, 9), s.unit
        (10.0, 'm/s^2')

        """
        from gearplay.results.spectra import ensemble_spectrum

        signal, element = self.only(signal, rotor or label)
        whole = [at for at, status in enumerate(self.statuses) if status == Status.DONE]
        if not whole and self.members > 1:
            rule = "has no member that reached its end, so no spectrum"
            raise InputError.of("spectrum", self.status.name, rule, self.message)
        records = [self.signal(signal, element, at) for at in whole or [0]]
        return ensemble_spectrum(records, self.sampling, window=window, unit=RESULT_VARIABLES[signal].unit)
