"""Bytes of a REXS file, from disk or from a zip archive, within limits; its form by its content."""

import io
import stat
import zipfile
import zlib
from pathlib import Path
from typing import Final

from gearplay.rexs.json_form import read_json
from gearplay.rexs.records import Gearbox, refused
from gearplay.rexs.xml_form import read_xml
from gearplay.vocabulary.errors import InputError, shorten

LARGEST: Final = 64 * 1024 * 1024
"""Largest file, and largest member of an archive when unpacked [bytes]."""
MOST_MEMBERS: Final = 1000
"""Most members of an archive."""
ENDINGS: Final = (".rexs", ".rexsj", ".xml", ".json")


def read_gearbox(path: Path) -> Gearbox:
    """Read a file: XML, JSON, or a zip archive with one of the two; its content decides, not its name.

    Raises `InputError` for a file that is missing, too large, damaged or no REXS model.
    """
    content = _bytes_of(path)
    if content.startswith(b"PK"):
        content = _unpacked(content)
    start = content.removeprefix(b"\xef\xbb\xbf").lstrip()[:1]
    if start == b"{":
        return read_json(content)
    if start == b"<" or content[:2] in (b"\xff\xfe", b"\xfe\xff"):
        return read_xml(content)
    raise refused(
        "file", "must be a REXS model: XML, JSON, or a zip archive with one of them", "Export it again"
    )


def _bytes_of(path: Path) -> bytes:
    where = shorten(str(path))
    try:
        if not stat.S_ISREG(path.stat().st_mode):
            raise InputError.of("file", where, "must be a regular file", "Name the REXS file")
        with path.open("rb") as file:
            content = file.read(LARGEST + 1)
    except FileNotFoundError:
        raise InputError.of("file", where, "no such file", "Check the path and the current folder") from None
    except (OSError, ValueError) as error:  # ValueError: a null character in the path
        reason = getattr(error, "strerror", None) or "not a valid path"
        raise InputError.of("file", where, f"cannot be read: {reason}", "Check the path") from None
    _check_size(len(content))
    return content


def _check_size(size: int) -> None:
    if size > LARGEST:
        rule = f"must have at most {LARGEST // 1024**2} MiB, unpacked too"
        raise refused("file", rule, "Export the model without results and finite elements")


def _unpacked(content: bytes) -> bytes:
    """Return the one REXS model of an archive, unpacked no further than the limit."""
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            members = archive.infolist()
            models = [
                member
                for member in members
                if member.filename.lower().endswith(ENDINGS)
                and not Path(member.filename).name.startswith(".")
            ]
            if len(members) > MOST_MEMBERS or len(models) != 1:
                rule = f"must have one member that ends in {', '.join(ENDINGS)}; it has {len(models)} among {len(members)}"
                raise refused(
                    "archive", rule, "Export the model again, or unpack it and name the model itself"
                )
            with archive.open(models[0]) as member:
                unpacked = member.read(LARGEST + 1)
    except (zipfile.BadZipFile, zlib.error, EOFError, NotImplementedError, RuntimeError, OSError, ValueError):
        raise refused(
            "archive", "is damaged, encrypted or of an unknown kind", "Pack the model again as zip"
        ) from None
    _check_size(len(unpacked))
    return unpacked
