"""The binary form of results on the wire and on disk: a JSON head, then numbers as 32-bit floats.

``4 bytes length of the head, little-endian | head, UTF-8 JSON padded with spaces to 4 bytes | float32 ...``. In the head each
array stands as ``{"at": first float, "shape": [...]}``.
"""

import io
import json
import math
import struct
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray


def pack_frame(document: dict[str, Any]) -> bytes:
    """Return a document with arrays, anywhere in it, as one frame.

    >>> unpack_frame(pack_frame({"a": 1, "x": [np.array([1.0, 2.0])]}))
    {'a': 1, 'x': [array([1., 2.], dtype=float32)]}
    """
    arrays: list[NDArray[np.float32]] = []
    place = 0

    def flat(value: Any) -> Any:
        nonlocal place
        if isinstance(value, np.ndarray):
            numbers = np.ascontiguousarray(value, dtype="<f4")
            arrays.append(numbers.ravel())
            place += numbers.size
            return {"at": place - numbers.size, "shape": list(numbers.shape)}
        if isinstance(value, dict):
            return {str(key): flat(item) for key, item in value.items()}
        if isinstance(value, (list, tuple)):
            return [flat(item) for item in value]
        if isinstance(value, (float, np.floating)):
            return float(value) if math.isfinite(value) else None
        return int(value) if isinstance(value, np.integer) else value

    head = json.dumps(flat(document), allow_nan=False, separators=(",", ":")).encode("utf-8")
    head += b" " * (-len(head) % 4)
    return b"".join([struct.pack("<I", len(head)), head, *(each.tobytes() for each in arrays)])


def read_head(source: BinaryIO) -> tuple[dict[str, Any], int]:
    """Return the head of a frame, places of arrays in it as they stand, and where its numbers begin.

    Raises `ValueError` for bytes that are no frame.
    """
    size = source.read(4)
    if len(size) < 4:
        raise ValueError("frame: shorter than its head")
    (length,) = struct.unpack("<I", size)
    return json.loads(source.read(length)), 4 + length


def unpack_frame(frame: bytes) -> dict[str, Any]:
    """Return the document of a frame.

    Raises `ValueError` for bytes that are no frame.
    """
    document, begins = read_head(io.BytesIO(frame))
    numbers = np.frombuffer(frame, dtype="<f4", offset=begins)

    def full(value: Any) -> Any:
        if isinstance(value, dict):
            if set(value) == {"at", "shape"}:
                size = math.prod(value["shape"])
                return numbers[value["at"] : value["at"] + size].reshape(value["shape"])
            return {key: full(item) for key, item in value.items()}
        return [full(item) for item in value] if isinstance(value, list) else value

    found: dict[str, Any] = full(document)
    return found
