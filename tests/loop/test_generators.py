"""Which truths of the second set are a form of the catalogue after all: counted, so that nothing else is claimed."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from loop.blind import problem_of
from loop.generators import fabric as truths
from loop.generators import other_fabric

from hyperfab.loop.fitting import fit
from hyperfab.loop.noise import Noise

#: What a form leaves of noise-free curves, over their rms, if it is the truth's own formula.
SAME = 1e-5


def left(effect: str, kind: int) -> float:
    """Return what the best form of the catalogue's entry leaves of a truth of that kind, over the rms of the curves."""
    random = np.random.default_rng([kind, 17])
    truth = other_fabric.draw(random, (effect,), kind)
    setups = [
        truths.Setup(s.mode, s.angle, s.rate, s.temperature, s.turns, s.hold, points=15)
        for s in truths.rich(1.5, 0.01, 60.0)
    ]
    model = "neo-hookean" if effect == "elastic-law" else "yeoh-3"
    problem = problem_of(other_fabric.measure(truth, setups, random, 0.0), model)
    first = problem.channel == 0
    size = float(np.sqrt(np.mean(problem.measured[first] ** 2)))
    sd = np.where(first, 1e-4 * size, 1e-4)
    best = np.inf
    own = [constant.value for constant in problem.own]
    for form in problem.effect(effect).forms:
        for start in form.starts:
            tried = fit(problem, Noise(sd, np.inf, ""), {effect: form}, [*own, *start], iterations=80)
            missed = (problem.measured - tried.predicted)[first]
            best = min(best, float(np.sqrt(np.mean(missed**2))) / size if np.isfinite(tried.chi2) else np.inf)
        if best < SAME:
            break
    return best


@pytest.mark.slow
def test_how_many_kinds_are_forms_of_the_catalogue_is_what_the_page_says() -> None:
    same = {
        effect: [kind for kind in range(many) if left(effect, kind) < SAME]
        for effect, many in other_fabric.KINDS.items()
    }
    count, every = sum(map(len, same.values())), sum(other_fabric.KINDS.values())
    page = (Path(__file__).parents[2] / "docs" / "close-loop.md").read_text()
    assert f"{count} of its {every} kinds are a form of the catalogue" in page, same
