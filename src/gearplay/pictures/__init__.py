"""Pictures and pages: one style, one way to PNG, one base of reports."""
