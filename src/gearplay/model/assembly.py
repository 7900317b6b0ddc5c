"""Putting the elements of a mechanism together: where the contacts, modes, switches, states and signals of each lie."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gearplay.kernels.elements.table import KINDS
from gearplay.kernels.layout import CONTACT, ELEMENT, OWN, PER_ROTOR, PLACES, PULL, SWITCH, TOUCH, System

Floats = NDArray[np.float64]

LENGTH_SCALE = 1e-4  # m, natural size of a displacement behind the error tolerances
ANGLE_SCALE = LENGTH_SCALE / 0.1  # rad, of a rotation without a radius of its own


def records(dtype: np.dtype[Any], count: int) -> Any:
    """Return ``count`` zeroed records whose fields are attributes."""
    return np.zeros(count, dtype=dtype).view(np.recarray)


@dataclass(frozen=True)
class Contact:
    """One contact of an element: natural size [m or rad] of its penetration, least latched impact speed [m/s] (None where
    its law needs none), whether it touches from the start, the earlier contact of its element that it gives way to; its name
    among those of its element; whether it is one of angles and torques.
    """

    name: str = ""
    angular: bool = False
    size: float = LENGTH_SCALE
    floor: float | None = None
    closed: bool = False
    yields_to: int | None = None


@dataclass
class Assembly:
    """Elements of a mechanism, added kind after kind, in the order of `KINDS`."""

    rotors: int
    entries: list[dict[str, int]] = field(default_factory=list)
    contacts: list[dict[str, float]] = field(default_factory=list)
    switches: list[dict[str, int]] = field(default_factory=list)
    parts: dict[int, list[Any]] = field(default_factory=dict)
    labels: dict[str, list[str]] = field(default_factory=dict)
    contact_labels: list[str] = field(default_factory=list)
    modes: int = 0
    states: int = 0
    signals: int = 0
    latches: int = 0
    angular: list[bool] = field(default_factory=list)
    fastest: float = 0.0  # rad/s, estimate of the fastest contact's angular frequency

    def add(
        self,
        kind: int,
        label: str,
        record: Any,
        rotors: Sequence[int],
        contacts: Sequence[Contact] = (),
        *,
        always: bool = False,
        switches: int = 0,
        states: int = 0,
        rate: float = 0.0,
        hides: bool = True,
    ) -> None:
        """Add an element: its name, its record, the rotors it joins (-1 for the ground), its contacts; ``always`` where it acts
        whatever they do, ``switches`` of the whole element, ``states`` of its own, the angular frequency [rad/s] at which it
        makes its rotors swing; ``hides`` is whether the switches of its contacts but touch may return within a step.
        """
        self.fastest = max(self.fastest, rate)
        assert not self.entries or self.entries[-1]["kind"] <= kind, "kind after kind"
        file, e, first = KINDS[kind].file, len(self.entries), len(self.contacts)
        a, b, c = (*rotors, -1, -1, -1)[:3]
        entry = {"kind": kind, "index": len(self.parts.setdefault(kind, [])), "a": a, "b": b, "c": c}
        entry |= {"always": int(always), "contact": first, "contacts": len(contacts), "mode": self.modes}
        entry |= {"switch": len(self.switches), "state": 6 * self.rotors + self.states, "states": states}
        entry |= {"signal": PER_ROTOR * self.rotors + self.signals, "element": e, "latch": self.latches}
        if file.SIGNALS:
            self.labels.setdefault(KINDS[kind].name, []).append(label)
        for at, contact in enumerate(contacts):
            self._add_contact(e, contact, first)
            self.contact_labels.append(f"{label}:{contact.name}" if contact.name else label)
            self.angular.append(contact.angular)
            for own in range(file.PER_CONTACT):
                role = (TOUCH, PULL)[own] if own < 2 else OWN
                self._add_switch(e, entry["switch"], first + at, role, hides and role != TOUCH)
        for _ in range(switches):
            self._add_switch(e, entry["switch"], -1, OWN, True)
        entry |= {"switches": len(self.switches) - entry["switch"]}
        self.parts[kind].append(record)
        self.entries.append(entry)
        self.modes += file.MODES
        self.states += states
        self.signals += len(file.SIGNALS)

    def _add_switch(self, e: int, first: int, contact: int, role: int, hides: bool) -> None:
        local = len(self.switches) - first
        row = {"element": e, "contact": contact, "role": role, "local": local, "hides": int(hides)}
        self.switches.append(row)

    def _add_contact(self, e: int, contact: Contact, first: int) -> None:
        row: dict[str, float] = {"element": e, "latch": -1, "partner": -1, "yields": 0, "floor": 0.0}
        row |= {"closed": int(contact.closed), "natural": contact.size}
        if contact.floor is not None:
            row |= {"floor": contact.floor, "latch": self.latches}
            self.latches += 1
        if contact.yields_to is not None:
            row |= {"partner": first + contact.yields_to, "yields": 1}
            self.contacts[first + contact.yields_to]["partner"] = len(self.contacts)
        self.contacts.append(row)

    def system(
        self, rotors: Any, *, terms: Floats, involutes: Floats, spline: Floats, gravity: Floats
    ) -> System:
        """Return the packed system."""
        elements = _filled(ELEMENT, self.entries)
        elements["mode"] += len(self.contacts)  # modes of contacts come first
        return System(
            rotors=rotors,
            elements=elements.view(np.recarray),
            contacts=_filled(CONTACT, self.contacts).view(np.recarray),
            switches=_filled(SWITCH, self.switches).view(np.recarray),
            records=tuple(self._stacked(kind, elements) for kind in range(len(KINDS))),
            terms=terms,
            involutes=involutes,
            spline=spline,
            gravity=gravity,
        )

    def _stacked(self, kind: int, elements: Any) -> Any:
        """Return the records of a kind, each with its element's places."""
        parts = self.parts.get(kind, [])
        found = np.zeros(len(parts), KINDS[kind].file.RECORD)
        for at, part in enumerate(parts):
            found[at] = part
        own = elements[elements["kind"] == kind]
        for name, _ in PLACES:
            found[name] = own[name]
        return found.view(np.recarray)


def _filled(dtype: np.dtype[Any], rows: Sequence[dict[str, Any]]) -> NDArray[Any]:
    return np.array([tuple([row[name] for name in dtype.names or ()]) for row in rows], dtype)
