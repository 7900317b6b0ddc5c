"""Bundled cases and plans, by name."""

from importlib.resources import files


def bundled(package: str, folder: str) -> list[str]:
    """Return the names of the TOML files in a folder of a package.

    >>> "han2021" in bundled("gearplay.model", "cases"), bundled("gearplay.calibration", "plans")
    (True, ['han2021', 'tutorial'])
    """
    found = (files(package) / folder).iterdir()
    return sorted(entry.name.removesuffix(".toml") for entry in found if entry.name.endswith(".toml"))


def bundled_text(package: str, folder: str, name: str) -> str:
    """Return the text of a bundled file."""
    return (files(package) / folder / f"{name}.toml").read_text(encoding="utf-8")
