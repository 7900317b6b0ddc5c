"""Signals at one instant, computed from the state, for sections and maps."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gearplay.integrate import dispatch
from gearplay.integrate.right_hand_side import make_loads
from gearplay.integrate.run import signal_count
from gearplay.integrate.switches import make_branch
from gearplay.kernels.layout import Branch
from gearplay.model.pack import Packed
from gearplay.parts.registry import KINDS
from gearplay.solver.frames import CarrierFrames
from gearplay.solver.trajectory import Column, choose_columns
from gearplay.vocabulary.errors import InputError

Floats = NDArray[np.float64]
ROTOR = ("x", "y", "theta", "vx", "vy", "omega")


def state_names(packed: Packed) -> tuple[str, ...]:
    """Return the names of a state's entries in their order, ``rotor.signal``; integrals of servos, the last ones, have none."""
    return tuple(
        f"{rotor}.{name}" for part in (ROTOR[:3], ROTOR[3:]) for rotor in packed.rotor_names for name in part
    )


class Observables:
    """Chosen signals as functions of time and state.

    Names are those of a result, ``element.signal`` or a signal of all its elements; those that need forces are not among them.
    ``mesh.x`` is the displacement along the line of action in half backlashes, 1 + drive_penetration / (backlash / 2): above 1
    the drive flank is pressed, below -1 the back flank, in between the teeth are free; of a torsional pair it is ``x``.
    Rotations and speeds count from the nominal ones; centres of planetary sets are in the frame of their turning carriers, of
    carried rotors relative to their pins, in axes that turn with the actual carrier.

    Raises `InputError` for a name that is no such signal.
    """

    def __init__(self, packed: Packed, names: Sequence[str]) -> None:
        halves = packed.half_backlashes
        self.columns, columns = choose_columns(
            packed, [halves[name][0] if name in halves else name for name in names]
        )
        self.shown = _shown(self.columns, names, halves)
        known = {"rotor": ROTOR} | {
            kind.name: tuple(signal.name for signal in kind.file.SIGNALS if signal.of_state) for kind in KINDS
        }
        for column in self.columns:
            if column.signal not in known[column.dimension]:
                rule = "must follow from the state alone"
                every = ", ".join(name for names_ in known.values() for name in names_)
                raise InputError.of("signals", column.signal, rule, f"Choose from: {every}")
        self.packed, self.row = packed, np.zeros(signal_count(packed.system))
        states = {name: at for at, name in enumerate(state_names(packed))}
        of_state = [c.dimension == "rotor" for c in self.columns]
        self.states = [(at, states[_name(c)]) for at, c in enumerate(self.columns) if of_state[at]]
        self.others = [(at, int(columns[at])) for at in range(len(columns)) if not of_state[at]]
        elements = packed.system.elements
        starts = {int(first): e for e, first in enumerate(elements["signal"]) if _shows(elements[e]["kind"])}
        self.elements = sorted({starts[max(s for s in starts if s <= place)] for _, place in self.others})
        self.frames = CarrierFrames(packed.system)
        asked = {place // 3 % packed.system.rotors.size for _, place in self.states if place % 3 < 2}
        self.carried = sorted(i for i in asked if self.frames.hubs[i] >= 0)
        self.loads, self.branch = make_loads(packed.system), make_branch(packed.system)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the signals, ``element.signal``."""
        return tuple(name for name, _, _ in self.shown)

    def __call__(self, t: float, y: Floats, branch: Branch | None = None) -> Floats:
        """Return the signals at time t [s] and state y, shape [signal]; NaN for a mesh whose gears cannot mesh there.

        ``branch`` is that of the run that has come to this state, where one has.
        """
        found = np.empty(len(self.columns))
        seen = self._beside_seats(t, y, self.frames.seen(t, y))
        for at, place in self.states:
            found[at] = seen[place]
        for e in self.elements:
            dispatch.observe(self.packed.system, e, t, y, branch or self.branch, self.loads, False, self.row)
        for at, place in self.others:
            found[at] = self.row[place]
        return np.array([found[at] if half is None else 1.0 + found[at] / half for _, at, half in self.shown])

    def _beside_seats(self, t: float, y: Floats, seen: Floats) -> Floats:
        """Return ``seen`` with centres and velocities of the requested carried rotors relative to their seats."""
        rotors: Any = self.packed.system.rotors
        n, found = rotors.size, seen.copy() if self.carried else seen
        for i in self.carried:
            hub = self.frames.hubs[i]
            own, other, rate, hub_rate = (slice(3 * k, 3 * k + 2) for k in (i, hub, n + i, n + hub))
            speed = float(rotors[hub].nominal_speed)
            angle = np.array(speed * t + y[3 * hub + 2])
            beside = self.frames.beside_seat(i, y[own], y[other], angle)
            found[own] = beside
            found[rate] = self.frames.rate_beside_seat(
                i, beside, y[rate], y[hub_rate], angle, np.array(speed + y[3 * (n + hub) + 2])
            )
        return found


def _shown(
    columns: Sequence[Column], names: Sequence[str], halves: Mapping[str, tuple[str, float]]
) -> list[tuple[str, int, float | None]]:
    """Return the name of each signal, the place of its column, and the half backlash [m] of one in half backlashes."""
    places = {_name(column): at for at, column in enumerate(columns)}
    shown: list[tuple[str, int, float | None]] = []
    for name in names:
        if name in halves:
            shown.append((name, places[halves[name][0]], halves[name][1]))
        else:
            of = [(each, at, None) for each, at in places.items() if name in (each, columns[at].signal)]
            shown += [each for each in of if each not in shown]
    return shown


def _shows(kind: int) -> bool:
    return bool(KINDS[kind].file.SIGNALS)


def _name(column: Column) -> str:
    return f"{column.label}.{column.signal}"
