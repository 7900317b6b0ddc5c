"""Checksum at the end of a file, so that damage is detected."""

import hashlib
from typing import Final

MARK: Final = b"gearplay sha256:"
"""Marker at the end of a file, before the SHA-256 of all bytes before it; HDF5 reads only up to its own end."""
LENGTH: Final = len(MARK) + hashlib.sha256().digest_size
"""Of mark and digest [bytes]."""


def sealed(content: bytes) -> bytes:
    """Return content with its mark and digest behind.

    >>> len(sealed(b"abc")) - LENGTH
    3
    """
    return content + MARK + hashlib.sha256(content).digest()
