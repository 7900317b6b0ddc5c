"""Checksum at the end of a file, so that damage is detected."""

import hashlib
from typing import Final

MARK: Final = b"gearplay sha256:"
"""Stands at the end before the SHA-256 of all before; HDF5 does not look beyond its own end."""
LENGTH: Final = len(MARK) + hashlib.sha256().digest_size
"""Of mark and digest [bytes]."""


def sealed(content: bytes) -> bytes:
    """Return content with its mark and digest behind.

    >>> len(sealed(b"abc")) - LENGTH
    3
    """
    return content + MARK + hashlib.sha256(content).digest()
