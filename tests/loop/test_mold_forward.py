"""What the loop predicts is what the finite elements of ``hf mold-heat`` compute from the mold that it writes."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
import pytest
from conftest import Run
from loop import test_applied_mold as applied

#: A bar heated at one end and cooled at the other: 90 K from end to end, in one part.
BAR = """format = "hyperfab.mold/1"
[material.steel]
density = "7800 kg/m^3"
conductivity = "20 W/m/K"
specific_heat = "460 J/kg/K"
[[part]]
name = "bar"
material = "steel"
box = { origin = ["0 mm", "0 mm", "0 mm"], size = ["160 mm", "20 mm", "20 mm"] }
[[heater]]
on = ["bar.x-"]
power = "5 W"
[[insulated]]
on = ["bar.z-", "bar.z+", "bar.y-", "bar.y+"]
[[convection]]
on = ["bar.x+"]
h = "2000 W/m^2/K"
ambient = "20 degC"
[[probe]]
name = "A"
at = ["5 mm", "10 mm", "10 mm"]
[[probe]]
name = "B"
at = ["80 mm", "10 mm", "10 mm"]
[[probe]]
name = "C"
at = ["150 mm", "10 mm", "10 mm"]
[run]
start = "20 degC"
until = "1800 s"
mesh_size = "8 mm"
"""


@cache
def bar() -> applied.Posed:
    return applied.posed(BAR.encode(), Path())


@pytest.mark.parametrize("rate", [-0.0015, 0.004])
def test_a_conductivity_that_changes_goes_by_where_the_part_is_hot(hf: Run, tmp_path: Path, rate: float) -> None:
    """By one mean temperature of the bar the hot end was off by 0.7 and 1.1 K."""
    before = bar()
    terms = {"property-drift": ("conductivity", np.array([rate]))}
    thought = before.problem.predict(before.own, terms).reshape(3, -1)
    applied.written(before.own, terms, tmp_path, before, noise_K=0.1)
    done = hf("mold-heat", "loop.model.toml", "--uncertainty", "none", "-o", "run.json", cwd=tmp_path, timeout=600)
    assert done.returncode == 0, done.stderr.decode()
    run = np.genfromtxt(tmp_path / "run.csv", delimiter=",", names=True)
    for name, values in zip("ABC", thought, strict=True):
        column = next(one for one in run.dtype.names if one.startswith(name))
        got = np.interp(applied.TIMES, run[run.dtype.names[0]], run[column])
        assert got == pytest.approx(values, abs=0.05)


@pytest.mark.parametrize(("noise", "tolerance"), [(np.inf, 0.1), (4.0, 0.1), (0.3, 0.015)])
def test_steps_of_the_extended_mold_err_by_less_than_the_noise(noise: float, tolerance: float, tmp_path: Path) -> None:
    after, _ = applied.written(bar().own, {}, tmp_path, bar(), noise)
    assert after.document.run.tolerance == pytest.approx(tolerance)
