"""Axes, formulas and hashes: what a study's text comes to."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from hyperfab.documents.base import parse_document
from hyperfab.documents.study import StudyDocument
from hyperfab.io.inputs import Inputs
from hyperfab.studies.axes import Layout
from hyperfab.studies.effects import main_effects, pareto_front
from hyperfab.studies.plan import Plan, Step
from hyperfab.studies.table import Table
from hyperfab.studies.template import TemplateError, fill


def study(axis: dict[str, Any], **more: Any) -> StudyDocument:
    """Return a study over ``axis``."""
    words = " ".join(f"{{{name}}}" for name in axis)
    data = {
        "format": "hyperfab.study/1",
        "name": "Test",
        "axis": axis,
        "step": [{"name": "one", "command": "add", "arguments": [words]}],
        "figures": {"sum": "one.sum"},
        **more,
    }
    return parse_document(data, "study.toml", StudyDocument)


def test_ranges_hold_both_ends_and_units_go_into_the_column() -> None:
    layout = Layout(
        study(
            {
                "gap": {"range": {"from": "2 mm", "to": "3 mm", "count": 3}},
                "film": {"log_range": {"from": "1 W/m^2/K", "to": "100 W/m^2/K", "count": 3}},
                "law": {"values": ["gent", "yeoh-3"]},
            }
        ),
        "study.toml",
    )
    gap, film, law = layout.axes
    assert [level.text for level in gap.levels] == ["2.0 mm", "2.5 mm", "3.0 mm"]
    assert [level.number for level in film.levels] == [1.0, 10.0, 100.0]
    assert [level.value for level in law.levels] == ["gent", "yeoh-3"]
    assert [axis.column for axis in layout.axes] == ["gap_mm", "film_W_m2_K", "law"]
    assert len(layout) == 18
    assert layout.case(1)["law"].text == "yeoh-3"
    assert len({tuple(level.text for level in layout.case(n).values()) for n in range(18)}) == 18


def test_units_that_begin_with_one_over_are_units() -> None:
    layout = Layout(
        study(
            {
                "expansion": {"range": {"from": "22e-6 1/K", "to": "24e-6 1/K", "count": 3}},
                "rate": {"values": ["0.5 1/s", "2 1/s"]},
                "share": {"values": [1e-6, "2e-6"]},
                "film": {"values": ["5 µm", "9 µm"]},
            }
        ),
        "study.toml",
    )
    expansion, rate, share, film = layout.axes
    assert [level.text for level in expansion.levels] == ["2.2e-05 1/K", "2.3e-05 1/K", "2.4e-05 1/K"]
    assert [level.number for level in rate.levels] == [0.5, 2.0]
    assert [level.number for level in share.levels] == [1e-6, 2e-6]
    assert [level.number for level in film.levels] == [5.0, 9.0]
    assert [axis.unit for axis in layout.axes] == ["1/K", "1/s", "", "µm"]
    assert [axis.column for axis in (expansion, rate)] == ["expansion_1_K", "rate_1_s"]


def test_what_begins_with_a_number_and_names_no_unit_is_a_word() -> None:
    names = ["10mm.stl", "5in.stl", "20x30", "2 of 3"]
    [axis] = Layout(study({"male": {"values": names}}), "study.toml").axes
    assert [(level.text, level.number) for level in axis.levels] == [(name, None) for name in names]


@pytest.mark.parametrize("method", ["random", "latin-hypercube", "sobol"])
def test_drawn_axes_follow_their_distribution_and_their_seed(method: str) -> None:
    axes = {
        "even": {"uniform": {"from": 2, "to": 4}},
        "bell": {"normal": {"mean": "200 degC", "sd": "5 degC"}},
        "skew": {"lognormal": {"median": 3, "factor": 2}},
    }
    sampling = {"method": method, "count": 2048, "seed": 7}
    layout = Layout(study(axes, sampling=sampling), "study.toml")
    even, bell, skew = (np.array([level.number for level in axis.levels]) for axis in layout.axes)
    # The standard error of the mean is sd / sqrt(2048): four of them are allowed.
    assert abs(even.mean() - 3.0) < 4 * (2 / np.sqrt(12)) / np.sqrt(2048)
    assert abs(bell.mean() - 200.0) < 4 * 5 / np.sqrt(2048)
    assert bell.std() == pytest.approx(5.0, rel=0.1)
    assert np.median(skew) == pytest.approx(3.0, rel=0.1)
    assert even.min() >= 2.0
    assert even.max() <= 4.0
    again = Layout(study(axes, sampling=sampling), "study.toml")
    assert [axis.levels for axis in layout.axes] == [axis.levels for axis in again.axes]
    other = Layout(study(axes, sampling={**sampling, "seed": 8}), "study.toml")
    assert [axis.levels for axis in layout.axes] != [axis.levels for axis in other.axes]


def test_a_latin_hypercube_has_one_sample_in_each_slice() -> None:
    axes = {"a": {"uniform": {"from": 0, "to": 1}}}
    layout = Layout(study(axes, sampling={"method": "latin-hypercube", "count": 50, "seed": 1}), "study.toml")
    values = np.array([level.number for level in layout.axes[0].levels])
    assert sorted(np.floor(values * 50).astype(int)) == list(range(50))


@pytest.mark.parametrize(
    ("text", "filled"),
    [
        ("{750 * (1 - share)} W", "562.5 W"),
        ("{gap}", "2 mm"),
        ("{gap * 2} mm", "4.0 mm"),
        ("{count}x{count + 1}", "20x21"),
        ("{max(0.1, share) + sqrt(4)}", "2.25"),
        ("{0.1 + 0.2}", "0.3"),
    ],
)
def test_formulas_give_what_they_say(text: str, filled: str) -> None:
    texts, numbers = {"gap": "2 mm", "share": "0.25", "count": "20"}, {"gap": 2.0, "share": 0.25, "count": 20}
    assert fill(text, texts, numbers) == filled


@pytest.mark.parametrize(
    "text",
    [
        "{none}",
        "{share ** 99}",
        "{__import__('os')}",
        "{share.real}",
        "{1 / 0}",
        "{law * 2}",
        "{sqrt(0 - 1)}",
        "{[1]}",
        "{'a' * 9}",
    ],
)
def test_nothing_but_arithmetic_is_done(text: str) -> None:
    with pytest.raises(TemplateError):
        fill(text, {"share": "0.25", "law": "gent"}, {"share": 0.25, "law": None})


def test_a_step_is_known_by_the_contents_of_its_files(tmp_path: Path) -> None:
    (tmp_path / "k.csv").write_text("1")
    (tmp_path / "mold.toml").write_text('conductivity = { table = "k.csv" }\nh = "1 W"\n')
    more = {
        "document": {"mold": {"from": "mold.toml", "set": {"h": "{a} W"}}},
        "step": [{"name": "one", "command": "add", "arguments": ["{mold}"]}],
    }

    def keys() -> list[str]:
        plan = Plan(study({"a": {"values": [1, 2]}}, **more), str(tmp_path / "study.toml"), Inputs())
        return [case.steps[0].key for case in plan]

    first = keys()
    assert first == keys()
    assert len(set(first)) == 2
    # A table that the document names is part of what decides the result; its modification time is not.
    (tmp_path / "k.csv").write_text("2")
    assert not set(first) & set(keys())
    (tmp_path / "k.csv").write_text("1")
    assert first == keys()


def test_main_effects_and_the_front_are_those_of_a_known_function() -> None:
    plan_axes = Layout(study({"a": {"values": [1, 2, 3]}, "b": {"values": [0, 10]}}), "study.toml").axes
    rows = [(a, b) for a in (1, 2, 3) for b in (0, 10)]
    columns = {
        "case": [f"c{n}" for n in range(6)],
        "a": [a for a, _ in rows],
        "b": [b for _, b in rows],
        "f": [float(a + b) for a, b in rows],
    }
    table = Table(columns, {"a": "a", "b": "b"}, ["f"])
    effects = {effect.axis: effect for effect in main_effects(table, plan_axes)}
    assert effects["a"].means == [6.0, 7.0, 8.0]
    assert effects["b"].means == [2.0, 12.0]
    # Without interaction the shares add up to one: variances 2/3 and 25 of 25 + 2/3.
    assert effects["a"].variance_share == pytest.approx((2 / 3) / (25 + 2 / 3))
    assert effects["a"].variance_share + effects["b"].variance_share == pytest.approx(1.0)


def test_the_front_is_what_no_other_point_beats() -> None:
    rng = np.random.default_rng(5)
    x, y = rng.integers(0, 30, 200).astype(float), rng.integers(0, 30, 200).astype(float)
    x[3] = np.nan
    beaten = [
        bool(np.any((x <= a) & (y <= b) & ((x < a) | (y < b)))) or bool(np.isnan(a)) for a, b in zip(x, y, strict=True)
    ]
    assert pareto_front(x, y).tolist() == np.flatnonzero(~np.array(beaten)).tolist()


def test_an_axis_of_many_levels_is_gathered_into_classes() -> None:
    count = 1000
    axes = Layout(study({"a": {"range": {"from": 1, "to": count, "count": count}}}), "study.toml").axes
    values = [float(n) for n in range(1, count + 1)]
    columns = {"case": [f"c{n}" for n in range(count)], "a": values, "f": [2.0 * value for value in values]}
    (effect,) = main_effects(Table(columns, {"a": "a"}, ["f"]), axes)
    assert effect.levels == [100.5, 300.5, 500.5, 700.5, 900.5]
    assert effect.means == [201.0, 601.0, 1001.0, 1401.0, 1801.0]
    assert effect.variance_share == pytest.approx((count**2 - 200**2) / (count**2 - 1))


@pytest.mark.parametrize("words", [["--mold=part.stl"], ["heat.json:plate"], ["--tests=lab/k17.xlsx:Warp 2"]])
def test_a_file_is_named_behind_its_option_and_before_its_part_too(tmp_path: Path, words: list[str]) -> None:
    name = re.sub(r"^--[a-z]+=|:[^:]+$", "", words[0])
    file = tmp_path / name
    file.parent.mkdir(exist_ok=True)
    more = {"step": [{"name": "one", "command": "add", "arguments": [*words, "{a}"]}]}

    def step() -> Step:
        plan = Plan(study({"a": {"values": [1, 2]}}, **more), str(tmp_path / "study.toml"), Inputs())
        return plan.case(0).steps[0]

    file.write_text("1")
    first = step()
    # A worker runs elsewhere: its file is found from anywhere, and it is another step where that changes.
    assert first.words[0] == words[0].replace(name, str(file))
    file.write_text("2")
    assert step().key != first.key
