"""A hundred slips of the pen in each table of elements, excitation and environment: keys of other tables, misspelt,
doubled or cut lines.
"""

from collections.abc import Iterator
from dataclasses import dataclass

from hostile.damage import BAD_VALUES, Damaged
from hostile.damage_elements import FIELDS, SOUND

_BASE = SOUND[SOUND.index("[base.acceleration]") : SOUND.index("[rotors.motor]")]
_TERMS = SOUND[SOUND.index("[[rotors.wheel.load.terms]]") : SOUND.index("[[couplings]]")]


def _with_base(table: str) -> str:
    return SOUND.replace(_BASE, f"[base.acceleration]\n{table}\n")


@dataclass(frozen=True)
class Table:
    """A table: the sound file that it stands in, its header, its path, its field lines with the bad values that they take."""

    name: str
    file: str
    header: str
    path: str
    lines: dict[str, frozenset[str]]


NONE: frozenset[str] = frozenset()
SIGNED, HEAT = frozenset(["negative"]), frozenset(["other"])
TABLES = (
    Table(
        "environment", SOUND, "[environment]", "environment",
        {'temperature = "30 degC"': HEAT, 'reference_temperature = "20 degC"': HEAT},
    ),
    Table(
        "housing", SOUND, "[environment.housing]", "environment.housing",
        {'expansion = "23.1e-6 1/K"': NONE, 'temperature = "31 degC"': HEAT},
    ),
    Table(
        "material", SOUND, "[rotors.pinion.material]", "rotors.pinion.material",
        {
            'modulus = "206 GPa"': NONE, "poisson = 0.3": NONE, 'density = "7850 kg/m^3"': NONE,
            'expansion = "11.5e-6 1/K"': NONE,
        },
    ),
    Table(
        "unbalance", SOUND, "[rotors.wheel.unbalance]", "rotors.wheel.unbalance",
        {'amount = "10 g mm"': NONE, 'phase = "30 deg"': SIGNED},
    ),
    Table(
        "terms", SOUND, "[[rotors.wheel.load.terms]]", "rotors.wheel.load.terms.0",
        {'frequency = "40 Hz"': NONE, 'amplitude = "1 N m"': SIGNED, 'phase = "0 deg"': SIGNED},
    ),
    Table(
        "torque table", SOUND.replace(
            _TERMS,
            '[rotors.wheel.load.table]\nvalues = ["0 N m", "1 N m", "2 N m", "1 N m"]\nsampling = "1 kHz"\nstart = "1 ms"\n\n',
        ), "[rotors.wheel.load.table]", "rotors.wheel.load.table",
        {'values = ["0 N m", "1 N m", "2 N m", "1 N m"]': NONE, 'sampling = "1 kHz"': NONE, 'start = "1 ms"': NONE},
    ),
    Table(
        "harmonic base", SOUND, "[base.acceleration]", "base.acceleration",
        {
            'amplitude = "3 m/s^2"': SIGNED, 'frequency = "50 Hz"': NONE, 'phase = "10 deg"': SIGNED,
            'direction = "20 deg"': SIGNED,
        },
    ),
    Table(
        "shock", _with_base('kind = "half-sine"\namplitude = "90 m/s^2"\nduration = "11 ms"\nstart = "2 ms"\ndirection = 0.5\n'),
        "[base.acceleration]", "base.acceleration",
        {'amplitude = "90 m/s^2"': SIGNED, 'duration = "11 ms"': NONE, 'start = "2 ms"': NONE, "direction = 0.5": SIGNED},
    ),
    Table(
        "random vibration", _with_base(
            'kind = "spectral-density"\ndensity = [["20 Hz", 0.5], ["2000 Hz", 0.5]]\nseed = 3\ndirection = 0.5\n'
        ), "[base.acceleration]", "base.acceleration",
        {'density = [["20 Hz", 0.5], ["2000 Hz", 0.5]]': NONE, "seed = 3": NONE, "direction = 0.5": SIGNED},
    ),
    Table(
        "record", _with_base(
            'kind = "record"\nvalues = [0.0, 1.0, -1.0, 0.5, 0.0]\nsampling = "1 kHz"\nstart = 0.0\ndirection = 0.5\n'
        ), "[base.acceleration]", "base.acceleration",
        {"values = [0.0, 1.0, -1.0, 0.5, 0.0]": NONE, 'sampling = "1 kHz"': NONE, "direction = 0.5": SIGNED},
    ),
    Table(
        "mesh friction", SOUND, "[[meshes]]", "meshes.0",
        {"friction_coefficient = 0.08": NONE, 'friction_phase = "12 deg"': SIGNED, 'friction_speed = "2 mm/s"': NONE},
    ),
)  # fmt: skip

