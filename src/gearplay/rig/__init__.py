"""The virtual rig: what a sensor and a collector would have recorded of a simulated motion."""

from gearplay.rig.chain import apply_chain
from gearplay.rig.measurement import measure

__all__ = ["apply_chain", "measure"]
