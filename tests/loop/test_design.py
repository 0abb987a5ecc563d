"""The next measurement is one that laws carried beyond their range still foretell."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from hyperfab.loop import design
from hyperfab.loop.noise import Noise

OLD, NEW = np.linspace(0.1, 1.0, 10), 5


def rival(last: float) -> Any:
    """A model that foretells the old tests, and of the new one readings up to ``last``."""
    return SimpleNamespace(
        x=np.array([last]), own=1, terms={}, forms={}, predict=np.append(OLD, last * np.linspace(0.2, 1.0, NEW))
    )


@pytest.mark.parametrize(("last", "useful"), [(2.0, True), (1e4, False), (1e200, False), (np.inf, False)])
def test_a_law_that_foretells_the_absurd_makes_no_test_telling(
    last: float, useful: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """An exponential fitted to half the stretch went to 1e209 at twice as far: the sum of squares was infinite."""
    models = [rival(1.0), rival(last)]
    problem = SimpleNamespace(
        predict=lambda x, terms: next(one.predict for one in models if one.x[0] == x[0]),
        channel=np.zeros(len(OLD) + NEW),
        curves=[],
    )
    extra = SimpleNamespace(problem=problem, text="a pull farther", details={})

    def again(problem: Any, noise: Noise, forms: Any, x: np.ndarray, data: np.ndarray, iterations: int) -> Any:
        with np.errstate(over="ignore"):
            return SimpleNamespace(chi2=float(np.sum(((problem.predict(x, {}) - data) / noise.sd) ** 2)))

    monkeypatch.setattr(design, "fit", again)
    whole: Any = SimpleNamespace(extras=lambda: [extra], measured=OLD)
    noise = Noise(np.full(len(OLD), 0.01), 20.0, "stated")
    [found] = design.next_measurement(whole, noise, models)
    assert np.isfinite(found.misfit)
    assert found.decisive == useful
