"""The command line `holo`: `python -m holo` is the same."""

import sys


def main():
    """Runs the command line and ends the process with its exit code."""
    from . import _holo

    sys.exit(_holo.main(["holo", *sys.argv[1:]]))


if __name__ == "__main__":
    main()
