"""Start of commands: what is imported, since that is what a short command waits for."""

import json

import pytest

from gearplay.cli.main import COMMANDS
from programs import run_program

REPORT = """
import json, sys
from gearplay.cli.main import run
words = json.loads(sys.argv[1])
code = run(words)
print(json.dumps({"code": code, "modules": sorted(sys.modules)}))
"""

HEAVY = {
    "numba", "llvmlite", "xarray", "pandas", "matplotlib", "scipy", "pint", "rich", "jinja2", "PIL", "h5py",
    "h5netcdf", "dask", "plotly", "optuna", "gearplay.schema.unit_spellings", "gearplay.pictures.canvas",
    "gearplay.pictures.pages", "gearplay.results.spectra", "gearplay.results.dataset",
    "gearplay.parts.planetary.schema", "gearplay.parts.housing.schema", "gearplay.model.case_table", "gearplay.build",
}  # fmt: skip
"""What neither a run off a terminal nor a check needs."""


def modules_of(*words: str) -> set[str]:
    """Return the modules in a new process after a command that must succeed."""
    done = run_program(REPORT, json.dumps(words))
    found = json.loads(done.stdout.splitlines()[-1])
    assert found["code"] == 0, done.stderr
    return set(found["modules"])


@pytest.mark.slow
@pytest.mark.parametrize(
    "words", [("run", "han2021", "--duration", "10ms"), ("run", "han2021", "--duration", "0.01", "--json")]
)
def test_run_imports_what_it_needs(words: tuple[str, ...]) -> None:
    assert not modules_of(*words) & HEAVY


def test_check_imports_what_it_needs() -> None:
    assert not modules_of("check", "han2021") & HEAVY


def test_a_command_imports_no_other() -> None:
    found = modules_of("check", "external-pair")
    assert {name for name in COMMANDS if f"gearplay.cli.{name}" in found} == {"check"}


def test_help_needs_no_numbers() -> None:
    found = modules_of("--help")
    assert not found & {"numpy", "rich", *HEAVY}
    assert {f"gearplay.cli.{name}" for name in COMMANDS if name != "resume"} <= found
