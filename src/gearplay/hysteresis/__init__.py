"""Quasi-static hysteresis of a train whose input is held: lost motion, backlash, torsional stiffness, reduction to a joint."""
