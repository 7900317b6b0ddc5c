"""Diagnosis of a record: named lines, indices against a healthy record, ranked hypotheses."""
