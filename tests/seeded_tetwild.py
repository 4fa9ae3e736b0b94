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


def where_it_draws(count: int) -> int | None:
    """Address of std::random_device's draw, its first `count` bytes open to writing; None where
    that cannot be had.
    """
    if sys.platform != "linux" or platform.machine() != "x86_64":
        return None
    draw = ctypes.CDLL("libstdc++.so.6")["_ZNSt13random_device9_M_getvalEv"]
    address = ctypes.cast(draw, ctypes.c_void_p).value
    protect = ctypes.CDLL(None).mprotect
    protect.argtypes = [ctypes.c_void_p, ctypes.c_size_t, ctypes.c_int]
    start = address - address % mmap.PAGESIZE
    opened = protect(start, address + count - start, READ_WRITE_EXECUTE) == 0
    return address if opened else None  # a hardened system refuses


if __name__ == "__main__":
    code = b"\xb8" + SEED.to_bytes(4, "little") + b"\xc3"  # mov eax, SEED; ret
    if (address := where_it_draws(len(code))) is not None:
        ctypes.memmove(address, code, len(code))
    runpy.run_path(str(WORKER), run_name="__main__")
