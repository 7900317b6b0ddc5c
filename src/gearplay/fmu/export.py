"""`export_fmu`: a case as an FMU."""

import io
import os
import re
import zipfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Final

from gearplay.build.targets import host
from gearplay.files.atomic import check_new, write_with
from gearplay.fmu.data import make_data, token_of
from gearplay.fmu.description import INPUT, OUTPUT, PARAMETER, TIME, Model, Variable, describe
from gearplay.fmu.linking import PLATFORMS, SOURCES, link_fmu, platform
from gearplay.fmu.tuning import Tune, find_tunes
from gearplay.model.initial import member_state
from gearplay.model.pack import pack
from gearplay.model.reading import Source, load_case
from gearplay.model.variables import VARIABLES
from gearplay.solver.trajectory import Column
from gearplay.stepping.inputs import Input, find_inputs, find_outputs
from gearplay.vocabulary.errors import InputError

ENDING: Final = ".fmu"
DATE: Final = (1980, 1, 1, 0, 0, 0)
"""Date of the files within, so that the same case gives the same bytes."""
PLACE: Final = "extra/gearplay"
"""Folder of the sources in C."""


def export_fmu(
    case: Source,
    path: str | os.PathLike[str],
    *,
    inputs: Sequence[str] = (),
    outputs: Sequence[str] = (),
    tune: Sequence[str] = (),
    fmi: int = 3,
    platforms: Sequence[str] | None = None,
    member: int = 0,
    overwrite: bool = False,
) -> Path:
    """Write a case as an FMU for co-simulation: compiled code of several platforms that needs no Python.

    Its steps, events and numbers are those of `Stepper`. Time 0 of the motion is the start of the master's simulation.

    Parameters
    ----------
    case
        A `Case`, a bundled name, a path or a table.
    path
        The file, ``drive.fmu``.
    inputs, outputs
        As of `Stepper`: ``pinion.drive.torque``, ``ring.omega``.
    tune
        Fields of the case that become parameters, set before the end of initialisation to values between a half and twice that
        of the case: ``meshes.0.backlash``.
    fmi
        3 or 2, of FMI 3.0 and 2.0.
    platforms
        Of ``linux64``, ``win64``, ``aarch64-linux``; this one if not given. Others are linked by zig (``pip install ziglang``).
    member
        Member of the ensemble whose start it is: the first starts as the case says, others are drawn.
    overwrite
        Whether an existing file is replaced.

    Returns
    -------
    pathlib.Path
        The file.

    Raises
    ------
    InputError
        For names that are no inputs, signals, parameters or platforms, and for a file that cannot be written.
    GearplayError
        Where a library cannot be compiled or linked.

    Examples
    --------
    >>> import tempfile, gearplay as gp
    >>> place = tempfile.mkdtemp() + "/drive.fmu"
    >>> gp.export_fmu("han2021", place, outputs=["ring.theta", "ring.omega"]).name
    'drive.fmu'

    """
    file = Path(path)
    if file.suffix != ENDING:
        raise InputError.of(
            "out", file.name, f"must end in {ENDING}", f"Write {file.stem or 'drive'}{ENDING}"
        )
    check_new(file, overwrite=overwrite)
    chosen = [platform(name) for name in (_own_platform() if platforms is None else dict.fromkeys(platforms))]
    if not chosen:
        raise InputError.of("platforms", [], f"must be some of {', '.join(PLATFORMS)}", "Name one")
    case = load_case(case)
    packed = pack(case)
    start = member_state(case, packed, member)
    given = find_inputs(case, packed, list(inputs))
    columns, places = find_outputs(packed, outputs)
    tunes = find_tunes(case, packed, start, member, list(tune))
    identifier = _identifier(file.stem)
    variables = _variables(given, columns, tunes)
    data = make_data(case, packed, start, given, places, tunes, repr((identifier, variables, fmi)))
    model = Model(
        name=case.title or identifier,
        identifier=identifier,
        token=token_of(data.digest),
        description=f"{case.title or identifier}, simulated by gearplay",
        variables=variables,
        duration=case.run.duration,
        tolerance=case.run.tolerance,
    )
    parts: dict[str, bytes] = {"modelDescription.xml": describe(model, fmi)}
    for each in chosen:
        folder = each.folder_2 if fmi == 2 else each.folder_3
        library = link_fmu(each.target, fmi, data.texts, identifier, each.suffix)
        parts[f"binaries/{folder}/{identifier}{each.suffix}"] = library
    for name in ("model.h", "model.c", "common.h", f"fmi{fmi}.h", f"fmi{fmi}.c"):
        parts[f"{PLACE}/{name}"] = (SOURCES / name).read_bytes()
    parts |= {f"{PLACE}/{name}": text.encode("ascii") for name, text in data.texts.items()}
    content = _zipped(parts)
    write_with(file, lambda place: place.write_bytes(content), overwrite=overwrite)
    return file


def _own_platform() -> list[str]:
    """Return the name of this platform."""
    found = [name for name, each in PLATFORMS.items() if each.target == host()]
    if not found:
        rule = f"must be given where this platform ({host()}) is none of {', '.join(PLATFORMS)}"
        raise InputError.of("platforms", None, rule, "Name some of them")
    return found


def _identifier(stem: str) -> str:
    """Return the name of the libraries, an identifier of C, from that of the file.

    >>> _identifier("two-stage reducer"), _identifier("2021")
    ('two_stage_reducer', '_2021')
    """
    found = re.sub(r"[^A-Za-z0-9_]", "_", stem)[:60]
    return found if found[:1].isalpha() else f"_{found}"


def _variables(
    inputs: Sequence[Input], columns: Sequence[Column], tunes: Sequence[Tune]
) -> tuple[Variable, ...]:
    """Return the variables in the order of their references: time, inputs, outputs, parameters.

    Raises `InputError` where two have one name.
    """
    found = [Variable("time", 0, TIME, "s", "time of the simulation")]
    for each in inputs:
        found.append(Variable(each.name, len(found), INPUT, each.unit, each.description, each.start))
    for column in columns:
        quantity = next(q for q in VARIABLES[column.dimension] if q.name == column.signal)
        display = None
        if quantity.display_unit != quantity.unit:
            display = (quantity.display_unit, quantity.display_factor)
        name, about = f"{column.label}.{column.signal}", f"{quantity.long_name} of {column.label}"
        found.append(Variable(name, len(found), OUTPUT, quantity.unit, about, display=display))
    for tune in tunes:
        about = f"{tune.name} of the case"
        found.append(
            Variable(tune.name, len(found), PARAMETER, tune.unit, about, tune.start, tune.low, tune.high)
        )
    names = [each.name for each in found]
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise InputError.of("outputs", twice[0], "must have a name of its own", "Leave one of the two out")
    return tuple(found)


def _zipped(parts: dict[str, bytes]) -> bytes:
    held = io.BytesIO()
    with zipfile.ZipFile(held, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in parts.items():
            about: Any = zipfile.ZipInfo(name, DATE)
            about.compress_type, about.external_attr = zipfile.ZIP_DEFLATED, 0o644 << 16
            archive.writestr(about, content)
    return held.getvalue()
