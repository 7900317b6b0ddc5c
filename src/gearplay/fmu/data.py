"""Data of a case in C: the image of its arrays, the rules of its parameters, its sentences."""

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gearplay.build.header import header
from gearplay.fmu.image import Image
from gearplay.fmu.tuning import Tune, Word, arrays_of
from gearplay.integrate import run as kernel
from gearplay.integrate.stepping import advance_to, change_inputs, observe_now
from gearplay.kernels.layout import System
from gearplay.kernels.signatures import Signed
from gearplay.model.case import Case
from gearplay.model.pack import Packed
from gearplay.solver.status import WORDS
from gearplay.stepping.inputs import Input, hold, own_system
from gearplay.vocabulary.errors import InputError

LOG_ROOM = 64
MOST_BYTES = 1 << 25
"""Largest image [byte]."""
PER_LINE = 6


@dataclass(frozen=True)
class Data:
    """Sources in C by file name, and the digest of their content."""

    texts: dict[str, str]
    digest: str


def make_data(
    case: Case,
    packed: Packed,
    start: NDArray[Any],
    inputs: Sequence[Input],
    places: NDArray[Any],
    tunes: Sequence[Tune],
    identity: str,
) -> Data:
    """Write the data of a case; ``places`` are the columns of its outputs, ``identity`` their names and descriptions.

    Raises `InputError` for a case whose memory is too large.
    """
    system = own_system(packed.system)
    settings = case.run
    run = kernel.make_run(
        system,
        start,
        packed.natural,
        packed.restart_step,
        packed.stops,
        places,
        np.zeros((len(places), 1)),
        2 * system.switches.size + 2 + LOG_ROOM,
        settings.tolerance,
        settings.fixed_step,
        by_stage=settings.fixed_step_contacts == "stage",
        statistics=False,
    )
    held = hold(system, inputs)
    image = Image(system, run, held)
    words = image.words
    if words.nbytes > MOST_BYTES:
        rule = f"must take {MOST_BYTES >> 20} MB at most, and takes {words.nbytes / 2**20:.3g}"
        raise InputError.of(
            "case", f"{len(case.rotors)} rotors", rule, "Shorten its tables, or its record of the base"
        )
    rows = _word_rows(image, packed, system, run, start, inputs, tunes)
    digest = hashlib.sha256(words.tobytes() + repr((rows, image.relocations, identity)).encode()).hexdigest()
    kernels = [
        each if isinstance(each, Signed) else Signed(each)
        for each in (advance_to, change_inputs, observe_now)
    ]
    head = [
        "#ifndef DATA_H",
        "#define DATA_H",
        header(kernels),
        f"#define MODEL_TOKEN {quoted(token_of(digest))}",
        f"#define MODEL_DIGEST 0x{digest[32:48]}u",
        f"enum {{ INPUTS = {len(inputs)}, OUTPUTS = {len(places)}, TUNES = {len(tunes)} }};",
        f"enum {{ IMAGE_WORDS = {words.size}, RELOCATIONS = {len(image.relocations)}, CLOCK_T = {kernel.T} }};",
        f"enum {{ SYSTEM_PLACE = {image.roots[0]}, RUN_PLACE = {image.roots[1]}, HELD_PLACE = {image.roots[2]} }};",
        "struct tune { const char *name; double start, low, high; };",
        "struct word { int tune; size_t place; int kind; double value, slope; };",
        "struct status { int code; const char *words; };",
        "extern const uint64_t case_image[IMAGE_WORDS];",
        "extern const uint32_t relocations[RELOCATIONS];",
        "extern const double input_starts[INPUTS + 1];",
        "extern const struct tune tunes[TUNES + 1];",
        f"extern const struct word words[{len(rows) + 1}];",
        f"extern const struct status statuses[{len(WORDS)}];",
        "#endif",
        "",
    ]
    body = [
        '#include "model.h"',
        f"const uint64_t case_image[IMAGE_WORDS] = {{\n{_listed([f'0x{word:x}u' for word in words.tolist()])}}};",
        f"const uint32_t relocations[RELOCATIONS] = {{\n{_listed(list(map(str, image.relocations)))}}};",
        f"const double input_starts[INPUTS + 1] = {{{', '.join(_double(each.start) for each in inputs)}}};",
        "const struct tune tunes[TUNES + 1] = {",
        *(
            f"    {{{quoted(each.name)}, {_double(each.start)}, {_double(each.low)}, {_double(each.high)}}},"
            for each in tunes
        ),
        "    {0}};",
        f"const struct word words[{len(rows) + 1}] = {{",
        *rows,
        "    {-1}};",
        f"const struct status statuses[{len(WORDS)}] = {{",
        *(f"    {{{int(code)}, {quoted(words_)}}}," for code, words_ in WORDS.items()),
        "};",
        "",
    ]
    return Data({"data.h": "\n".join(head), "data.c": "\n".join(body)}, digest)


