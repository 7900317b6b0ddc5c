"""The table of published numbers: values as printed, tolerances, sources, and the functions that compute ours.

Where a source prints an equation but no number, the number is of another program that solves it: "recomputed independently".
Tolerances are half a unit of the last printed digit, unless the source rounded before.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final

from gearplay.validation import motions, pairs


@dataclass(frozen=True)
class Number:
    """A number as published, in its unit, and the largest deviation that is accepted."""

    name: str
    value: float
    unit: str
    tolerance: float


@dataclass(frozen=True)
class Comparison:
    """Numbers of one source, and the function that returns ours in the same order and units."""

    topic: str
    title: str
    source: str
    numbers: tuple[Number, ...]
    measure: Callable[[], Sequence[float]]


KHK: Final = "KHK, Gear Technical Reference, profile-shifted gears"
NREL: Final = "NREL 5 MW gearbox, A. R. Nejad et al., Wind Energ. Sci. 1 (2016) 79"
FVA: Final = "REXS examples of FVA: planetary stage, two-stage industrial gearbox"
INDEPENDENT: Final = "; recomputed independently"
"""Marks numbers of another program."""
LIN_PARKER: Final = "J. Lin, R. G. Parker, J. Vib. Acoust. 121 (1999) 319"
COOLEY_PARKER: Final = "C. G. Cooley, R. G. Parker, 2012"
YI: Final = "parameters of Yi et al. 2019" + INDEPENDENT
FRISWELL: Final = "M. I. Friswell et al., Dynamics of Rotating Machines, 2010, by openTorsion's tests"
PLANETARY: Final = "planetary set 17/37/91 of the literature"


def _numbers(unit: str, tolerance: float, named: dict[str, float]) -> tuple[Number, ...]:
    return tuple(Number(name, value, unit, tolerance) for name, value in named.items())


def _relative(unit: str, share: float, words: str, values: Sequence[float]) -> tuple[Number, ...]:
    """Return numbered values whose tolerance is a share of each."""
    return tuple(
        Number(f"{words} {k}", value, unit, max(share * value, 1e-9)) for k, value in enumerate(values, 1)
    )


def _stage(teeth: str, ratio: float, angle: float, stiffness: float) -> tuple[Number, ...]:
    return (
        Number(f"{teeth}: contact ratio", ratio, "1", 5.1e-6),
        Number(f"{teeth}: working pressure angle", angle, "deg", 5.1e-5),
        Number(f"{teeth}: theoretical single stiffness", stiffness, "N/(mm um)", 5.1e-5),
    )


def _distances() -> tuple[Number, ...]:
    table = {
        "external": (
            ("-0.2", 1.720533, 19.802040, -136.160), ("0", 1.670776, 20.0, 0.0), ("+0.1", 1.646074, 20.098095, 68.565),
            ("+0.4", 1.572651, 20.388942, 276.176),
        ),
        "internal": (
            ("-0.2", 1.899665, 19.601659, 135.506), ("0", 1.936972, 20.0, 0.0), ("+0.1", 1.936972, 20.195611, -68.725),
            ("+0.4", 1.936972, 20.769022, -278.691),
        ),
    }  # fmt: skip
    return tuple(
        Number(f"{kind}, {apart} mm: {name}", value, unit, tolerance)
        for kind, rows in table.items()
        for apart, *values in rows
        for name, value, unit, tolerance in zip(
            ("contact ratio", "working angle", "backlash"),
            values,
            ("1", "deg", "um"),
            (5.1e-7, 5.1e-7, 5.1e-4),
            strict=True,
        )
    )


def _allowances() -> tuple[Number, ...]:
    table = {
        "17/22": (149.495, 197.335, 245.191),
        "22/61 internal": (69.606, 98.668, 127.715),
        "27/51": (199.347, 263.115, 326.894),
        "23/34": (199.296, 263.110, 326.937),
    }
    return tuple(
        Number(f"{teeth}: {words}", value, "um", 5.1e-4)
        for teeth, values in table.items()
        for words, value in zip(("least", "middle", "largest"), values, strict=True)
    )


def _shares(table: dict[float, tuple[float, float]]) -> tuple[Number, ...]:
    """Return deflection and share of the leading pair by the place of the entering one [pitches from the start of the path]."""
    return tuple(
        number
        for place, (deflection, share) in table.items()
        for number in (
            Number(f"entering pair at {place:g} pitches: deflection", deflection, "um", 5e-3),
            Number(f"entering pair at {place:g} pitches: share of the leading pair", share, "1", 3e-4),
        )
    )


THREE_PLANETS: Final = (
    (1475.7, 1930.3, 2658.3, 7462.8, 11775.3),
    (743.2, 1102.4, 1896.0, 2276.4, 6986.3, 9647.9),
)
FOUR_PLANETS: Final = (
    (1536.6, 1970.6, 2625.7, 7773.6, 13071.1),
    (727.0, 1091.0, 1892.8, 2342.5, 7189.9, 10437.6),
    (1808.2, 5963.8, 6981.7),
)
COOLEY: Final = ((0.9296, 1.090, 1.358, 1.931, 5.566, 7.741), (0.7432, 1.018, 1.265, 1.487, 4.976, 6.282))
KINDS: Final = ("rotational mode", "translational mode", "planet mode")


def _modes(unit: str, kinds: Sequence[Sequence[float]]) -> tuple[Number, ...]:
    return sum(
        (_relative(unit, 1e-3, words, values) for words, values in zip(KINDS, kinds, strict=False)), ()
    )


COMPARISONS: Final = (
    Comparison("Geometry", "12/24, m 3 mm, x 0.6/0.36", KHK, (
        Number("working pressure angle", 26.0886, "deg", 5.1e-5),
        Number("centre distance", 56.4999, "mm", 5.1e-5),
        Number("base diameter, 12 teeth", 33.8289, "mm", 5.1e-5),
        Number("base diameter, 24 teeth", 67.6579, "mm", 5.1e-5),
        Number("working pitch diameter, 12 teeth", 37.667, "mm", 5.1e-4),
        Number("working pitch diameter, 24 teeth", 75.333, "mm", 5.1e-4),
        Number("contact ratio", 1.202, "1", 5.1e-4),
    ), pairs.external_with_shift),
    Comparison("Geometry", "16/24 internal, m 3 mm, x 0/0.5", KHK, (
        Number("working pressure angle", 31.0937, "deg", 1.1e-4),
        Number("centre distance", 13.1683, "mm", 5.1e-5),
    ), pairs.internal_with_shift),
    Comparison("Geometry", "spur stages 19/17 and 18/36", NREL, (
        *_stage("19/17", 1.11470, 28.1175, 18.8292), *_stage("18/36", 1.37040, 24.1695, 18.1988),
    ), pairs.wind_gearbox),
    Comparison("Geometry", "centre distances of four pairs", FVA, _numbers("mm", 1e-5, {
        "17/22": 78.0, "22/61 internal": 78.0, "27/51": 190.0, "23/34": 190.0,
    }), pairs.printed_distances),
    Comparison("Geometry", "20/60, m 4 mm, centres moved", "involute geometry" + INDEPENDENT, _distances(),
               pairs.over_the_distance),
    Comparison("Geometry", "17/37/91", PLANETARY, _numbers("1", 5.1e-5, {
        "contact ratio, sun and planet": 1.6064, "contact ratio, planet and ring": 1.9418,
    }), pairs.planetary_contact_ratios),
    Comparison("Backlash", "c25 and js7", "DIN 3967, DIN 3964; pairs of the " + FVA + INDEPENDENT, _allowances(),
               pairs.backlash_from_allowances),
    Comparison("Stiffness", "single stiffness, 20/60", "ISO 6336-1 method B" + INDEPENDENT, _numbers("N/(mm um)", 5e-5, {
        "rack of 14.5 deg": 11.705787, "rack of 20 deg": 13.152570, "rack of 22.5 deg": 13.810198, "rack of 25 deg": 14.467827,
        "in a ring": 14.180400,
    }), pairs.iso_single_stiffness),
    Comparison("Stiffness", "potential energy", "ROSS 3.1 (62/62: contact ratio); Sainsot et al. 2004" + INDEPENDENT, (
        Number("62/62: contact ratio", 1.789780, "1", 5.1e-7), Number("62/62: one pair", 12.01787, "N/(mm um)", 1e-4),
        Number("20/60: contact ratio", 1.670776, "1", 5.1e-7), Number("20/60: one pair", 12.22161, "N/(mm um)", 1e-4),
        Number("23/34: contact ratio", 1.543753, "1", 5.1e-7), Number("23/34: one pair", 13.62255, "N/(mm um)", 1e-4),
    ), pairs.potential_energy),
    Comparison("Load sharing", "20/60, 10 mm wide, at rest under 2 kN", "ISO 6336-1, one parabola over the path" + INDEPENDENT, (
        *_shares({-0.05: (13.646891, 0.892372), 0: (9.012647, 0.585768), 0.2: (8.598573, 0.533032), 0.69: (9.297392, 0.394153)}),
        Number("entering pair at 0.8 pitches: deflection", 15.214375, "um", 1e-3),
        Number("entering pair at 0.8 pitches: share of the leading pair", 0.0, "1", 1e-9),
        Number("swing over a pitch, 500 N", 1.700907, "um", 1e-3), Number("swing over a pitch, 2 kN", 6.755947, "um", 5e-3),
        Number("swing over a pitch, 8 kN", 26.787499, "um", 1e-2),
    ), pairs.load_sharing),
    Comparison("Frequencies", "planetary set, 3 planets", LIN_PARKER, _modes("Hz", THREE_PLANETS), motions.three_planets),
    Comparison("Frequencies", "planetary set, 4 planets", LIN_PARKER, _modes("Hz", FOUR_PLANETS), motions.four_planets),
    Comparison("Frequencies", "planetary set, carrier held", COOLEY_PARKER, _modes("1", COOLEY), motions.cooley_parker),
    Comparison("Frequencies", "pair 20/20 in bearings", YI, (
        *_relative("Hz", 1e-4, "mode", (482.93, 620.92, 620.92, 620.92, 3239.40)),
        Number("torsional, centres held", 2519.46, "Hz", 0.25),
    ), motions.pair_in_bearings),
    Comparison("Frequencies", "geared pair with two discs", FRISWELL, _numbers("Hz", 0.051, {
        "mode 1": 425.4, "mode 2": 634.1, "mode 3": 3247.2,
    }), motions.geared_pair),
    Comparison("Frequencies", "five discs, example 9.7.1", FRISWELL, _numbers("Hz", 0.0051, {
        "mode 1": 81.21, "mode 2": 141.21, "mode 3": 378.95, "mode 4": 536.36,
    }), motions.five_discs),
    Comparison("Frequencies", "branched train, example 9.6.3", FRISWELL, _numbers("Hz", 0.00051, {
        "mode 1": 10.304, "mode 2": 20.479, "mode 3": 24.423,
    }), motions.branched_train),
    Comparison("Frequencies", "wind turbine", "openTorsion, notebook of modal analysis", (
        Number("mode 1", 58.34, "rad/s", 0.0051), Number("mode 2", 1034.115, "rad/s", 0.0032),
    ), motions.wind_turbine),
    Comparison("Events", "17/37/91, sun at 800 rpm", PLANETARY, (
        Number("mesh frequency", 190.988, "Hz", 5.1e-4), Number("between contacts of a sun tooth", 0.029670, "s", 5.1e-7),
        Number("between contacts of a planet's flank", 0.193730, "s", 5.1e-7),
    ), motions.planetary_events),
    Comparison("Bearings", "ER-10K, orders of the shaft", "pure rolling: 8 balls of 0.3125 in, pitch diameter 1.319 in",
               _numbers("1", 5.1e-5, {"FTF": 0.38154, "BPFO": 3.0523, "BPFI": 4.9477, "BSF": 1.9919}), motions.bearing_orders),
    Comparison("Bearings", "6205, orders of the shaft", "Case Western Reserve University, bearing data center", (
        Number("cage", 0.39828, "1", 5.1e-5), Number("outer ring", 3.5848, "1", 5.1e-5),
        Number("inner ring", 5.4152, "1", 5.1e-5),
        Number("rolling element, both rings", 4.7135, "1", 1.1e-4),
    ), motions.deep_groove_orders),
    Comparison("Bearings", "clearance of a bore of 25 mm", "ISO 5753-1", _numbers("um", 1e-6, {
        "CN, least": 5.0, "CN, largest": 20.0, "C3, least": 13.0, "C3, largest": 28.0,
    }), motions.clearance_classes),
    Comparison("Bearings", "displacement of 8 balls under 100 N", "sums of Hertzian loads over the balls" + INDEPENDENT,
               _numbers("um", 5.1e-5, {
        "play 0, ball under the load": 2.5500, "play 0, between balls": 2.5676, "play 5 um, ball under the load": 8.3855,
        "play 5 um, between balls": 8.1652, "play 20 um, ball under the load": 23.8303, "play 20 um, between balls": 24.4011,
    }), motions.bearing_statics),
    Comparison("Temperature", "steel gears at 80 mm in aluminium, +100 K", "involute geometry, in closed form", (
        Number("growth of the backlash", 63.75, "um", 0.051),
    ), motions.warm_housing),
)  # fmt: skip
