"""Assembly of the elements: indices of their contacts, modes, switches, states and signals."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gearplay.kernels.layout import (
    CONTACT,
    ELEMENT,
    OWN,
    PER_ROTOR,
    PLACES,
    PULL,
    ROTOR,
    SWITCH,
    TOUCH,
    System,
)
from gearplay.parts.joining import Spring, join_rotors

Floats = NDArray[np.float64]

LENGTH_SCALE = 1e-4  # m, natural size of a displacement behind the error tolerances
ANGLE_SCALE = LENGTH_SCALE / 0.1  # rad, of a rotation without a radius of its own


def blank(dtype: np.dtype[Any]) -> Any:
    """Return a record to be filled, its fields attributes and zero: `stacked` makes an array of them."""
    return SimpleNamespace(**dict.fromkeys(dtype.names or (), 0))


@cache
def _of_records(dtype: np.dtype[Any]) -> tuple[np.dtype[Any], tuple[str, ...], frozenset[str]]:
    """Return a dtype whose items have fields as attributes, and the names of its fields."""
    names = dtype.names or ()
    return np.dtype((np.record, dtype)), names, frozenset(names)


@cache
def _none(dtype: np.dtype[Any]) -> Any:
    """Return an array of no records."""
    return np.zeros(0, _of_records(dtype)[0]).view(np.recarray)


def stacked(dtype: np.dtype[Any], rows: Sequence[Any]) -> Any:
    """Return filled records as an array whose fields are attributes.

    Raises `TypeError` where a record has a field that its kind lacks.
    """
    of_records, names, known = _of_records(dtype)
    if not rows:
        return _none(dtype)
    fields = [vars(row) for row in rows]
    for each in fields:
        if each.keys() != known:
            raise TypeError(f"a record has no field {', '.join(sorted(each.keys() - known))}")
    return np.array([tuple([row[name] for name in names]) for row in fields], of_records).view(np.recarray)


class Contact(NamedTuple):
    """One contact of an element: natural size [m or rad] of its penetration, least stored impact speed [m/s] (None where
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
    """Elements of a mechanism, added kind after kind, in the order of their kinds."""

    rotors: int
    entries: list[Any] = field(default_factory=list)
    contacts: list[Any] = field(default_factory=list)
    switches: list[Any] = field(default_factory=list)
    parts: dict[int, list[Any]] = field(default_factory=dict)
    labels: dict[int, list[str]] = field(default_factory=dict)  # by kind
    contact_labels: list[str] = field(default_factory=list)
    modes: int = 0
    states: int = 0
    signals: int = 0
    impact_count: int = 0
    angular: list[bool] = field(default_factory=list)
    fastest: float = 0.0  # rad/s, estimate of the fastest contact's angular frequency
    springs: list[Spring] = field(default_factory=list)

    def add(
        self,
        law: Any,
        label: str,
        record: Any,
        rotors: Sequence[int],
        contacts: Sequence[Contact] = (),
        *,
        always: bool = False,
        switches: int = 0,
        of_contacts: int = 0,
        states: int = 0,
        modes: int = 0,
        slopes: int = 0,
        rate: float = 0.0,
        hides: bool = True,
        deferred: bool = False,
    ) -> None:
        """Add an element: the module of its law, its name, its record, the rotors it joins (-1 for the ground), its contacts.

        ``always`` is whether it acts whatever its contacts do; ``switches`` are of the whole element, ``of_contacts`` further
        ones of each contact, ``states`` those of its own, ``modes`` and ``slopes`` its modes and columns of slopes beyond those
        of its kind, ``rate`` the angular frequency [rad/s] at which its rotors oscillate;
        ``hides`` is whether switches of its contacts other than touches may return within a step, ``deferred`` whether forces
        leave its open contacts out.
        """
        kind: int = law.KIND
        self.fastest = max(self.fastest, rate)
        assert not self.entries or self.entries[-1].kind <= kind, "kind after kind"
        entry, parts = blank(ELEMENT), self.parts.setdefault(kind, [])
        entry.kind, entry.index, entry.element = kind, len(parts), len(self.entries)
        entry.a, entry.b, entry.c = (*rotors, -1, -1, -1)[:3]
        entry.always, entry.states, entry.contacts = int(always), states, len(contacts)
        entry.more_modes, entry.more_slopes, entry.deferred = modes, slopes, int(deferred)
        entry.contact, entry.impact_slot = len(self.contacts), self.impact_count
        entry.switch, entry.mode = len(self.switches), self.modes
        entry.state = 6 * self.rotors + self.states
        entry.signal = PER_ROTOR * self.rotors + self.signals
        if law.SIGNALS:
            self.labels.setdefault(kind, []).append(label)
        for contact in contacts:
            k = self._add_contact(entry, contact)
            self.contact_labels.append(f"{label}:{contact.name}" if contact.name else label)
            self.angular.append(contact.angular)
            for own in range(law.PER_CONTACT):
                role = (TOUCH, PULL)[own] if own < 2 else OWN
                self._add_switch(entry, k, role, hides and role != TOUCH)
        for _ in range(switches):
            self._add_switch(entry, -1, OWN, True)
        for _ in range(of_contacts):
            for k in range(entry.contact, entry.contact + entry.contacts):
                self._add_switch(entry, k, OWN, False)
        entry.switches = len(self.switches) - entry.switch
        parts.append(record)
        self.entries.append(entry)
        self.modes += law.MODES + modes
        self.states += states
        self.signals += len(law.SIGNALS)

    def join(
        self, axis: int, factors: Mapping[int, float], stiffness: float, damping: float, *, rest: float = 0.0
    ) -> None:
        """Add a `Spring` of the last element, all of whose forces are contacts, springs and dampers added so.

        An element with any other force adds none: rotors joined by it alone move in closed form, without that force.
        """
        self.springs.append(Spring(len(self.entries) - 1, axis, factors, stiffness, damping, rest))

    def _add_switch(self, entry: Any, contact: int, role: int, hides: bool) -> None:
        row, local = blank(SWITCH), len(self.switches) - entry.switch
        row.element, row.contact, row.role, row.local = entry.element, contact, role, local
        row.hides = int(hides)
        self.switches.append(row)

    def _add_contact(self, entry: Any, contact: Contact) -> int:
        row, k = blank(CONTACT), len(self.contacts)
        row.element, row.closed, row.natural = entry.element, int(contact.closed), contact.size
        row.impact_slot = row.partner = -1
        if contact.floor is not None:
            row.floor, row.impact_slot = contact.floor, self.impact_count
            self.impact_count += 1
        if contact.yields_to is not None:
            row.partner, row.yields = entry.contact + contact.yields_to, 1
            self.contacts[row.partner].partner = k
        self.contacts.append(row)
        return k

    def system(
        self,
        rotors: Sequence[Any],
        records: Sequence[np.dtype[Any]],
        *,
        terms: Floats,
        involutes: Floats,
        spline: Floats,
        gravity: Floats,
        base: Floats,
        record: Floats,
    ) -> System:
        """Return the packed system: modes of contacts come first; those of ``records`` of a kind hold the indices of elements."""
        joined = join_rotors(rotors, self.entries, self.springs, gravity)
        rows = [
            SimpleNamespace(**vars(row) | {"mode": row.mode + len(self.contacts)}) for row in self.entries
        ]
        kinds = []
        for k, form in enumerate(records):
            own, parts = [row for row in rows if row.kind == k], self.parts.get(k, [])
            for row, part in zip(own, parts, strict=True):
                vars(part).update({name: getattr(row, name) for name, _ in PLACES})
            kinds.append(stacked(form, parts))
        return System(
            rotors=stacked(ROTOR, rotors),
            elements=stacked(ELEMENT, rows),
            contacts=stacked(CONTACT, self.contacts),
            switches=stacked(SWITCH, self.switches),
            records=tuple(kinds),
            joined=joined.as_arrays(stacked),
            terms=terms,
            involutes=involutes,
            spline=spline,
            gravity=gravity,
            base=base,
            record=record,
        )
