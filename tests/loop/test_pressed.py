"""Compressions: what is pressed on is loaded, and what is let go unloads, whichever way its stretch goes."""

from __future__ import annotations

import numpy as np
import pytest

from hyperfab.curve import TestCurve
from hyperfab.loop.engine import close
from hyperfab.loop.fabric import FabricProblem, fabric_problem
from hyperfab.loop.fabric_tests import path_of
from hyperfab.materials import law


def test(stretch: np.ndarray, stress: np.ndarray, **known: object) -> TestCurve:
    return TestCurve("uniaxial", stretch, stress, **known)  # type: ignore[arg-type]


test.__test__ = False  # type: ignore[attr-defined]

PULL, PRESS = np.linspace(1.0, 1.5, 20), np.linspace(1.0, 0.6, 20)


@pytest.mark.parametrize(
    ("stretch", "up", "longer"),
    [
        (PULL, 1, 1),
        (PRESS, 1, -1),
        (np.linspace(0.5, 2.0, 40), 1, None),  # a table, from its least stretch on
    ],
)
def test_one_way_from_rest_is_loading(stretch: np.ndarray, up: int, longer: int | None) -> None:
    path, _ = path_of([test(stretch, stretch - 1.0)])
    assert set(path.up) == {up}
    assert longer is None or set(path.longer[2:]) == {longer}


@pytest.mark.parametrize("way", [PULL, PRESS])
def test_the_way_back_to_rest_is_unloading(way: np.ndarray) -> None:
    there_and_back = np.concatenate([way, way[::-1][1:]])
    path, _ = path_of([test(there_and_back, there_and_back - 1.0)])
    assert path.up.tolist() == [1] * 20 + [-1] * 19
    sign = int(np.sign(way[-1] - 1.0))
    assert path.longer[2:-2].tolist() == [sign] * 18 + [-sign] * 17


def test_a_swing_through_rest_loads_on_both_sides() -> None:
    parts = [PULL, PULL[::-1][1:], PRESS[1:], PRESS[::-1][1:]]
    swing = np.concatenate(parts)
    path, _ = path_of([test(swing, swing - 1.0)])
    assert path.up.tolist() == [1] * 20 + [-1] * 19 + [1] * 19 + [-1] * 19


def problem(tests: list[TestCurve], name: str = "neo-hookean") -> FabricProblem:
    return fabric_problem(law(name), [0.1], tests)


def test_a_pull_and_a_compression_unload_nothing() -> None:
    both = [test(x, 0.2 * (x - x**-2), source=name) for name, x in (("pull", PULL), ("press", PRESS))]
    hidden = {effect.id: effect.not_sought for effect in problem(both).effects}
    assert {hidden[name] for name in ("hysteresis", "mullins", "permanent-set")} == {"no test unloads"}


def test_a_loop_in_compression_is_one_of_hysteresis() -> None:
    """A law of the sheet's own, less by a share of the strain let go; two amplitudes, twice each, at one pace."""
    random = np.random.default_rng(2)
    sweeps = [np.linspace(1.0, low, 30) for low in (0.8, 0.8, 0.6, 0.6)]
    stretch = np.concatenate([part for way in sweeps for part in (way, way[::-1])])
    low = np.repeat([way[-1] for way in sweeps], 60)
    back = np.tile(np.repeat([False, True], 30), 4)
    share = np.where(back, 1.0 - 0.3 * (1.0 - ((1.0 - stretch) / (1.0 - low)) ** 1.5), 1.0)
    tests = [
        test(stretch, 0.2 * (stretch - stretch**-2) * share + random.normal(0.0, 0.002, len(stretch)),
             source=f"{number}", specimen=f"{number}", rate_1_s=np.full(len(stretch), 0.01))
        for number in range(2)
    ]  # fmt: skip
    found = close(problem(tests), design=False)
    assert "hysteresis" in found.after.ids
    assert found.after.judgement.is_small
    assert "elastic-law" not in found.after.ids
