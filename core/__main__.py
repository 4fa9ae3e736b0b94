"""`python -m core ...`, or this file by its path."""

import sys

if __package__:
    from .command import main
else:
    from pathlib import Path

    sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
    from core.command import main

if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
