"""Air that swings and joints that close in time: truths of other shapes than the catalogue's formulas."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from loop import test_applied_mold as applied

from hyperfab.chapters.close_loop import heat
from hyperfab.chapters.mold_heat.problem import MoldBuilder
from hyperfab.io.inputs import Inputs
from hyperfab.loop.engine import Finding, close
from hyperfab.loop.heat import HeatProblem
from hyperfab.loop.noise_estimate import estimate_noise
from hyperfab.loop.search import Search

#: Of a thermocouple.
NOISE_K = 0.2


def problem_of(text: str, folder: Path) -> HeatProblem:
    """Return the problem of the mold of the tests where its probes read what that of another ``text`` does."""
    true = applied.posed(text.encode(), folder)
    read = true.problem.predict(true.own, {}).reshape(3, -1).T
    read = read + NOISE_K * np.random.default_rng(4).standard_normal(read.shape)
    given = applied.given()
    builder = MoldBuilder(given.document, "mold.toml", Inputs())
    thermocouples = heat.Thermocouples(applied.TIMES, read, ["A", "B", "C"])
    return heat.pose(builder, thermocouples, [], 0.1)


def found_of(text: str, folder: Path) -> Finding:
    return close(problem_of(text, folder), noise=NOISE_K, design=False)


def in_air(folder: Path, period: float, swing: float) -> str:
    """Return the mold in air that a thermostat drives up and down evenly, begun anywhere in its round."""
    times = np.linspace(0.0, 1800.0, 400)
    air = 4.0 * swing * (np.abs((times / period + 0.1) % 1.0 - 0.5) - 0.4)
    rows = "".join(f"{t},{25.0 + v}\n" for t, v in zip(times, air, strict=True))
    (folder / "air.csv").write_text("time [s],temperature [degC]\n" + rows)
    table = f'ambient = {{ table = "{folder}/air.csv" }}'
    return applied.MOLD.replace('ambient = "25 degC"', table).replace('ambient = "20 degC"', table)


def with_joint(folder: Path, closed: np.ndarray, times: np.ndarray) -> str:
    """Return the mold with a joint that is ``closed`` so far at ``times`` [s]."""
    rows = "".join(f"{t},{x}\n" for t, x in zip(times, closed, strict=True))
    (folder / "joint.csv").write_text("time [s],contact [-]\n" + rows)
    joint = f'[[contact]]\nbetween = ["plate", "block"]\nh = "800 W/m^2/K"\nschedule = "{folder}/joint.csv"\n'
    return applied.MOLD.replace("[[heater]]", f"{joint}[[heater]]", 1)


@pytest.mark.slow
@pytest.mark.parametrize(("period", "swing"), [(1100.0, 3.0), (700.0, 3.0), (1100.0, 1.5)])
def test_air_that_goes_up_and_down_is_ambient_drift(period: float, swing: float, tmp_path: Path) -> None:
    found = found_of(in_air(tmp_path, period, swing), tmp_path)
    assert found.after.ids == ("ambient-drift",)
    assert found.verdict == "effect"


TIMES = np.linspace(0.0, 1800.0, 100)
CLOSING = {
    "hyperbola": 1.0 - 0.7 / (1.0 + (TIMES / 400.0) ** 2),
    "evenly": 0.3 + 0.7 * TIMES / 1800.0,
    "evenly, then closed": np.interp(TIMES, [0.0, 900.0], [0.3, 1.0]),
}


@pytest.mark.slow
@pytest.mark.parametrize("way", CLOSING)
def test_a_joint_that_closes_in_time_is_a_contact_resistance(way: str, tmp_path: Path) -> None:
    found = found_of(with_joint(tmp_path, CLOSING[way], TIMES), tmp_path)
    assert found.after.ids == ("contact-resistance",)
    assert found.verdict == "effect"
    assert ("in time", "evenly")[way.startswith("evenly")] in found.after.fit.forms["contact-resistance"].name


def tried(text: str, folder: Path, monkeypatch: pytest.MonkeyPatch) -> set[str]:
    """Return the forms of air that changes that are fitted beside the model as it is."""
    problem, names = problem_of(text, folder), set()
    search = Search(problem, estimate_noise(problem, NOISE_K))
    state = search.base()
    monkeypatch.setattr(search, "joint", lambda parent, effect, form, simpler=None: names.add(form.name))
    search.with_term(state, problem.effect("ambient-drift"))
    return names


def test_forms_that_take_long_are_fitted_only_where_they_point_at_what_is_left(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """All were fitted on every mold that something lacked on."""
    lost = applied.MOLD.replace('power = "60 W"', 'power = "20 W"')
    assert tried(lost, tmp_path, monkeypatch) == {"linear"}
    assert tried(in_air(tmp_path, 1100.0, 3.0), tmp_path, monkeypatch) == {"linear", "swing"}


def test_a_joint_that_closes_evenly_has_closed_at_its_time() -> None:
    settings = replace(
        applied.given().problem.runs[0].mold.plain(),
        effects={"joint_tightens": np.array([2.0]), "joint_tightens_s": np.array([100.0])},
    )
    assert settings.closes(0, np.array([-5.0, 0.0, 50.0, 100.0, 900.0])).tolist() == [1.0, 1.0, 2.0, 3.0, 3.0]


def test_air_may_swing_as_fast_as_it_may_drift() -> None:
    """The steepest of a sine is steeper than the even way up and down that it stands for."""
    problem = applied.given().problem

    def off(*values: float) -> float:
        return max(problem.forbidden(problem.own, {"ambient-drift": ("swing", np.array(values))}).values())

    assert off(-1.1, 2.2, 1055.0) <= 0.0  # 3 K up and down, evenly, in 1100 s
    assert off(-2.0, 4.0, 1055.0) > 0.0
    assert off(30.0, 0.0, 20000.0) > 0.0


def test_specific_heat_of_a_solid_does_not_fall() -> None:
    problem = applied.given().problem
    forms = [form for form in problem.effect("property-drift").forms if "specific_heat_per_K" in form.named(form.null)]
    assert len(forms) >= 4
    assert all(one.low == 0.0 for form in forms for one in form.constants if one.name == "specific_heat_per_K")
    # With a bend neither at the highest temperature.
    rise = float(np.ptp(problem.measured))
    off = [problem.forbidden(problem.own, {"property-drift": ("bent", np.array([0.1, bend]) / [rise, rise**2])})
           for bend in (0.3, -0.04, -0.2)]  # fmt: skip
    assert [max(one.values()) > 0.0 for one in off] == [False, False, True]
    none = problem.forbidden(problem.own, {"property-drift": ("bent", np.zeros(2))})
    assert none.keys() == off[0].keys()
