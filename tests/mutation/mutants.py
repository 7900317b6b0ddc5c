"""Mutants of the physics: every place where cosmic-ray can change one sign, number, comparison or loop, and a seeded sample."""

import ast
import random
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from cosmic_ray.ast import ast_nodes, get_ast
from cosmic_ray.mutating import mutate_code
from cosmic_ray.plugins import get_operator, operator_names

SOURCE = Path(__file__).resolve().parents[2] / "src" / "gearplay"
NO_PHYSICS = (
    "__init__",
    "arrays",
    "by_address",
    "compiled",
    "compiled_once",
    "from_python",
    "library",
    "signatures",
)
"""Kernels that only say how kernels are compiled."""
MODEL = ["expansion", "initial", "natural_sizes", "pack"]
"""Modules of the model that compute; the others read, check and word."""
ARITHMETIC = ("Add", "Sub", "Mul", "Div")
ORDER = ("Lt", "LtE", "Gt", "GtE", "Eq", "NotEq")
MUTE = (ast.Raise, ast.Assert, ast.JoinedStr, ast.Import, ast.ImportFrom)
SPOKEN = ("Field", "Signal", "Fault", "InputError")
LEFT_OUT = ("RemoveDecorator", "VariableReplacer", "VariableInserter", "ExceptionReplacer")


def _serves(operator: str) -> bool:
    """Return whether an operator makes mistakes that somebody might: no shifts of floats, no `is` of numbers."""
    name = operator.removeprefix("core/")
    if name.startswith("ReplaceBinaryOperator"):
        return name.rsplit("_", 1)[1] in ARITHMETIC
    if name.startswith("ReplaceComparisonOperator"):
        return name.rsplit("_", 1)[1] in ORDER
    if name.startswith("ReplaceUnaryOperator"):
        return name.endswith(("USub_UAdd", "Delete_USub", "Delete_Not"))
    return name not in LEFT_OUT


OPERATORS = [name for name in operator_names() if _serves(name)]
Place = tuple[int, int]


@dataclass(frozen=True)
class Site:
    """One place of one file that can be changed, with the ways to."""

    module: str
    place: Place
    end: Place
    ways: tuple[tuple[str, int], ...]  # operator, its which occurrence in the file


@dataclass(frozen=True)
class Mutant:
    """One change."""

    module: str
    line: int
    operator: str
    occurrence: int
    before: str
    after: str

    @property
    def name(self) -> str:
        """Name a mutant by what it changes, so that it is known again when lines move."""
        return f"{self.module}: {self.before} -> {self.after}"

    def text(self) -> str:
        """Return the changed file."""
        code = (SOURCE / self.module).read_text(encoding="utf-8")
        changed = str(mutate_code(code, get_operator(self.operator)(), self.occurrence))
        return changed.replace(" in []:", " in range(0):")  # an empty list has no type that compiles


def modules() -> list[str]:
    """Return the files of the physics, below the package."""
    rooms = [
        file for room in ("kernels", "integrate", "parts") for file in sorted((SOURCE / room).rglob("*.py"))
    ]
    kernels = [file for file in rooms if file.stem not in NO_PHYSICS and not file.stem.startswith("check_")]
    return [
        f.relative_to(SOURCE).as_posix() for f in [*kernels, *(SOURCE / "model" / f"{m}.py" for m in MODEL)]
    ]


def _quiet(tree: ast.AST) -> Iterator[ast.AST]:
    """Yield what states no physics: type hints, messages, names and units of signals, bounds of fields."""
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef):
            yield from node.decorator_list
            yield from (hint for hint in (node.returns,) if hint)
        elif (isinstance(node, ast.arg) and node.annotation) or isinstance(node, ast.AnnAssign):
            yield node.annotation
        elif isinstance(node, MUTE) or getattr(getattr(node, "func", None), "id", "") in SPOKEN:
            yield node


def sites(module: str) -> list[Site]:
    """Return the places of a file that can be changed."""
    code = (SOURCE / module).read_text(encoding="utf-8")
    quiet = [
        ((node.lineno, node.col_offset), (node.end_lineno, node.end_col_offset))
        for node in _quiet(ast.parse(code))
        if hasattr(node, "lineno")
    ]
    tree = get_ast(code)
    found: dict[tuple[str, Place, Place], list[tuple[str, int]]] = {}
    for name in OPERATORS:
        operator = get_operator(name)()
        places = (each for node in ast_nodes(tree) for each in operator.mutation_positions(node))
        for occurrence, (begin, end) in enumerate(places):
            if not any(first <= begin and end <= last for first, last in quiet):
                family = name.split("_")[0]
                found.setdefault((family, begin, end), []).append((name, occurrence))
    return [Site(module, begin, end, tuple(ways)) for (_, begin, end), ways in sorted(found.items())]


def mutant(module: str, operator: str, occurrence: int, line: int) -> Mutant:
    """Return a mutant with the lines that it changes."""
    old = (SOURCE / module).read_text(encoding="utf-8").splitlines()
    blank = Mutant(module, line, operator, occurrence, "", "")
    new = blank.text().splitlines()
    changed = [k for k in range(len(old)) if k >= len(new) or old[k] != new[k]]
    at = changed[0] if changed else line - 1
    return Mutant(module, at + 1, operator, occurrence, old[at].strip(), " ".join(new[at].split()))


def draw(count: int, seed: int) -> tuple[list[Mutant], dict[str, int]]:
    """Draw places without repetition, every place of the physics alike, and one change of each; return them and all there are."""
    every = [site for module in modules() for site in sites(module)]
    numbers = random.Random(seed)
    counts: dict[str, int] = {}
    for site in every:
        counts[site.module] = counts.get(site.module, 0) + 1
    drawn = []
    for _ in range(count):
        site = every.pop(numbers.randrange(len(every)))  # so that more mutants begin with the same ones
        operator, occurrence = numbers.choice(site.ways)
        drawn.append(mutant(site.module, operator, occurrence, site.place[0]))
    return drawn, counts
