"""The spring grid of a stretch fabric and its equilibrium on a mold."""

from .answers import Answers, answers
from .cascade import drape
from .law import SpringLaw, piecewise_linear, tabulate
from .mold import Mold, mold_of
from .net import Sheet
from .newton import Equilibrium, Step
from .start import HeldNodeInside

__all__ = [
    "Answers",
    "Equilibrium",
    "HeldNodeInside",
    "Mold",
    "Sheet",
    "SpringLaw",
    "Step",
    "answers",
    "drape",
    "mold_of",
    "piecewise_linear",
    "tabulate",
]
