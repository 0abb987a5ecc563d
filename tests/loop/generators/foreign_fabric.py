"""The second set's effects on plain laws that are no model's: random smooth ones.

Beside ``smooth_fabric`` this is what names on a plain law of other make are developed on. Units: MPa, s, degC.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

from loop.generators import smooth_fabric
from loop.generators.other_fabric import KINDS, OUTSIDE, Truth, measure, protocol
from loop.generators.other_fabric import draw as draw_other
from numpy.random import Generator

__all__ = ["KINDS", "OUTSIDE", "Truth", "draw", "measure", "protocol"]


def draw(random: Generator, effects: Sequence[str], kind: int | None = None) -> Truth:
    """Return a fabric with these effects; ``kind`` fixes the kind of the first."""
    truth = draw_other(random, effects, kind)
    if "elastic-law" not in effects:
        truth.elastic = partial(smooth_fabric.elastic, smooth_fabric.draw(random, ()))
    return truth
