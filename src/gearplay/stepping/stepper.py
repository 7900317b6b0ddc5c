"""`Stepper`: a case advanced step by step, inputs held over each step, one member or thousands."""

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gearplay.integrate import run as kernel
from gearplay.integrate import tangent, tangent_state
from gearplay.integrate.stepping import change_inputs
from gearplay.model.initial import Starts
from gearplay.model.pack import pack
from gearplay.model.reading import Source, load_case
from gearplay.model.variables import VARIABLES
from gearplay.solver.integration import refuse_fixed_steps
from gearplay.solver.observables import state_names
from gearplay.solver.status import WORDS, Status
from gearplay.stepping.arguments import check_count, check_names, checked_inputs, checked_time, plain_numbers
from gearplay.stepping.inputs import find_inputs, find_outputs
from gearplay.stepping.shares import Share, Table
from gearplay.vocabulary.cores import worker_count
from gearplay.vocabulary.errors import InputError, SimulationError
from gearplay.vocabulary.memory import enough_memory

Floats = NDArray[np.float64]

MOST_MEMBERS = 10_000_000


@dataclass(frozen=True, eq=False)
class Snapshot:
    """Complete state of a stepper, returned by `Stepper.snapshot`."""

    states: NDArray[np.int64]
    implicit: NDArray[np.int64]
    values: Floats
    status: NDArray[np.int64]
    outputs: Floats
    owner: int


