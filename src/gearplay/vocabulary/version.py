"""The version of gearplay."""

VERSION = "0.1.0"
