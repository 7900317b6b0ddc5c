"""The entrance: the script ``gearplay`` and ``python -m gearplay``."""

from gearplay.cli.interrupts import leave_at_once


def main() -> None:
    """Run the command line; Ctrl-C is heard before anything else is loaded."""
    leave_at_once()
    from gearplay.cli.main import main as begin

    begin()


if __name__ == "__main__":
    main()