class Stepper:
    """A case advanced step by step, with inputs held over each step and events located inside it.

    Parameters
    ----------
    case
        A `Case`, a bundled name, a path or a table.
    inputs
        What a caller sets: ``ROTOR.drive.torque``, ``ROTOR.load.torque`` [N m], of a servo ``ROTOR.drive.speed`` [rad/s], of a
        position servo ``ROTOR.drive.angle`` [rad]. They begin with the values of the case.
    outputs
        Signals, ``ring.theta``, or ``ax`` for those of all rotors.
    batch
        Number of members, each with its own start and inputs.
    threads
        Threads that share the members; all cores if not given.

    Attributes
    ----------
    inputs, outputs, state_names
        Names, in the order of the arrays.
    units
        Unit of each input and output, by name.
    batch
        Number of members.

    Raises
    ------
    InputError
        For names that are no inputs or signals.
    SimulationError
        By `step` where the one member cannot be followed further.

    Examples
    --------
    >>> import gearplay as gp
    >>> stepper = gp.Stepper("two-stage-reducer", inputs=["output.load.torque"], outputs=["output.omega"])
    >>> y = stepper.reset()
    >>> for _ in range(10):
    ...     y = stepper.step(1e-3, [55.0])
    >>> y.shape, round(stepper.time, 12)
    ((1,), 0.01)

    """

    def __init__(
        self,
        case: Source,
        *,
        inputs: Sequence[str] = (),
        outputs: Sequence[str] = (),
        batch: int = 1,
        threads: int | None = None,
    ) -> None:
        check_names("inputs", inputs)
        check_names("outputs", outputs)
        check_count("batch", batch, MOST_MEMBERS)
        if threads is not None:
            check_count("threads", threads, 4096)
        self._case = case = load_case(case)
        if batch > 1 and case.differs_by_member:
            rule = "must be 1 where members differ: by a random record of the housing, or by teeth drawn within a class"
            raise InputError.of("batch", batch, rule, "Step one member, or remove base or quality")
        self._packed = packed = pack(case)
        self._inputs = find_inputs(case, packed, inputs)
        columns, places = find_outputs(packed, outputs)
        self.batch = batch
        self.inputs = tuple(each.name for each in self._inputs)
        self.outputs = tuple(f"{each.label}.{each.signal}" for each in columns)
        units = {q.name: q.unit for column in columns for q in VARIABLES[column.dimension]}
        self.units = {each.name: each.unit for each in self._inputs}
        self.units |= {f"{each.label}.{each.signal}": units[each.signal] for each in columns}
        self.state_names = state_names(packed)
        count = min(threads or worker_count(), batch)
        with enough_memory():
            shares = [Share(case, packed, self._inputs, places) for _ in range(count)]
            self._table = Table(shares, batch, self._inputs)
        self._pool = ThreadPoolExecutor(count) if count > 1 else None
        self._begin()
        self._starts = np.array([each.start for each in self._inputs])
        self.reset()

    def _begin(self) -> None:
        """Allocate the arrays of single steps."""
        self._dt, inputs = self._table.begin(1)
        self._u, self._all = inputs[0], self._table.outputs[0]
        self._y: Floats = self._all[0] if self.batch == 1 else self._all
        self._shapes = (self._u.shape[1:], self._u.shape)
        # Of one member, whose step is to cost no more than a call: its inputs, the step's length and status as single numbers.
        numbers: tuple[Any, ...] = (self._u[0], self._dt, self._table.status)
        views: list[Any] = [memoryview(each) for each in numbers]
        self._values, self._length, self._code = views
        self._advance = (
            self._table.shares[0].take if self.batch == 1 else partial(self._table.take, self._pool)
        )

    def reset(self, seed: int | None = None, states: Any = None) -> Floats:
        """Restart at t = 0 with the inputs of the case; return the outputs, shape [output] or [member, output].

        Parameters
        ----------
        seed
            Seed of starts that are drawn for all members; if not given they start as those of `simulate`: the first as the case
            says, the others drawn.
        states
            Starts instead, shape [state] or [member, state], in the order of ``state_names``: rotations and speeds count from the
            nominal ones.

        Raises
        ------
        InputError
            For starts of another shape, or that are not finite.

        """
        if states is None:
            states = self._usual(seed)
        else:
            states = np.asarray(states, dtype=np.float64)
            wanted = (self.batch, self._packed.state_size)
            if states.shape not in ((wanted[1],), wanted) or not np.isfinite(states).all():
                rule = f"must be finite numbers of shape [{wanted[1]}] or [{wanted[0]}, {wanted[1]}]"
                raise InputError.of("states", f"shape {list(states.shape)}", rule, "See state_names")
        self._table.reset(np.broadcast_to(states, (self.batch, self._packed.state_size)), self._starts)
        self._u[:] = self._starts
        return self._take(0.0)

    def _usual(self, seed: int | None) -> Floats:
        """Return the members' starts, shape [member, state]."""
        case = self._case
        if seed is not None:
            check_count("seed", seed, 2**63 - 1, low=0)
            run = case.run.model_copy(update={"seed": int(seed), "start": "drawn"})
            case = case.model_copy(update={"run": run})
        return Starts(case, self._packed).of_members(range(self.batch))

    def step(self, dt: float, u: Any = None, out: Floats | None = None) -> Floats:
        """Advance by a time, inputs held; return the outputs at its end.

        Parameters
        ----------
        dt
            Time [s], 0 or more.
        u
            Values of the inputs, shape [input] or [member, input]; those of the step before if not given.
        out
            Array that takes the outputs and is returned, so that a step allocates nothing at all; a new one if not given.

        Returns
        -------
        numpy.ndarray
            Shape [output], or [member, output] of a batch; NaN for a member of a batch that cannot be followed further
            (``failed``).

        Raises
        ------
        InputError
            For inputs of another shape, or that are not finite.
        SimulationError
            Where the one member cannot be followed further.

        """
        if u is not None:
            self._set(u)
        return self._take(checked_time(dt), out)

    def _set(self, u: Any) -> None:
        if self.batch == 1 and (values := plain_numbers(u, len(self._values))) is not None:
            for k, value in enumerate(values):
                self._values[k] = value
        else:
            self._u[:] = checked_inputs(u, self._shapes)

    def _take(self, dt: float, out: Floats | None = None) -> Floats:
        self._length[0] = dt
        self._advance()
        if self.batch == 1 and self._code[0] != kernel.DONE:
            raise SimulationError(f"step: {self.messages[0]} Stopped at t = {self.time:.9g} s.")
        if out is None:
            return self._y.copy()
        out[...] = self._y
        return out

    def rollout(self, dt: float, u: Any) -> Floats:
        """Take many steps of one length; return the outputs at the end of each, shape [step, (member,) output].

        Parameters
        ----------
        dt
            Length of a step [s].
        u
            Values of the inputs, shape [step, input] or [step, member, input].

        Returns
        -------
        numpy.ndarray
            A new array.

        Raises
        ------
        InputError, SimulationError
            As `step` does.

        """
        shape = (max(1, len(u)) if hasattr(u, "__len__") else 1, *self._u.shape)
        given = checked_inputs(u, ((shape[0], shape[2]), shape))
        length = checked_time(dt)
        with enough_memory():
            ends, inputs = self._table.begin(shape[0])
            inputs[:] = given if given.ndim == 3 else given[:, None]
            ends[:] = length
            try:
                self._table.take(self._pool)
                found, last = self._table.outputs, inputs[-1].copy()
            finally:
                self._begin()
        self._u[:], self._all[:] = last, found[-1]
        if self.batch == 1 and self._table.status[0] != Status.DONE:
            raise SimulationError(f"rollout: {self.messages[0]} Stopped at t = {self.time:.9g} s.")
        return found[:, 0] if self.batch == 1 else found

    def snapshot(self) -> Snapshot:
        """Return all that the next step depends on, to `restore` it."""
        table = self._table
        return Snapshot(
            states=table.states.copy(),
            implicit=table.implicit.copy(),
            values=table.values.copy(),
            status=table.status.copy(),
            outputs=self._y.copy(),
            owner=id(self._packed),
        )

    def restore(self, snapshot: Snapshot) -> Floats:
        """Go back to a snapshot of this stepper; return the outputs there.

        Raises `InputError` for that of another one.
        """
        if not isinstance(snapshot, Snapshot) or snapshot.owner != id(self._packed):
            rule = "must be a snapshot of this stepper"
            raise InputError.of("snapshot", type(snapshot).__name__, rule, "Take it by stepper.snapshot()")
        table = self._table
        table.states[:], table.implicit[:] = snapshot.states, snapshot.implicit
        table.values[:], table.status[:] = snapshot.values, snapshot.status
        self._u[:], self._y[:] = snapshot.values, snapshot.outputs
        return self._y.copy()

    def jacobian(self, dt: float, u: Any = None) -> Floats:
        """Return the derivative of the state after a step by the state before it, shape [state, state]; nothing moves.

        Exact through contacts and their events, as long as their order stays: from the tangent of the motion.

        Parameters
        ----------
        dt, u
            As of `step`.

        Returns
        -------
        numpy.ndarray
            In the order of ``state_names``, integrals of servos behind them.

        Raises
        ------
        InputError
            For a batch, and for a case of fixed steps.
        SimulationError
            Where the step cannot be taken.

        """
        if self.batch > 1:
            raise InputError.of(
                "batch", self.batch, "must be 1 for a derivative", "Make a stepper of one member"
            )
        refuse_fixed_steps(self._case)
        length, before = checked_time(dt), self.snapshot()
        if u is not None:
            self._set(u)
        share = self._table.shares[0]
        run, n = share.run, share.run.y.size
        try:
            share.load()
            share.held.wanted[:] = self._u[0]
            status = change_inputs(share.system, run, share.held)
            run.clock[kernel.T_END] = run.clock[kernel.T] + length
            moved = tangent_state.make_tangent(
                share.system, run, np.eye(n, n + run.branch.impact_speeds.size)
            )
            while status in (Status.DONE, Status.PAUSED):
                run.counts[kernel.LOGGED] = 0
                status = tangent.advance_tangent(share.system, run, moved, 1000)
                if status != Status.PAUSED:
                    break
            if status != Status.DONE:
                raise SimulationError(f"jacobian: {WORDS[Status(status)]} Stopped at t = {self.time:.9g} s.")
        finally:
            self.restore(before)
            share.load()
        return moved.changes[:, :n].T.copy()

    @property
    def time(self) -> Any:
        """Present time [s]; of a batch shape [member]."""
        times = self._table.column("clock", kernel.T)[:, 0]
        return float(times[0]) if self.batch == 1 else times.copy()

    @property
    def state(self) -> Floats:
        """Present state, shape [state] or [member, state], in the order of ``state_names``, integrals of servos behind them."""
        states = self._table.column("y")
        return (states[0] if self.batch == 1 else states).copy()

    @property
    def failed(self) -> NDArray[np.bool_]:
        """Which members cannot be followed further, shape [member]."""
        return np.asarray(self._table.status != Status.DONE)

    @property
    def messages(self) -> list[str]:
        """Status of each member as a sentence."""
        return [WORDS[Status(int(code))] for code in self._table.status]

    def __repr__(self) -> str:
        return f"Stepper of {self.batch} member(s), inputs {self.inputs}, outputs {self.outputs}"
