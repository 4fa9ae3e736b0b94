"""Independent simulator of filmed soft bodies: it shares no line with the code under test."""

from .kinds import KINDS, cases
from .make import make

__all__ = ["KINDS", "cases", "make"]