def token_of(digest: str) -> str:
    """Return the token of an FMU, as of a GUID."""
    return f"{{{digest[:8]}-{digest[8:12]}-{digest[12:16]}-{digest[16:20]}-{digest[20:32]}}}"


def quoted(text: str) -> str:
    r"""Return any text as a string literal of C.

    >>> quoted('a"b\\n')
    '"a\\042b\\134n"'
    """
    plain = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789 .,:;_-+*/=()[]{}<>|'`^~"
    return (
        '"'
        + "".join(each if each in plain else "".join(f"\\{b:03o}" for b in each.encode()) for each in text)
        + '"'
    )


def _double(value: float) -> str:
    return float(value).hex() if np.isfinite(value) else "INFINITY" if value > 0 else "-INFINITY"


def _listed(items: Sequence[str]) -> str:
    return "".join(f"{', '.join(items[at : at + PER_LINE])},\n" for at in range(0, len(items), PER_LINE))


def _word_rows(
    image: Image,
    packed: Packed,
    system: System,
    run: kernel.Run,
    start: NDArray[Any],
    inputs: Sequence[Input],
    tunes: Sequence[Tune],
) -> list[str]:
    """Return the rows of words that follow parameters, at their places in the image."""
    own = list(arrays_of(replace(packed, system=system), run.y))
    known = list(arrays_of(packed, start))
    rows, taken = [], dict[tuple[int, int], str]()
    for n, tune in enumerate(tunes):
        for word in tune.words:
            at = next(k for k, array in enumerate(known) if array is word.array)
            targets = [own[at]] if at < len(own) - 3 else [run.y, run.y_new, run.y_try]
            for array in targets:
                place = image.place_of(array) + word.offset
                if taken.setdefault((0, place), tune.name) != tune.name:
                    rule = f"must not change what {taken[0, place]} changes, too"
                    raise InputError.of("tune", tune.name, rule, "Leave one of the two out")
                rows.append(_row(n, place, word))
        _refuse_torques(tune, known, inputs)
    return rows


def _refuse_torques(tune: Tune, known: Sequence[NDArray[Any]], inputs: Sequence[Input]) -> None:
    """Refuse a parameter that changes the torque of a rotor, which inputs set anew."""
    rotors = known[0]
    if not inputs or rotors.dtype.fields is None:
        return
    places = {rotors.dtype.fields[name][1] // 8 for name in ("torque", "drive_torque", "inv_inertia")}
    width = rotors.dtype.itemsize // 8
    touched = {
        word.offset // width for word in tune.words if word.array is rotors and word.offset % width in places
    }
    clash = [each.name for each in inputs if each.kind < 2 and each.place in touched]
    if clash:
        rule = f"must not change the inertia or the torque of a rotor with an input, {clash[0]}"
        raise InputError.of("tune", tune.name, rule, "Leave one of the two out")


def _row(tune: int, place: int, word: Word) -> str:
    return f"    {{{tune}, {place}, {word.kind}, {_double(word.value)}, {_double(word.slope)}}},"
