"""Orders at which damage of a rolling bearing appears, and the envelope lines found there."""

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gearplay.files.record import Channel
from gearplay.parts.bearing.geometry import pass_orders
from gearplay.signals.checks import check_count, check_positive, check_real, refuse
from gearplay.signals.envelopes import envelope_spectrum

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class BearingOrders:
    """Events per turn of the shaft relative to the outer ring, the inner ring turning with the shaft.

    ``ftf`` turns of the cage; ``bpfo`` elements that pass a place of the outer ring, ``bpfi`` of the inner ring; ``bsf`` turns of
    an element about itself: a defect of it meets a ring at twice that.
    """

    ftf: float
    bpfo: float
    bpfi: float
    bsf: float

    def frequencies(self, speed: float) -> dict[str, float]:
        """Return FTF, BPFO, BPFI and BSF [Hz] at a speed [Hz]."""
        return {name.upper(): order * speed for name, order in vars(self).items()}


def bearing_orders(
    elements: int, diameter: float, pitch_diameter: float, *, contact_angle: float = 0.0
) -> BearingOrders:
    """Return the orders of a rolling bearing of pure rolling.

    With g = D cos(a) / d_m: FTF = (1 - g) / 2, BPFO = Z FTF, BPFI = Z (1 + g) / 2, BSF = d_m (1 - g^2) / (2 D). Elements slip: a
    bearing's lines lie one or two per cent off.

    Source: Randall, Vibration-based Condition Monitoring (2011), section 2.2.3.

    Parameters
    ----------
    elements
        Number of balls or rollers Z.
    diameter
        Of an element, D [m].
    pitch_diameter
        Of the circle of their centres, d_m [m].
    contact_angle
        a [rad].

    Returns
    -------
    BearingOrders
        Events per turn [1].

    Raises
    ------
    InputError
        For an impossible geometry.

    Examples
    --------
    >>> found = bearing_orders(9, 0.3126 * 0.0254, 1.537 * 0.0254)  # 6205
    >>> round(found.bpfi, 9), round(found.bpfi * 1797 / 60, 2)
    (5.415224463, 162.19)

    """
    check_count("elements", elements, 2, 1000, "Give the number of balls or rollers")
    check_positive("diameter", diameter, "m")
    check_positive("pitch_diameter", pitch_diameter, "m")
    check_real("contact_angle", contact_angle, 0.0, 1.57, "It is in radians, 0 for a deep-groove bearing")
    if pitch_diameter * math.sin(math.pi / elements) <= diameter * (1.0 - 1e-9):
        rule = f"must hold {elements} elements of {diameter:g} m beside each other"
        refuse("pitch_diameter", pitch_diameter, rule, "Check the three numbers and their units")
    orders = pass_orders(elements, diameter / pitch_diameter, contact_angle)
    return BearingOrders(orders.cage, orders.outer, orders.inner, orders.spin)


@dataclass(frozen=True)
class EnvelopeLine:
    """Highest line of an envelope spectrum near an expected one.

    ``expected``, ``frequency`` [Hz], ``amplitude`` [unit]; ``prominence`` is the height over the median of the lines around [1].
    """

    name: str
    expected: float
    frequency: float
    amplitude: float
    prominence: float


def envelope_lines(
    channel: Channel,
    expected: Mapping[str, float],
    low: float,
    high: float,
    *,
    harmonics: int = 3,
    search: float = 0.02,
) -> list[EnvelopeLine]:
    """Return the lines of the envelope of a band at expected frequencies and their multiples, as far as the band resolves them.

    Source: Randall and Antoni, Mech. Syst. Signal Process. 25 (2011) 485.

    Parameters
    ----------
    channel
        Signal, shape [time].
    expected
        Frequencies [Hz] by name, as `BearingOrders.frequencies` returns them.
    low, high
        Ends of the band [Hz]; `most_impulsive_band` finds one.
    harmonics
        Multiples of each.
    search
        Relative half width of the range searched, at least 1.5 lines.

    Returns
    -------
    list of EnvelopeLine
        In the order of the names, multiples after each.

    Raises
    ------
    InputError
        As `envelope_spectrum`, and for frequencies that are not positive.

    Examples
    --------
    >>> t = np.arange(8000) / 8000.0
    >>> shocks = Channel("acc", (1.0 + np.cos(2 * np.pi * 162.0 * t)) * np.cos(2 * np.pi * 3000.0 * t), 8000.0)
    >>> (line,) = envelope_lines(shocks, {"BPFI": 162.2}, 2500.0, 3500.0, harmonics=1)
    >>> line.name, line.frequency, round(line.amplitude, 6)
    ('BPFI', 162.0, 1.0)

    """
    check_count("harmonics", harmonics, 1, 100, "3 is usual")
    check_real("search", search, 1e-9, 0.5, "0.02 is usual")
    spectrum = envelope_spectrum(channel, low, high).spectrum
    found = []
    for name, frequency in expected.items():
        check_positive(f"expected.{name}", frequency, "Hz")
        for k in range(1, harmonics + 1):
            line = _highest(spectrum.frequency, spectrum.values, k * frequency, search, 0.5 * (high - low))
            if line is not None:
                found.append(EnvelopeLine(name if k == 1 else f"{k} {name}", k * frequency, *line))
    return found


def _highest(
    frequency: Floats, values: Floats, expected: float, search: float, limit: float
) -> tuple[float, float, float] | None:
    """Return frequency, amplitude and prominence of the highest value near a frequency; None beyond the limit."""
    resolution = float(frequency[1])
    margin = max(search * expected, 1.5 * resolution)
    if expected + margin > limit:
        return None
    first, last = math.ceil((expected - margin) / resolution), math.floor((expected + margin) / resolution)
    at = max(1, first) + int(np.argmax(values[max(1, first) : last + 1]))
    around = values[max(1, at - 64) : at + 65]
    floor = float(np.median(around))
    return float(frequency[at]), float(values[at]), float(values[at]) / floor if floor > 0.0 else math.inf
