"""The elements: one family, one interface, one file each."""

from .dg import DG
from .element import Element, Matrices  # noqa: F401
from .p1 import P1
from .p1_smoothed import P1_SMOOTHED
from .p2 import P2
from .p2_mixed import P2_MIXED
from .p3 import P3

ELEMENTS = {element.name: element for element in (P1, P1_SMOOTHED, P2, P2_MIXED, P3, DG)}
