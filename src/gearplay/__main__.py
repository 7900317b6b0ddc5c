"""The entrance: the script ``gearplay`` and ``python -m gearplay``."""

from gearplay.cli.interrupts import leave_at_once


def main() -> None:
    """Install the handler of Ctrl-C, then import and run the command line."""
    leave_at_once()
    from gearplay.cli.main import main as begin

    begin()


if __name__ == "__main__":
    main()
