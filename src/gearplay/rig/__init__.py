"""Virtual rig: simulated records of a sensor and a data collector."""

from gearplay.rig.chain import apply_chain
from gearplay.rig.measurement import measure

__all__ = ["apply_chain", "measure"]
