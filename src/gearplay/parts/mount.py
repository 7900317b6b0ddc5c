"""Mounting of rotors in the parts that hold them, read from packed records."""

from typing import Any, NamedTuple


class Mount(NamedTuple):
    """A part that holds a rotor's centre, in axes that turn with its carrier.

    Parameters
    ----------
    rotor, carrier
        Their indices; -1 for the ground.
    place
        Nominal centre of the rotor from that of the carrier [m], (0, 0) on the ground.
    seat
        Centre of the part from the nominal centre of the rotor [m].
    isotropic
        Whether it acts alike in all directions about its seat.

    """

    rotor: int
    carrier: int
    place: tuple[float, float]
    seat: tuple[float, float]
    isotropic: bool


def seats(records: Any, rotor: str, carrier: str) -> list[Mount]:
    """Return the mounting of isotropic parts; ``rotor`` and ``carrier`` name fields of a record."""
    return [
        Mount(
            int(each[rotor]),
            int(each[carrier]),
            (float(each["offset_x"] - each["misplaced_x"]), float(each["offset_y"] - each["misplaced_y"])),
            (float(each["misplaced_x"]), float(each["misplaced_y"])),
            isotropic=True,
        )
        for each in records
    ]
