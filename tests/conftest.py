"""Test-wide settings: kernels are cached in a folder named by their source, so that an edit anywhere is seen."""

import hashlib
import os
import tempfile
from collections.abc import Callable
from pathlib import Path

import pytest

KERNELS = Path(__file__).resolve().parents[1] / "src" / "gearplay" / "kernels"

if "NUMBA_CACHE_DIR" not in os.environ:
    digest = hashlib.sha256(b"".join(f.read_bytes() for f in sorted(KERNELS.rglob("*.py")))).hexdigest()[:16]
    os.environ["NUMBA_CACHE_DIR"] = str(Path(tempfile.gettempdir()) / f"gearplay-kernels-{digest}")


@pytest.fixture
def measured(record_property: Callable[[str, object], None]) -> Callable[[str, float, str], None]:
    """Record what a test measured beside its limit; `make verification` turns the records into docs/verification.md."""

    def record(quantity: str, value: float, limit: str) -> None:
        record_property("measured", f"{quantity}|{value:.2g}|{limit}")

    return record
