"""Labelled records for learning: plans, drawn cases, records of the virtual rig, labels, splits."""
