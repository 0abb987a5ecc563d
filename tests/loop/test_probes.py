"""Is it the log that is wrong: probes exchanged, one probe off, a log that begins warm; and a model that is wrong."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from hyperfab.chapters.close_loop import heat
from hyperfab.chapters.job import Job
from hyperfab.chapters.mold_heat.problem import MoldBuilder
from hyperfab.console import Console
from hyperfab.documents.base import parse_document
from hyperfab.documents.mold import MoldDocument
from hyperfab.io.toml_io import load_toml
from hyperfab.loop.catalogue.heat import CLOCK
from hyperfab.loop.engine import Finding, close
from hyperfab.loop.heat import HeatProblem
from hyperfab.loop.noise import Noise
from hyperfab.loop.noise_estimate import estimate_noise
from hyperfab.loop.probes import Log
from hyperfab.loop.search import Search
from hyperfab.thermal.tables import Table

NOISE = 0.2
BAR = """format = "hyperfab.mold/1"
[material.steel]
density = "7850 kg/m^3"
conductivity = "20 W/m/K"
specific_heat = "480 J/kg/K"
[[part]]
name = "bar"
material = "steel"
box = { origin = ["0 mm", "0 mm", "0 mm"], size = ["90 mm", "30 mm", "30 mm"] }
[[heater]]
on = "bar.x-"
power = "25 W"
[[convection]]
on = "exposed"
h = "12 W/m^2/K"
ambient = "22 degC"
[run]
start = "22 degC"
until = "3000 s"
mesh_size = "30 mm"
""" + "".join(
    f'[[probe]]\nname = "T{k}"\nat = ["{x} mm", "15 mm", "30 mm"]\n' for k, x in enumerate((5, 30, 60, 88), 1)
)


@cache
def bar() -> HeatProblem:
    document = parse_document(load_toml(BAR.encode(), "bar.toml"), "bar.toml", MoldDocument)
    job = Job("close-loop", [], Console(True))
    times = np.linspace(0.0, 3000.0, 61)
    read = heat.Thermocouples(times, np.full((61, 4), 22.0) + times[:, None] / 100.0, ["T1", "T2", "T3", "T4"])
    return heat.pose(MoldBuilder(document, "bar.toml", job.inputs), read, [], 0.1)


def logged(change: str) -> tuple[HeatProblem, Noise]:
    """Return the bar with its constants a little off and something done to its log, and the log's noise."""
    posed, rng = bar(), np.random.default_rng(4)
    if change == "fast":  # and the heater goes off half way: else the heat capacity passes for the clock
        run, off = posed.runs[0], Table(np.array([0.0, 1500.0, 1501.0, 4000.0]), np.array([25.0, 25.0, 0.0, 0.0]))
        mold = replace(run.mold, heaters=[(run.mold.heaters[0][0], off)], corners=(1500.0, 1501.0))
        posed = replace(posed, runs=[replace(run, mold=mold)])
    own = np.array([one.value + 0.3 * one.prior_sd * (-1.0) ** k for k, one in enumerate(posed.own)])
    if change == "warm":
        own[posed.kinds.index("start")] = 25.0
    terms = {"sensor-lag": ("first-order", np.array([60.0]))} if change == "lag" else {}
    rows = posed.predict(own, terms).reshape(4, -1)
    rows = rows + NOISE * rng.standard_normal(rows.shape)
    if change == "crossed, in a room that swings":
        rows += 1.5 * np.sin(np.arange(61) / 5.0)
    if change.startswith("crossed"):
        rows[[1, 3]] = rows[[3, 1]]
    if change in ("offset", "offset, noise told too small"):
        rows[2] -= 4.0
    if change.startswith("begun before"):
        late = 0.4 if "a little" in change else 2.0
        rows = np.array([np.interp(np.arange(61) - late, np.arange(61), row) for row in rows])
    if change == "fast":
        rows = np.array([np.interp(np.arange(61) / 1.08, np.arange(61), row) for row in rows])
    if change == "early":
        rows[0] = np.interp(np.arange(61) + 1.0, np.arange(61), rows[0])
    problem = replace(posed, measured=rows.ravel())
    return problem, estimate_noise(problem, (0.89 if "too small" in change else 1.0) * NOISE)


def told(change: str) -> list[str]:
    """Return what is told of a log where nothing explains it."""
    problem, noise = logged(change)
    before = Search(problem, noise).base()
    return Log(problem).looked_through(Finding("unexplained", noise, before, before, {}, {}, {}, {}))[1]


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ("crossed", ("T2 and T4 look exchanged",)),
        ("crossed, in a room that swings", ("T2 and T4 may be exchanged, or the heaters beside them",)),
        ("offset", ("T3 alone is at odds", "3.", "K too little throughout")),
        ("offset, noise told too small", ("T3 alone is at odds", "K too little throughout")),
        ("early", ("T1 alone is at odds", "s early")),
        ("warm", ("the log begins 25 K warmer",)),
        ("begun before", ("clock looks wrong: it began 1", "s before the run: with its times put right")),
        ("fast", ("clock looks wrong: it runs 8", "% too fast: with its times put right")),
        ("lag", ()),
    ],
)
def test_what_is_wrong_with_a_log_is_told(change: str, words: tuple[str, ...]) -> None:
    found = told(change)
    assert len(found) == bool(words), found
    for word in words:
        assert word in found[0]


def test_a_log_that_is_wrong_is_told_before_two_names_at_once_are_tried(monkeypatch: pytest.MonkeyPatch) -> None:
    """These and their rivals took most of the time."""
    problem, noise = logged("fast")
    tried: set[tuple[str, ...]] = set()
    joint = Search.joint
    monkeypatch.setattr(
        Search, "joint", lambda self, parent, *rest: tried.add(tuple(parent.forms)) or joint(self, parent, *rest)
    )
    log = Log(problem)
    found, odd = log.looked_through(close(problem, noise=noise, design=False, put_right=log.explains))
    assert found.put_right
    assert found.verdict == "unexplained"
    assert found.after.ids == ()
    assert len(odd) == 1
    assert tried == {()}


def test_a_log_is_not_put_right_in_place_of_what_a_name_explains() -> None:
    problem, noise = logged("lag")
    search = Search(problem, noise)
    assert not Log(problem).explains(search, search.base())


def test_a_late_log_and_sensors_that_lag_are_both_told_where_no_reading_tells_them_apart() -> None:
    """Twenty seconds late, read every fifty: the lag was named as sure."""
    problem, noise = logged("begun before, a little")
    search = Search(problem, noise)
    before = search.base()
    lag = search.with_term(before, problem.effect("sensor-lag"), families=0)
    assert lag is not None
    log = Log(problem)
    assert not log.explains(search, before)
    found, odd = log.looked_through(Finding("effect", noise, before, search.state(lag), {}, {}, {}, {}))
    assert found.verdict == "ambiguous"
    assert found.after.ids == ("sensor-lag",)
    assert found.indistinguishable == [["sensor-lag", CLOCK]]
    assert len(odd) == 1
    assert "a log that began 2" in odd[0]
    assert "s before the run would do as well as sensor-lag" in odd[0]