KEYS = sorted(
    {line.split(" = ")[0] for line in FIELDS}
    | {"file", "values", "sampling", "density", "seed", "duration", "start"}
)
ODD = (
    "value",
    "unit",
    "colour",
    "x",
    "name",
    "note",
    "comment",
    "enabled",
    "on",
    "gear",
    "teeth",
    "mass",
    "module",
    "load",
)
# What TOML itself refuses, in a field's line.
CUT = {
    "doubled": "{line}\n{line}",
    "no value": "{key} =",
    "no equals sign": "{key} {value}",
    "two values": "{key} = {value} {value}",
    "open text": '{key} = "3',
    "open list": "{key} = [3",
    "colon": "{key}: {value}",
    "comma": "{key} = 3,5",
}
MISSPELT = ("{0}s", "{0}_", "{1}", "the_{0}", "{2}", "{0}_value")


def _valid_keys(table: Table) -> set[str]:
    """Return keys that the table, or another kind of it, knows; they are no slips."""
    known = {line.split(" = ")[0] for line in table.lines}
    if table.path == "base.acceleration":
        known |= {
            "kind",
            "amplitude",
            "frequency",
            "phase",
            "direction",
            "duration",
            "start",
            "density",
            "seed",
            "values",
        }
        known |= {"sampling", "file"}
    if table.name == "terms":
        known |= {"order"}
    if table.name == "torque table":
        known |= {"file"}
    if table.name == "mesh friction":
        known |= {"module", "damping", "stiffness", "phase", "angle", "backlash", "facewidth"}
    return known | ({"housing"} if table.name == "environment" else set())


def slips(table: Table) -> Iterator[Damaged]:
    """Yield the damaged files of one table."""
    file, valid = table.file, _valid_keys(table)
    for key in sorted({*KEYS, *ODD} - valid):
        text = file.replace(f"{table.header}\n", f"{table.header}\n{key} = 1.0\n", 1)
        yield Damaged(f"{table.name}: {key}", text.encode(), (f"{table.path}.{key}", "unknown field"))
    for line, taken in table.lines.items():
        assert f"\n{line}\n" in file, (table.name, line)
        key, value = line.split(" = ", 1)
        for kind, bad in BAD_VALUES.items():
            if kind not in taken:
                text = file.replace(f"\n{line}\n", f"\n{key} = {bad}\n", 1)
                yield Damaged(f"{table.name}.{key}: {kind}", text.encode(), (f"{table.path}.{key}",))
        for kind, written in CUT.items():
            text = file.replace(
                f"\n{line}\n", "\n" + written.format(line=line, key=key, value=value) + "\n", 1
            )
            yield Damaged(f"{table.name}.{key}: {kind}", text.encode(), ("line",))
        for pattern in MISSPELT:
            wrong = pattern.format(key, key.upper(), key[1:])
            text = file.replace(f"\n{line}\n", f"\n{wrong} = {value}\n", 1)
            yield Damaged(f"{table.name}: {wrong} for {key}", text.encode(), (f"{table.path}.{wrong}",))
