"""`simulate` and the `Result` it returns."""

import html
import os
from collections.abc import Mapping
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, overload

from gearplay.files.atomic import read_dataset, write_dataset
from gearplay.model.case import Case
from gearplay.model.pack import pack
from gearplay.model.reading import load_case, replace
from gearplay.model.variables import RESULT_VARIABLES
from gearplay.results.dataset import to_dataset
from gearplay.results.spectra import Spectrum, ensemble_spectrum
from gearplay.solver.simulate import Progress, run_batch
from gearplay.solver.status import Status
from gearplay.solver.trajectory import Trajectory, worst_of
from gearplay.vocabulary.errors import Fault, InputError

if TYPE_CHECKING:
    import xarray as xr

    from gearplay.results.plots import Plotter


class Result:
    """A finished simulation: every member's trajectory, and the same as one labelled dataset.

    Attributes: ``case``, ``runs`` (one `Trajectory` a member), ``ds`` (`xarray.Dataset`), ``status``, ``message``, ``success``.
    """

    def __init__(self, case: Case, runs: list[Trajectory]) -> None:
        self.case, self.runs = case, runs

    @cached_property
    def ds(self) -> "xr.Dataset":
        """The result as a dataset: dimensions time, rotor, sleeve, mesh, contact, and member for an ensemble."""
        return to_dataset(self.case, pack(self.case), self.runs)

    @property
    def _worst(self) -> Trajectory:
        return worst_of(self.runs)

    @property
    def status(self) -> Status:
        """The worst status of all members."""
        return self._worst.status

    @property
    def message(self) -> str:
        """That status in words, and what casts doubt on the run."""
        return self._worst.message

    @property
    def success(self) -> bool:
        """Whether every member reached its end."""
        return all(run.success for run in self.runs)

    @property
    def plot(self) -> "Plotter":
        """Pictures of this result: ``result.plot.orbit("ring")``, ``.history("backlash")``, ``.spectrum("ax", "ring")``."""
        from gearplay.results.plots import Plotter

        return Plotter(self.case, self.runs)

    def save(self, path: "str | os.PathLike[str]", *, overwrite: bool = False) -> None:
        """Write the dataset as netCDF-4, atomically; `InputError` where the file exists and ``overwrite`` is false."""
        write_dataset(self.ds, Path(path), overwrite=overwrite)

    def spectrum(
        self, signal: str, *, rotor: str | None = None, label: str | None = None, window: str = "hann"
    ) -> Spectrum:
        """Return the one-sided amplitude spectrum of a signal, averaged over the members.

        Name the element with ``rotor`` or, for sleeves and meshes, ``label``; it may be left out where there is only one.

        Raises `InputError` for a signal or element that the result does not hold.
        """
        columns = [c for c in self.runs[0].columns if c.signal == signal]
        wanted = rotor or label
        chosen = [c for c in columns if wanted is None or c.label == wanted]
        if len(chosen) != 1:
            held = sorted({f"{c.label}.{c.signal}" for c in columns or self.runs[0].columns})
            raise InputError(
                [
                    Fault(
                        "signal",
                        f"{wanted or ''}.{signal}".lstrip("."),
                        "must name one signal",
                        f"Choose from: {', '.join(held)}.",
                    )
                ]
            )
        records = [
            run.signal(signal, chosen[0].label) for run in self.runs if run.success or len(run.time) > 8
        ]
        step = float(self.runs[0].time[1] - self.runs[0].time[0])
        return ensemble_spectrum(records, 1.0 / step, window=window, unit=RESULT_VARIABLES[signal].unit)

    def __repr__(self) -> str:
        c = self.runs[0].counters
        members = f", {len(self.runs)} members" if len(self.runs) > 1 else ""
        return (
            f"<gearplay.Result {self.case.title or 'untitled'!r}: {self.status.name}{members},"
            f" {self.runs[0].reached:g} s, {c.steps} steps, {c.events} events>"
        )

    def _repr_html_(self) -> str:
        rows: list[tuple[str, Any]] = [
            ("case", self.case.title or "untitled"),
            ("model", f"{self.case.formulation}, {self.case.backlash_model}"),
            ("status", self.message),
            ("members", len(self.runs)),
            ("simulated time", f"{self.runs[0].reached:g} s"),
            (
                "steps, events",
                f"{sum(r.counters.steps for r in self.runs)}, {sum(r.counters.events for r in self.runs)}",
            ),
            ("wall time", f"{sum(r.wall_time for r in self.runs):.3g} s"),
        ]
        cells = "".join(
            f"<tr><th style='text-align:left'>{html.escape(k)}</th><td>{html.escape(str(v))}</td></tr>"
            for k, v in rows
        )
        s = self.runs[0].statistics
        contacts = "".join(
            f"<tr><th style='text-align:left'>{html.escape(label)}</th><td>{100 * s.share_of_time[i]:.3g} %</td>"
            f"<td>{s.impacts_per_second[i]:.3g} 1/s</td><td>{1e3 * s.mean_impact_speed[i]:.3g} mm/s</td>"
            f"<td>{s.peak_force[i]:.3g} N</td></tr>"
            for i, label in enumerate(s.labels)
        )
        head = "<tr><th></th><th>time in contact</th><th>impacts</th><th>mean impact speed</th><th>peak force</th></tr>"
        return f"<table>{cells}</table><table>{head}{contacts}</table>"


