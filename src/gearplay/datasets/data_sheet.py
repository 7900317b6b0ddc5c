"""Data sheet of a data set: what was drawn, how it was recorded and split, how to read it."""

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from gearplay.datasets.evaluate import Dataset
from gearplay.results.outcomes import Account
from gearplay.sweeps.plans.design import Random, Varied
from gearplay.vocabulary.version import VERSION

READ: Mapping[str, str] = {
    "npy": 'x = np.stack([np.load(path)[0] for path in table["path"]])',
    "hdf5": 'x = np.stack([gp.read_measurement(path).channels[0].values for path in table["path"]])',
    "wav": 'x = np.stack([gp.read_measurement(path).channels[0].values for path in table["path"]])',
    "mat": 'x = np.stack([gp.read_measurement(path).channels[0].values for path in table["path"]])',
}
"""The line that reads the first channel of all records, shape [record, time], by format."""
TABLE = 'table = np.genfromtxt("labels.csv", delimiter=",", names=True, dtype=None, encoding="utf-8")'
WORDS: Mapping[str, str] = {
    "record": "number of the record",
    "path": "its file, empty where it failed",
    "label": "class",
    "split": "train, validation or test; a group is in one of them",
    "group": "records that belong together: of one machine or one condition",
    "machine": "point of the design",
    "member": "record of the same machine and condition, with a start and noise of its own",
}


def sheet_of(made: Dataset, table: Sequence[Mapping[str, Any]]) -> str:
    """Return the data sheet as Markdown; ``table`` has the rows of labels."""
    return "\n".join(_lines(made, table)) + "\n"


def _lines(made: Dataset, table: Sequence[Mapping[str, Any]]) -> Iterator[str]:
    plan, recipe = made.plan, made.recipe
    account = Account.of([row["status"] for row in table], [row["reason"] for row in table])
    collector = recipe.rig.collector
    duration = collector.duration or recipe.base.run.duration
    yield f"# {plan.title or 'Data set'}"
    yield ""
    counted = str(account).replace("case", "record", 1)
    yield f"{counted}. Simulated by gearplay {VERSION}; the whole plan is `plan.json`."
    yield ""
    yield "## Records"
    yield ""
    channels = [f"`{name}`" for name in made.channels]
    yield (
        f"Each is {duration:g} s at {collector.sampling:g} Hz of {', '.join(channels)}, through the sensors, the filter "
        f"and the {collector.bits}-bit converter of the rig. "
        + (
            "Files are NumPy arrays, float32, shape [channel, time]."
            if plan.format == "npy"
            else f"Files are {plan.format}."
        )
    )
    yield ""
    yield f"Case: {recipe.base.title or 'untitled'}, SHA-256 `{recipe.base.sha256}`; rig `{recipe.rig.sha256}`."
    yield ""
    yield "```python"
    yield "import numpy as np"
    if plan.format != "npy":
        yield "import gearplay as gp"
    yield ""
    yield TABLE
    yield 'table = table[table["status"] == 0]'
    yield READ[plan.format]
    yield "```"
    yield ""
    yield "## Labels and split"
    yield ""
    yield f"A group is a {'machine' if recipe.by_machine else 'condition'}; no group is in two parts, so that a learner"
    yield "is tested with groups that it has not seen."
    yield ""
    parts = list(plan.split.shares)
    counts = Counter((row["label"], row["split"]) for row in table if row["status"] == 0)
    yield f"| label | changes of the case | {' | '.join(parts)} |"
    yield f"|---|---|{'---|' * len(parts)}"
    for each in plan.classes:
        sizes = " | ".join(str(counts[each.label, part]) for part in parts)
        drawn_here = [parameter.path for parameter in each.draws]
        said = [f"{path} = {value}" for path, value in _fields(each.set) if path not in drawn_here]
        changes = ", ".join(said + [f"{path} drawn" for path in drawn_here]) or "none"
        yield f"| `{each.label}` | {_cell(changes)} | {sizes} |"
    yield ""
    yield "## Columns of `labels.csv`"
    yield ""
    yield "| column | unit | meaning | least | largest |"
    yield "|---|---|---|---|---|"
    for name, words in WORDS.items():
        yield f"| `{name}` | | {words} | | |"
    units, drawn = recipe.columns(), dict(_how(made))
    for name, unit in units.items():
        values = [row[name] for row in table if name in row]
        yield f"| `{name}` | {unit} | {_cell(drawn[name])} | {_least(values, min)} | {_least(values, max)} |"
    of = " of each sensor" if len(made.sensors) > 1 else ""
    yield f"| `rms`, `peak` | m/s^2 | rms and largest magnitude of what is recorded{of} | | |"
    yield f"| `saturated`, `clipped` | 1 | share of samples beyond the range of sensor, of converter{of} | | |"
    yield "| `status`, `reason` | | 0, or 1 with the reason where it failed | | |"


def _fields(changes: Mapping[str, Any]) -> Iterator[tuple[str, Any]]:
    """Yield the path and value of every field of some changes, those of tables too."""
    for path, value in changes.items():
        if isinstance(value, Mapping):
            yield from ((f"{path}.{name}", each) for name, each in _fields(value))
        else:
            yield path, value


def _how(made: Dataset) -> Iterator[tuple[str, str]]:
    """Yield how each varied value comes about, by its name."""
    plan = made.plan
    for axis in plan.axes:
        yield axis.name, f"axis {_paths(axis)}"
    for p in plan.design.parameters if plan.design else ():
        yield p.name, f"per machine, {p.distribution}: {_paths(p)}"
    for p in plan.draws:
        yield p.name, f"per record, {p.distribution}: {_paths(p)}"
    labels: dict[str, list[str]] = {}
    last: dict[str, Random] = {}
    for each in plan.classes:
        for p in each.draws:
            labels.setdefault(p.name, []).append(each.label)
            last[p.name] = p
    for name, among in labels.items():
        yield name, f"per record of {', '.join(among)}, {last[name].distribution}: {_paths(last[name])}"


def _paths(varied: Varied) -> str:
    times = " (factor)" if varied.mode == "scale" else ""
    return ", ".join(f"`{path}`" for path in (varied.path, *varied.also)) + times


def _least(values: Sequence[Any], of: Any) -> str:
    numbers = [value for value in values if isinstance(value, (int, float)) and np.isfinite(value)]
    return f"{of(numbers):.6g}" if numbers else ""


def _cell(text: str) -> str:
    """Return a text for a cell of a table."""
    return text.replace("|", "\\|").replace("\n", " ")
