"""The spring grid of a stretch fabric and its equilibrium on a mold."""

from .answers import Answers, answers
from .cascade import BeyondLaw, drape
from .law import SpringLaw, piecewise_linear, tabulate
from .mold import Mold, mold_of, raised
from .net import Sheet
from .path import Rest, follow, load_steps
from .start import HeldNodeInside
from .state import Equilibrium, Step

__all__ = [
    "Answers",
    "BeyondLaw",
    "Equilibrium",
    "HeldNodeInside",
    "Mold",
    "Rest",
    "Sheet",
    "SpringLaw",
    "Step",
    "answers",
    "drape",
    "follow",
    "load_steps",
    "mold_of",
    "piecewise_linear",
    "raised",
    "tabulate",
]
