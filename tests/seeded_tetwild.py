"""The tetrahedralizer's worker with its chance taken out: the same surface, the same mesh.

fTetWild seeds its shuffles by std::random_device, which nothing but its code can be told about.
On Linux for x86-64 that code is replaced in the child process, before it loads; anywhere else the
meshes stay as random as a user's. Verdicts near a threshold turn on the mesh, and a test that
fails in one run of fifty says nothing.
"""

import ctypes
import mmap
import platform
import runpy
import sys
from pathlib import Path

SEED = 1
WORKER = Path(__file__).resolve().parents[1] / "core" / "tetwild_worker.py"
READ_WRITE_EXECUTE = 7


def use(run_tetwild) -> None:
    """`run_tetwild` meshes by this file from now on."""
    run_tetwild.__kwdefaults__["worker"] = Path(__file__).resolve()


def seed_random_device(seed: int) -> None:
    """Every std::random_device of this process answers `seed`: mov eax, seed; ret."""
    draw = ctypes.CDLL("libstdc++.so.6")["_ZNSt13random_device9_M_getvalEv"]
    address = ctypes.cast(draw, ctypes.c_void_p).value
    protect = ctypes.CDLL(None, use_errno=True).mprotect
    protect.argtypes = [ctypes.c_void_p, ctypes.c_size_t, ctypes.c_int]
    start = address - address % mmap.PAGESIZE
    if protect(start, 2 * mmap.PAGESIZE, READ_WRITE_EXECUTE) != 0:
        return  # a hardened system
    ctypes.memmove(address, b"\xb8" + seed.to_bytes(4, "little") + b"\xc3", 6)


if __name__ == "__main__":
    if sys.platform == "linux" and platform.machine() == "x86_64":
        seed_random_device(SEED)
    runpy.run_path(str(WORKER), run_name="__main__")
