"""What a term is worth: the model without it is at an optimum of its own, never worse than the one without any."""

from __future__ import annotations

import numpy as np
import pytest

from hyperfab.curve import TestCurve
from hyperfab.loop.fabric import fabric_problem
from hyperfab.loop.fitting import fit, split
from hyperfab.loop.noise_estimate import estimate_noise
from hyperfab.loop.search import Search
from hyperfab.materials.registry import law

#: Ogden's two constants, five of a rate, and a play, where the rate carries a third of the stress.
FAR = np.array([-0.266, -2.03, 0.275, 160.0, 1.57, 0.213, 3.6, 0.0107])


@pytest.mark.parametrize("seed", [0, 1])
def test_without_a_term_that_carries_most_a_model_misses_no_more_than_without_any(seed: int) -> None:
    up = 1.0 + np.concatenate([np.linspace(0.0055, 0.107, 15), np.linspace(0.12, 2.0, 22)])
    stretch = np.concatenate([[1.0], up, up[-2:3:-1]])
    seconds = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(stretch)))]) / 0.0667
    pull = TestCurve("uniaxial", stretch, np.ones(len(stretch)), time_s=seconds, source="strip", specimen="strip")
    problem = fabric_problem(law("ogden-1"), (0.244, 1.68), [pull])
    forms = {
        name: next(one for one in problem.effect(name).forms if one.name == form)
        for name, form in (("rate", "prony-2-bent"), ("grip-slack", "play"))
    }
    stress = problem.predict(FAR[:2], split(FAR[2:], forms))
    noisy = stress + np.random.default_rng(seed).normal(0.0, 0.0015, len(stress))
    pull = TestCurve("uniaxial", stretch, noisy, time_s=seconds, source="strip", specimen="strip")
    problem = fabric_problem(law("ogden-1"), (0.244, 1.68), [pull])
    search = Search(problem, estimate_noise(problem))
    search.base()
    bare = fit(problem, search.noise, {}, (0.244, 1.68))
    both = search.state(fit(problem, search.noise, forms, FAR))
    assert both.fit.cost < 0.01 * bare.cost
    assert search.without(both, "rate").fit.cost < 1.0001 * bare.cost
