"""`python -m gearplay`: the command line without its script."""

from gearplay.cli.main import main

if __name__ == "__main__":
    main()
