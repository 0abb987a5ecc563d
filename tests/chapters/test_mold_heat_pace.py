"""How long a warm-up will take is told from its first steps: of steps that grow, and of power that jumps."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from hyperfab.chapters.mold_heat.pace import Pace
from hyperfab.thermal.condition import Heater, Thermostat
from hyperfab.thermal.tables import Table


def problem(corners: list[float], loss: float | None = None) -> SimpleNamespace:
    """A mold of one node: 1000 J/K, 100 W switched at 100 ± 5 degC from 0 degC, ``loss`` W there."""
    heater = Heater("heater", np.ones(1), Table.constant(100.0))
    film = SimpleNamespace(flow=lambda time, temperature: -np.array([loss or 0.0]) * temperature / 100.0)
    model = SimpleNamespace(
        size=1,
        total_capacity=lambda temperature: 1000.0,
        total=lambda by_node: float(by_node.sum()),
        conditions=[heater, film],
    )
    thermostats = [] if loss is None else [Thermostat(heater, np.ones(1), 100.0, 10.0)]
    return SimpleNamespace(model=model, thermostats=thermostats, corners=corners, mesh=SimpleNamespace(solid=1))


def stages(ends: list[float], first: float, growth: float) -> list[float]:
    """The times of steps that begin with ``first`` after every one of ``ends`` and grow."""
    times, now = [], 0.0
    for end in ends:
        length = first
        while now < end:
            now = min(now + length, end)
            times.append(now)
            length *= growth
    return times


@pytest.mark.parametrize(
    ("ends", "loss"),
    [
        ([5000.0], None),
        ([1000.0, 2000.0, 3000.0, 5000.0], None),
        # Lumped: on for 105 s of 10 W lost and 100 W supplied ..., off for 10 J/W.
        ([1105.0, *np.cumsum([1105.0, *([1000.0, 111.0] * 9)])[1:].tolist()], 10.0),
    ],
    ids=["smooth", "schedule", "thermostat"],
)
def test_the_steps_to_come_are_told_from_the_first_few(ends: list[float], loss: float | None) -> None:
    times = stages(ends, 1.0, 1.5)
    pace = Pace(problem(ends[:-1] if loss is None else [], loss), np.zeros(1), reducible=False)
    told = [pace.done(time, ends[-1]) for time in times]
    assert told[:3] == [0.0, 0.0, 0.0]
    for step in (4, len(times) // 3, len(times) // 2):
        assert told[step - 1] == pytest.approx(step / len(times), rel=0.5)
    assert told[-1] > 0.97


def test_a_run_that_goes_back_goes_on_from_there() -> None:
    """What the checks of a reduced mold do: twice in a row, before jumps that were counted, and once to the start."""
    pace = Pace(problem([], 10.0), np.zeros(1), reducible=True)
    first = stages([1105.0, 2105.0, 2216.0, 3216.0], 1.0, 1.5)
    ways = [first, stages([2105.0, 2216.0], 1.0, 1.5)[14:], [1105.0], [1106.0, 1107.0], [0.5], first]
    told = [pace.done(time, 20_000.0) for way in ways for time in way]
    assert all(0.0 <= share <= 1.0 for share in told)
    assert pace.jumps == [1105.0, 2105.0, 2216.0]
