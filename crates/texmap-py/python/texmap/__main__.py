"""The program ``texmap``: ``python -m texmap`` and the command of that name."""

import sys

from . import _texmap


def main() -> None:
    """Runs the program on the arguments of this process and ends with its exit code."""
    sys.exit(_texmap.main(["texmap", *sys.argv[1:]], [sys.executable, "-m", "texmap"]))


if __name__ == "__main__":
    main()
