"""Figures with their uncertainty, as people read them: rounded by it, and what it is made of."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest

from hyperfab.chapters.summary import paragraph
from hyperfab.errors import InputError
from hyperfab.report.bands import figure
from hyperfab.report.labels import draw_interval
from hyperfab.report.page.parts import Chart, Source, Table
from hyperfab.report.page.sections import build
from hyperfab.report.page.sections.heat import molds

CONTACT: dict[str, Any] = {
    "format": "hyperfab.contact/1", "converged": True, "force_N": 41.76324, "contact_radius_mm": 30.12, "energy_J": 0.4,
    "stretch_max": 1.5, "stress_max_MPa": 0.31, "force_depth": [[0.0, 0.0], [60.0, 41.76324]],
    "stability": {"stable": True}, "setup": {}, "newton_iterations": 5, "unknowns": 900,
    "uncertainty": {
        "level": 0.95, "method": "linear", "left_out": ["the comparison with --against"],
        "quantities": {
            "force_N": {"sd": 1.4987, "low": 38.83, "high": 44.7, "budget": [
                {"source": "fabric.json: constants of warp, 3 specimens", "share": 0.9},
                {"source": "thickness_mm", "share": 0.1},
            ]},
        },
    },
}  # fmt: skip


@pytest.mark.parametrize(
    ("value", "sd", "shown"),
    [(41.76324, 1.4987, "41.8 ± 1.5"), (41.76324, 3.2, "42 ± 3"), (3021.7, 64.0, "3020 ± 60"),
     (0.30751, 0.00955, "0.308 ± 0.010"),
     (0.30751, 0.0096, "0.308 ± 0.010"), (12.0, 0.0, "12")],
)  # fmt: skip
def test_a_figure_is_rounded_by_its_standard_deviation(value: float, sd: float, shown: str) -> None:
    assert figure(value, sd) == shown


def test_the_summary_tells_the_band_and_what_it_is_made_of() -> None:
    lines = paragraph(CONTACT)
    assert "force 41.8 ± 1.5 N, contact radius 30.12 mm" in lines[0]
    assert "constants of warp, 3 specimens 90 %, thickness_mm 10 %" in lines[-1]
    bare = {key: value for key, value in CONTACT.items() if key != "uncertainty"}
    assert "force 41.76 N" in paragraph(bare)[0]
    assert not any("uncertainty" in line for line in paragraph(bare))


def test_the_page_shows_bands_and_budget() -> None:
    def gone(name: str) -> bytes:
        raise InputError("is gone", file=name)

    section = build(Source("contact.json", "contact", "0" * 64, CONTACT, gone))
    assert section.figures[0].text == "41.8 ± 1.5 N"
    table = next(one for one in section.parts if isinstance(one, Table) and one.caption.startswith("How sure"))
    assert [cell.text for cell in table.rows[0]][:2] == ["force, N", "41.8 ± 1.5 N"]
    picture = next(one for one in section.parts if isinstance(one, Chart) and "made of" in one.caption)
    assert [trace["y"] for trace in picture.data] == [[90.0], [pytest.approx(10.0)]]


def test_a_warm_up_is_rounded_alike_in_the_summary_and_all_over_the_page() -> None:
    """At 50.01 min one place said 50.01, one 50.0 and one 50."""
    data: dict[str, Any] = {
        "format": "hyperfab.heat/1", "converged": True, "warmup_time_s": 3000.6, "target_degC": 200.0, "mass_kg": 20.7,
        "efficiency": 0.92, "steps": 12, "unknowns": 900, "probes": {}, "setup": {}, "files": [],
        "energy": {"supplied_J": 3.5e6, "lost_J": 2.7e5, "stored_J": 3.2e6, "imbalance_relative": 1e-13},
    }  # fmt: skip
    assert "warm-up in 50.0 min" in "\n".join(paragraph(data))
    source = Source("heat.json", "heat", "0" * 64, data, lambda name: b"")
    found = build(source)
    compared = molds([source, source])
    assert compared is not None
    cells = [
        cell.text
        for table in (*(part for part in found.parts if isinstance(part, Table)), compared)
        for row in table.rows
        for cell in row
    ]
    told = [*cells, found.claim, found.verdict, *(one.text for one in found.figures)]
    minutes = [match for text in told for match in re.findall(r"[\d.]+ min", text)]
    assert len(minutes) >= 5
    assert set(minutes) == {"50.0 min"}


@pytest.mark.parametrize(("female", "told"), [(25.0, "gap at 25 degC 1.00"), (180.0, "gap at 25 and 180 degC 1.00")])
def test_a_gap_is_told_at_the_temperature_of_the_molds(female: float, told: str) -> None:
    data: dict[str, Any] = {
        "format": "hyperfab.press/1", "contact_fraction": 0.5, "contact_area_mm2": 9.0, "force_N": 3.0,
        "pressure_max_MPa": 0.01, "gap_min_mm": 1.0, "gap_mean_mm": 2.0, "gap_max_mm": 3.0, "converged": True,
        "reference_temperature_degC": 20.0, "male": {"temperature_degC": 25.0}, "female": {"temperature_degC": female},
    }  # fmt: skip
    assert any(told in line for line in paragraph(data))


def test_bars_in_pictures_run_from_end_to_end_of_the_intervals() -> None:
    from matplotlib.figure import Figure

    axes = Figure().add_subplot()
    draw_interval(axes, (2.0, 10.0), force=(8.5, 12.0), across=(1.5, 2.25), colour="black")
    ends = [bars.get_segments()[0] for bars in axes.collections]
    np.testing.assert_allclose(ends, [[[1.5, 10.0], [2.25, 10.0]], [[2.0, 8.5], [2.0, 12.0]]])
    before = len(axes.collections)
    draw_interval(axes, (2.0, 10.0), colour="black")
    assert len(axes.collections) == before
