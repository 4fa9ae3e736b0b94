"""Independent simulator of filmed soft bodies: it shares no line with the code under test."""

from .make import KINDS, cases, make

__all__ = ["KINDS", "cases", "make"]
