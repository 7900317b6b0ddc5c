"""Features by which a record is compared with simulated ones: levels, lines, sidebands, indices, combs of envelopes."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Final

import numpy as np
from numpy.typing import NDArray

from gearplay.diagnosis.machine import Machine
from gearplay.diagnosis.measures import Measures, measured
from gearplay.diagnosis.shaft_speed import FoundSpeed, floor_of
from gearplay.files.record import Channel
from gearplay.results.spectra import amplitude_spectrum

Floats = NDArray[np.float64]

BANDS: Final = 10
"""Bands of equal ratio from half the slowest shaft's turn to `TOP`, whose levels are compared."""
TOP: Final = 0.38
"""Upper end of the bands over the sampling rate: below the corner of an anti-alias filter."""
QUIET: Final = 0.1
"""Share of the spectrum's floor that lies below the background noise."""


def features_of(channel: Channel, machine: Machine, speed: FoundSpeed, *, levels: bool) -> dict[str, float]:
    """Return the features [decades] of a record at the speed of the first shaft; without ``levels`` relative ones alone.

    Where the speed is not known there are none of its lines, gears and teeth in mesh.
    """
    x = channel.values - np.mean(channel.values)
    taken = Channel(channel.name, x, channel.sampling, channel.unit)
    found = measured(taken, machine, speed)
    rms = math.sqrt(float(np.mean(x * x)))
    values = {"level": math.log10(max(rms, 1e-30))} if levels else {}
    return values | _spectrum(taken, machine, speed, rms) | _indices(machine, found)


def _spectrum(channel: Channel, machine: Machine, speed: FoundSpeed, rms: float) -> dict[str, float]:
    """Return the levels of bands and mesh harmonics over that of the whole record."""
    spectrum = amplitude_spectrum(channel.values, channel.sampling)
    power, df = spectrum.amplitude**2, spectrum.resolution
    total = float(np.sum(power))
    if total <= 0.0 or rms <= 0.0:
        return {}
    lowest = max(0.5 * min(shaft.order for shaft in machine.shafts) * speed.frequency, 2.0 * df)
    edges = np.geomspace(lowest, TOP * channel.sampling, BANDS + 1)
    values: dict[str, float] = {}
    for k, (low, high) in enumerate(pairwise(edges.tolist())):
        inside = power[math.ceil(low / df) : math.ceil(high / df)]
        if inside.size:
            values[f"band {k + 1}"] = 0.5 * math.log10(max(float(np.sum(inside)) / total, 1e-12))
    for mesh in machine.meshes if speed.known else ():
        for h in (1, 2, 3):
            every = [round(order * speed.frequency / df) for order in machine.lines_of(mesh, h)]
            if all(3 <= at < min(power.size - 3, TOP * channel.sampling / df) for at in every):
                line = sum(float(np.sum(power[at - 2 : at + 3])) for at in every)
                values[f"{h} x {mesh.name}"] = 0.5 * math.log10(max(line / total, 1e-12))
    return values


def _indices(machine: Machine, found: Measures) -> dict[str, float]:
    values = {
        "impulsive": math.log10(1.0 + max(found.impulsive, 0.0)),
        "mesh period": math.log10(found.waveform),
        "rest": 0.5 * math.log10(max(found.rest_share, 1e-12)),
    }
    for mesh, comb in zip(machine.meshes, found.mesh, strict=True) if found.speed.known else ():
        values[f"comb of {mesh.name}"] = math.log10(1.0 + comb.height)
        values[f"depth at {mesh.name}"] = math.log10(0.01 + comb.depth)
    for k, gear in found.gears.items():
        name = machine.gears[k].name
        values[f"event of {name}"] = math.log10(max(gear.event, 1.0))
        values[f"modulation of {name}"] = math.log10(0.01 + gear.modulation)
        for index in ("fm4", "m6a", "energy_ratio"):
            value = getattr(gear.indicators, index)
            if math.isfinite(value) and value > 0.0:
                values[f"{index} of {name}"] = math.log10(value)
    for (k, part), comb in found.bearings.items():
        values[f"{part} of {machine.bearings[k].name}"] = math.log10(1.0 + comb.height)
    for k, comb in found.events.items():
        values[f"events of {machine.gears[k].name}"] = math.log10(1.0 + comb.height)
    for each, own in zip(machine.sets, found.sets, strict=False):
        values |= {f"{name} of {each.name}": math.log10(0.01 + value) for name, value in own.rows().items()}
    return values


def background(channel: Channel) -> float:
    """Return the standard deviation of white noise as quiet as the quietest tenth of the record's spectrum [unit].

    The spectrum's floor is a median over lines, which tones do not raise; noise of deviation 1 calibrates it.
    """
    unit = np.random.default_rng(0).standard_normal(channel.size)
    return math.sqrt(_quiet(channel.values, channel.sampling) / _quiet(unit, channel.sampling))


def _quiet(values: Floats, sampling: float) -> float:
    spectrum = amplitude_spectrum(values, sampling)
    inside = (spectrum.frequency > 0.02 * sampling) & (spectrum.frequency < 0.35 * sampling)
    return float(np.quantile(floor_of(spectrum.amplitude**2)[inside], QUIET))
