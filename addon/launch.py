"""Runs a child of Blender's that does not outlive it: `python launch.py (-m MODULE | FILE) ...`.

Blender holds the other end of the child's standard input. However Blender ends, that end closes.
"""

import os
import runpy
import sys
import threading


def end_with_parent() -> None:
    while os.read(0, 1):
        pass
    os._exit(130)


if __name__ == "__main__":
    if hasattr(os, "nice"):
        os.nice(10)  # Blender's window comes first
    threading.Thread(target=end_with_parent, daemon=True).start()
    if sys.argv[1] == "-m":
        sys.argv = sys.argv[2:]
        runpy.run_module(sys.argv[0], run_name="__main__", alter_sys=True)
    else:
        sys.argv = sys.argv[1:]
        runpy.run_path(sys.argv[0], run_name="__main__")