Source = Case | str | os.PathLike[str] | Mapping[str, Any]


def case_of(source: Source) -> Case:
    """Return a case as it is, or read it: a file, the name of a bundled case, or a mapping."""
    return source if isinstance(source, Case) else load_case(source)


@overload
def simulate(
    case: Source,
    *,
    duration: float | None = ...,
    transient: float | None = ...,
    sampling: float | None = ...,
    ensemble: int | None = ...,
    signals: list[str] | None = ...,
    progress: Progress | None = ...,
    threads: int | None = ...,
) -> Result: ...


@overload
def simulate(
    case: list[Any] | tuple[Any, ...],
    *,
    duration: float | None = ...,
    transient: float | None = ...,
    sampling: float | None = ...,
    ensemble: int | None = ...,
    signals: list[str] | None = ...,
    progress: Progress | None = ...,
    threads: int | None = ...,
) -> list[Result]: ...


def simulate(
    case: Source | list[Any] | tuple[Any, ...],
    *,
    duration: float | None = None,
    transient: float | None = None,
    sampling: float | None = None,
    ensemble: int | None = None,
    signals: list[str] | None = None,
    progress: Progress | None = None,
    threads: int | None = None,
) -> Result | list[Result]:
    """Simulate a case and return its `Result`, whatever its status; for a list of cases, the list of their results.

    ``case`` is a `Case`, a bundled name, a path or a mapping. ``duration`` and ``transient`` [s], ``sampling`` [Hz]
    and ``ensemble`` override the case's run; ``signals`` names what to keep (all by default). All members of all cases share
    one pool of ``threads`` (all cores by default), which changes nothing in the results. Nothing is raised once a
    run has started: look at ``result.success`` and ``result.message``.

    Raises `InputError` for bad input and `ResourceError` for a run that is too large.

    Examples
    --------
    >>> result = simulate("han2021", duration=0.01, transient=0.0)
    >>> result.success, sorted(result.ds.sizes)[:2]
    (True, ['contact', 'mesh'])
    >>> [r.success for r in simulate(["han2021", "external-pair"], duration=0.001, transient=0.0)]
    [True, True]

    """
    changes = {"duration": duration, "transient": transient, "sampling": sampling, "ensemble": ensemble}
    given = {f"run.{key}": value for key, value in changes.items() if value is not None}

    def resolved(source: Source) -> Case:
        loaded = case_of(source)
        return replace(loaded, given) if given else loaded

    cases = [resolved(source) for source in (case if isinstance(case, (list, tuple)) else [case])]
    jobs = [(each, range(each.run.ensemble)) for each in cases]
    runs = run_batch(jobs, signals=signals, progress=progress, threads=threads)
    results = [Result(each, its) for each, its in zip(cases, runs, strict=True)]
    return results if isinstance(case, (list, tuple)) else results[0]


def read_result(path: "str | os.PathLike[str]") -> "xr.Dataset":
    """Read a saved result into memory; `InputError` where it is missing or damaged."""
    return read_dataset(Path(path))
