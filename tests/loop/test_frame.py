"""A frame that is the stiffer the further it is closed, or has play first: named, or said to be a rival."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from loop import blind_press
from loop.generators import press as caps

from hyperfab.chapters.close_loop.finalise import close_rounds
from hyperfab.chapters.close_loop.press import pose
from hyperfab.chapters.close_loop.readings import Files
from hyperfab.loop import confounding
from hyperfab.loop.engine import Finding
from hyperfab.loop.press_reading import Frame
from hyperfab.loop.search import Search

#: How far [mm] a frame opens under a share of the largest force, by formulas that are none of the catalogue's.
FRAMES: dict[str, Callable[[np.ndarray], np.ndarray]] = {
    "stiffens": lambda share: 0.25 * share / (1.0 + share),
    "stiffens soon": lambda share: 0.12 * share / (0.2 + share) + 0.04 * share,
    "goes as a root": lambda share: 0.16 * np.sqrt(share),
    "has play, then a spring": lambda share: np.minimum(0.1, 4.0 * share) + 0.05 * share,
}


def read_through(frame: Callable[[np.ndarray], np.ndarray], noise: float, seed: int) -> Finding:
    """Return what is found of force over stroke of caps in a frame, read to ``noise`` of 1 %."""
    random = np.random.default_rng(seed)
    [plain] = caps.measure(caps.Truth(()), random, 0.0, "stroke")
    assert plain.stroke is not None
    off = noise * caps.sd_of(plain) * random.standard_normal(len(plain.values))
    stroke = plain.stroke + frame(plain.values / plain.values.max())
    files = blind_press.as_readings([replace(plain, values=plain.values + off, stroke=stroke)])
    problem = pose(blind_press.told(), files, 0.10, [])[0]
    return close_rounds(problem, Files(list(files)).noise, design=False)[1]


@pytest.mark.slow
@pytest.mark.parametrize("name", FRAMES)
def test_what_a_frame_does_is_not_put_down_to_something_else_for_sure(name: str) -> None:
    found = read_through(FRAMES[name], 0.3, 1)
    assert found.verdict in ("effect", "ambiguous")
    assert "frame-compliance" in {*found.after.ids}.union(*found.indistinguishable)


def test_a_rival_of_more_constants_stands_where_they_pay(monkeypatch: pytest.MonkeyPatch) -> None:
    """Fabrics that give way, of one constant, were sure beside a frame of two that explained the readings better."""
    problem = SimpleNamespace(well_known=False, describes=False)
    without: Any = SimpleNamespace(ids=("tilt",))
    judged = {("frame-compliance", "tilt"): -40.0, ("frame-compliance",): -90.0, ("tilt", "set"): 5.0}
    search: Any = SimpleNamespace(problem=problem, states=[SimpleNamespace(ids=ids) for ids in judged])
    search.of_names = partial(Search.of_names, search)
    monkeypatch.setattr(confounding, "_gap", lambda search, best, state: judged[state.ids])

    def paying(name: str) -> tuple[str, ...] | None:
        effect: Any = SimpleNamespace(id=name)
        found = confounding._paying(search, without, without, effect)
        return None if found is None else found.ids

    assert paying("frame-compliance") == ("frame-compliance", "tilt")
    assert paying("set") is None
    problem.describes = True
    assert paying("frame-compliance") is None


def test_play_is_taken_up_before_the_spring() -> None:
    frame, force = Frame(1e-3, 0.2, 5.0), np.array([0.0, 1e-3, 100.0, 200.0])
    opens = np.asarray(frame.opens(force))
    assert opens[1] == pytest.approx(1e-3 * (1e-3 + 0.2 / 5.0), rel=1e-3)
    assert opens[2:] == pytest.approx([0.3, 0.4], rel=1e-6)


@pytest.mark.parametrize("deeper", [pytest.param(0.0, marks=pytest.mark.slow), 4.0])
@pytest.mark.parametrize(
    "frame",
    [
        pytest.param(Frame(2e-4), marks=pytest.mark.slow),
        Frame(2e-4, 0.05, 1.0),
        pytest.param(Frame(0.0, 0.3, 40.0), marks=pytest.mark.slow),
        Frame(5e-3, 0.4, 0.2),
    ],
)
def test_a_press_stands_where_its_frame_opens_to_under_the_force(frame: Frame, deeper: float) -> None:
    """Also where it is shut further than any opening of the table, beyond which the force is that of the last one."""
    files = blind_press.as_readings(caps.measure(caps.Truth(()), np.random.default_rng(2), 0.0, "rich"))
    problem = pose(blind_press.told(), files, 0.1, [])[0]
    problem.setting = replace(problem.setting, opening=problem.setting.opening - deeper)
    own = {one.name: one.value for one in problem.own}
    constants = np.array([frame.play, frame.taken_up, 1e3 * frame.compliance])
    terms = {"frame-compliance": ("play and spring", constants)}
    press = problem._set(problem._moved(own, problem.changes(terms)), own)
    force = float(press.force_at(np.array([press.opening]))[0])
    assert force > 0.0
    assert press.opening == pytest.approx(problem.setting.opening + float(frame.opens(force)), abs=1e-6)
    assert problem.force_at(np.array(list(own.values())), terms, 0.0) == pytest.approx(force, rel=1e-9)
