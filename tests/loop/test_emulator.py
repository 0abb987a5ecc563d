"""The polynomial that stands for a costly forward run."""

from __future__ import annotations

import numpy as np

from hyperfab.loop.emulator import Axis, emulate


def test_is_the_run_itself_at_the_model_as_it_is() -> None:
    axes = [Axis("a", 1.0, 0.3, 0.3, level=1), Axis("b", 0.0, 2.0)]
    found = emulate(lambda s: np.array([np.exp(s[0]) * np.cos(s[1]), s[1] ** 3]), axes)
    np.testing.assert_allclose(found(np.array([1.0, 0.0])), [np.e, 0.0], rtol=1e-13, atol=1e-13)


def test_quartics_along_an_axis_and_products_of_two_are_exact() -> None:
    def run(s: np.ndarray) -> np.ndarray:
        return np.array([1.0 + s[0] ** 4 - 2.0 * s[1] ** 3 + s[0] ** 2 * s[1] ** 2 + 0.5 * s[2] * s[0]])

    axes = [Axis("a", 0.0, 1.5), Axis("b", 0.5, 1.0, 0.7), Axis("c", 1.0, 0.3, 0.3, level=1, mixes=False)]
    found = emulate(run, [axes[0], Axis("b", 0.0, 1.0, 1.0), axes[2]])
    for at in ([0.7, -0.4, 1.1], [1.2, 0.9, 0.8]):
        np.testing.assert_allclose(found(np.array(at)), run(np.array(at)), rtol=1e-10)


def test_axes_of_level_0_are_left_as_they_are() -> None:
    calls = []

    def run(s: np.ndarray) -> np.ndarray:
        calls.append(s.copy())
        return np.array([s[0]])

    emulate(run, [Axis("a", 0.0, 1.0), Axis("off", 0.0, 1.0, level=0, mixes=False)])
    assert all(one[1] == 0.0 for one in calls)
