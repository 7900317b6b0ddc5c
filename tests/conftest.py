"""Test-wide settings: kernels are cached in a folder named by their source, so that an edit anywhere is seen."""

import hashlib
import os
import tempfile
from pathlib import Path

KERNELS = Path(__file__).resolve().parents[1] / "src" / "gearplay" / "kernels"

if "NUMBA_CACHE_DIR" not in os.environ:
    digest = hashlib.sha256(b"".join(f.read_bytes() for f in sorted(KERNELS.glob("*.py")))).hexdigest()[:16]
    os.environ["NUMBA_CACHE_DIR"] = str(Path(tempfile.gettempdir()) / f"gearplay-kernels-{digest}")
