"""What the loop predicts is what the finite elements of ``hf mold-heat`` compute from the mold that it writes."""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from conftest import Run
from loop import test_applied_mold as applied

from hyperfab.chapters.close_loop.heat import written_otherwise
from hyperfab.chapters.mold_heat.problem import MoldBuilder
from hyperfab.io.inputs import Inputs
from hyperfab.io.output import Output

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


@pytest.mark.slow
@pytest.mark.parametrize("rate", [pytest.param(-0.0015, marks=pytest.mark.slow), 0.004])
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


def test_what_the_written_mold_reads_beside_what_is_predicted_is_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Nobody was told: the loop runs the reduced mold alone."""
    monkeypatch.chdir(tmp_path)
    before, terms = applied.given(), {"property-drift": ("specific heat", np.array([1e-3]))}
    thought = before.problem.predict(before.own, terms)
    applied.written(before.own, terms, tmp_path, noise_K=0.1)
    files = {path.name.removeprefix("loop"): path.read_bytes() for path in tmp_path.glob("loop*")}
    given = MoldBuilder(before.document, "mold.toml", Inputs())
    given.build()

    def told(off: float, noise: float, *names: str) -> list[str]:
        fit = SimpleNamespace(predicted=thought + off)
        found: Any = SimpleNamespace(
            after=SimpleNamespace(ids=names, fit=fit), noise=SimpleNamespace(sd=np.full(len(thought), noise))
        )
        out = Output("loop.json", (".model.toml", ".*.csv"))
        return list(written_otherwise(files, out, given, before.problem, found))

    assert told(0.0, 1.0, "property-drift") == []
    [text] = told(0.5, 1.0, "property-drift")
    size, share = map(float, re.search(r"reads (\S+) K \(rms.* here, (\S+) % of the noise", text).groups())  # type: ignore[union-attr]
    assert (size, share) == (pytest.approx(0.5, abs=0.02), pytest.approx(50.0, abs=2.0))
    assert told(0.5, 1.0, "radiation") == []  # no run of the whole mold for what the reduced one answers for
    files[".model.toml"] = files[".model.toml"].replace(b"steel", b"stell", 1)
    [text] = told(0.0, 1.0, "property-drift")
    assert "does not run with what was found" in text


def test_a_mesh_is_taken_from_another_mold_of_the_same_bodies_alone() -> None:
    before = applied.given()
    made, alike = (MoldBuilder(before.document, "mold.toml", Inputs()) for _ in range(2))
    made.build()
    other = MoldBuilder(
        before.document.model_copy(update={"run": before.document.run.model_copy(update={"mesh_size": 20.0})}),
        "mold.toml", Inputs(),
    )  # fmt: skip
    for one in (alike, other):
        one.take_mesh(made)
    assert alike.meshed is made.meshed is not None
    assert other.meshed is None
