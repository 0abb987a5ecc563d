"""What is known of a model's own constants, as rows beside the measured ones.

A prior that only pulls would let a constant drift three of its standard deviations off, and carry away there what
an effect does. As a reading of its own it speaks in every test.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from hyperfab.arrays import Array
from hyperfab.loop.problem import Constant, Curve

#: Standard deviations a constant may be off.
SURE = 3.0


def known(constants: Sequence[Constant], own: Array) -> Array:
    """Return how far the ``own`` constants (..., p) are from what is known, in standard deviations, (..., k)."""
    column = [i for i, one in enumerate(constants) if np.isfinite(one.prior_sd)]
    centre = np.array([constants[i].value for i in column])
    sd = np.array([constants[i].prior_sd for i in column])
    return np.asarray((own[..., column] - centre) / sd)


def sure(constants: Sequence[Constant], fixed: Sequence[str]) -> tuple[Constant, ...]:
    """Return constants that stay within three standard deviations of what is known of them, or are ``fixed``.

    What an effect does beyond them is then left in the readings, where every one of them can tell.
    """
    found = []
    for one in constants:
        reach = 0.0 if one.name in fixed else SURE * one.prior_sd
        low, high = max(one.low, one.value - reach), min(one.high, one.value + reach)
        found.append(replace(one, low=low, high=high, prior_sd=one.prior_sd if reach else np.inf))
    return tuple(found)


def without_prior(constants: Sequence[Constant]) -> tuple[Constant, ...]:
    """Return the constants for the fit: the rows speak for the priors."""
    return tuple(replace(one, prior_sd=np.inf) for one in constants)


def known_curve(constants: Sequence[Constant], start: int, channel: int) -> Curve:
    """Return the rows of what is known as a curve of its own, from row ``start`` on."""
    count = sum(bool(np.isfinite(one.prior_sd)) for one in constants)
    return Curve(
        "what is known of the constants",
        start,
        start + count,
        np.arange(count, dtype=np.float64),
        channel=channel,
        beforehand=True,
    )
