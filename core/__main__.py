"""`python -m core ...`, or this file by its path."""

import sys


def main() -> int:
    """The exit status; 130 also where it is stopped before all is imported."""
    try:
        if __package__:
            from .command import main as command
        else:
            from pathlib import Path

            sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
            from core.command import main as command
        return command(sys.argv[1:])
    except KeyboardInterrupt:
        sys.stderr.write("\nringdown: stopped; nothing was written.\n")
        return 130


if __name__ == "__main__":
    sys.exit(main())
