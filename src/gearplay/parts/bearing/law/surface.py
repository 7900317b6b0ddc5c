"""Surface of a rolling bearing: places of the elements, waviness of the rings, dents (docs/theory, section 3).

Rings roll on the elements without slip, so that all of it depends on the relative rotation Delta = theta_rotor - theta_carrier:
with the shares g_a + g_b = 1 of the cage's rotation an element moves by -g_b Delta on the rotor's ring, by g_a Delta on the
carrier's.
"""

import math
from typing import Any

from gearplay.kernels.compiled import compiled_inline

# Two rows of terms for each dent: rate of psi by Delta, psi [rad] at rotation 0 (of element 0 for one of a ring), arc [rad];
# depth [m], its place below or the number of its element, least angle [rad] between two passages.
ROWS = 2
RING_A, RING_B = -1, -2  # of the rotor, of the carrier
# Then, where a broken cage holds elements off their even places, a row for each: offset [rad], cosine and sine of the angle from
# the element before, for element 0 from its even place.
BY_PLACE = -1  # of ``inside``: dents are passed where the state says so


@compiled_inline
def is_uneven(bearing: Any) -> bool:
    """Return whether elements are off their even places, and have rows of terms: then neighbours have no common angle."""
    return bool(bearing.pitch_cosine == 0.0 and bearing.pitch_sine == 0.0)


@compiled_inline
def row_of_element(bearing: Any, k: int) -> int:
    """Return the row of terms of element k, of a bearing with uneven places."""
    return int(bearing.dents + ROWS * bearing.dent_count + k)


@compiled_inline
def element_angle(bearing: Any, terms: Any, k: int) -> float:
    """Return the angle of element k from the cage's [rad], that of the even place of element 0."""
    angle = k * (2.0 * math.pi / bearing.contacts)
    if is_uneven(bearing):
        angle += terms[row_of_element(bearing, k), 0]
    return angle


@compiled_inline
def waviness(terms: Any, first: int, count: int, angle: float) -> tuple[float, float, float]:
    """Return sum A cos(order angle + phase) [m] and its first two derivatives by the angle."""
    height, slope, bend = 0.0, 0.0, 0.0
    for row in range(first, first + count):
        order = terms[row, 0]
        cosine, sine = math.cos(order * angle), math.sin(order * angle)
        wave = terms[row, 1] * cosine - terms[row, 2] * sine
        height += wave
        slope -= order * (terms[row, 1] * sine + terms[row, 2] * cosine)
        bend -= order * order * wave
    return height, slope, bend


@compiled_inline
def ripples(
    bearing: Any, terms: Any, k: int, cage: float, turn_a: float, turn_b: float
) -> tuple[float, float, float]:
    """Return the waviness of both rings at element k [m] and its first two derivatives by Delta."""
    angle = cage + element_angle(bearing, terms, k)
    w_a, slope_a, bend_a = waviness(terms, bearing.waves_a, bearing.count_a, angle - turn_a)
    w_b, slope_b, bend_b = waviness(terms, bearing.waves_b, bearing.count_b, angle - turn_b)
    share_a, share_b = bearing.share_a, bearing.share_b
    slope = share_a * slope_b - share_b * slope_a
    return w_a + w_b, slope, share_a * share_a * bend_b + share_b * share_b * bend_a


@compiled_inline
def wrapped(angle: float, period: float) -> float:
    """Return an angle less whole periods, within half a period of 0."""
    return angle - period * math.floor(angle / period + 0.5)


@compiled_inline
def dents(
    bearing: Any, terms: Any, k: int, relative: float, inside: int
) -> tuple[float, float, float, float]:
    """Return the height of the dents at element k [m], its first two derivatives by Delta, and 1 where there is one.

    -depth cos(pi psi / arc) for |psi| < arc/2, psi the angle from the dent's middle. Bit d of ``inside`` is whether dent d is
    passed: the branch that holds between two events, beyond the dent's ends too; `BY_PLACE` goes by psi itself.
    """
    height, slope, bend, dented = 0.0, 0.0, 0.0, 0.0
    for d in range(bearing.dent_count):
        row = bearing.dents + ROWS * d
        rate, arc, place, period = terms[row, 0], terms[row, 2], int(terms[row + 1, 1]), terms[row + 1, 2]
        psi = rate * relative + terms[row, 1]
        if place >= 0:
            if k != place:
                continue
            psi = wrapped(psi, period)
        else:
            psi = wrapped(psi + element_angle(bearing, terms, k), 2.0 * math.pi)
        if abs(psi) >= 0.5 * (arc if inside == BY_PLACE else period):
            continue
        if inside != BY_PLACE and (inside >> d) & 1 == 0:
            continue
        turn = math.pi / arc
        cosine = terms[row + 1, 0] * math.cos(turn * psi)
        dented = 1.0
        height -= cosine
        slope += terms[row + 1, 0] * math.sin(turn * psi) * turn * rate
        bend += cosine * turn * rate * turn * rate
    return height, slope, bend, dented


@compiled_inline
def beyond_end(bearing: Any, terms: Any, d: int, relative: float) -> float:
    """Return how far [rad] the nearest element is beyond the ends of dent d; negative within."""
    row = bearing.dents + ROWS * d
    psi, nearest = terms[row, 0] * relative + terms[row, 1], 2.0 * math.pi
    if terms[row + 1, 1] >= 0.0 or not is_uneven(bearing):
        nearest = abs(wrapped(psi, terms[row + 1, 2]))
    else:
        for k in range(bearing.contacts):
            nearest = min(nearest, abs(wrapped(psi + element_angle(bearing, terms, k), 2.0 * math.pi)))
    return nearest - 0.5 * terms[row, 2]


@compiled_inline
def passed_dents(bearing: Any, terms: Any, relative: float) -> int:
    """Return the dents that elements are in, a bit for each."""
    inside = 0
    for d in range(bearing.dent_count):
        if beyond_end(bearing, terms, d, relative) < 0.0:
            inside |= 1 << d
    return inside


@compiled_inline
def dent_rate(bearing: Any, terms: Any, relative: float, spin: float) -> float:
    """Return the angular frequency [rad/s] that resolves the dents near an element at a relative speed ``spin`` [rad/s].

    A step of half a radian of it covers half of the way to a dent's end and a quarter of its arc: none is passed over.
    """
    fastest = 0.0
    for d in range(bearing.dent_count):
        row = bearing.dents + ROWS * d
        ahead = max(beyond_end(bearing, terms, d, relative), 0.0)
        fastest = max(fastest, abs(terms[row, 0] * spin) / (ahead + 0.5 * terms[row, 2]))
    return fastest
