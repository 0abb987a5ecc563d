"""The sets of random smooth effects and the fourth are what they say: finite, repeatable, of a size that is seen."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from loop.blind import SETS, case
from loop.generators import fourth_fabric, rough_fabric, smooth_fabric

CASES = [
    (fabrics, effect, kind)
    for fabrics in (smooth_fabric, rough_fabric, fourth_fabric)
    for effect, count in {**fabrics.KINDS, **dict.fromkeys(fabrics.OUTSIDE, 1)}.items()
    for kind in range(count)
]


@pytest.mark.parametrize(("fabrics", "effect", "kind"), CASES)
def test_every_kind_is_finite_repeatable_and_seen(fabrics: Any, effect: str, kind: int) -> None:
    truth = fabrics.draw(np.random.default_rng([kind, len(effect)]), [effect], kind)
    setups = [replace(one, points=20) for one in fabrics.protocol(np.random.default_rng(2))]
    reads, again, plain = (
        fabrics.measure(one, setups, np.random.default_rng(1), 0.0)
        for one in (truth, truth, replace(truth, effects=()))
    )
    top = max(read.stress.max() for read in plain)
    gap = np.concatenate([one.stress - other.stress for one, other in zip(reads, plain, strict=True)])
    assert all(np.array_equal(one.stress, two.stress) for one, two in zip(reads, again, strict=True))
    assert 0.005 < np.sqrt(np.mean(gap**2)) / top < 0.6


@pytest.mark.parametrize("seed", range(20))
def test_a_drawn_curve_rises_from_nothing_to_one(seed: int) -> None:
    curve = smooth_fabric.rising(np.random.default_rng(seed))
    assert curve(np.array([0.0, 1.0])) == pytest.approx([0.0, 1.0])
    assert (np.diff(curve(np.linspace(0.0, 2.0, 50))) > 0.0).all()


@pytest.mark.parametrize("which", SETS)
def test_trials_of_every_set_are_posed_alike(which: str) -> None:
    problem, noise, truth, setups = case(0, ("thermal-softening",), poor=False, which=which)
    assert truth.effects == ("thermal-softening",)
    assert len(problem.tests) == len(setups)
    assert noise > 0.0
