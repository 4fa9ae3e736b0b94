"""Ringdown: from a recording of a wobbling soft body to a calibrated model of it."""

__version__ = "0.1.0"
