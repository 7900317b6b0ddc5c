"""Figures and pages: one style, one export to PNG, one base of reports."""
