"""Measured curves as spring laws: what is averaged, levelled, cut off and refused, with the numbers that come out."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from hyperfab.chapters.drape.curves import read_curve
from hyperfab.chapters.job import Job
from hyperfab.console import Console
from hyperfab.errors import InputError


class Listening(Console):
    def __init__(self) -> None:
        super().__init__(True)
        self.said: list[str] = []

    def note(self, *texts: str) -> None:
        self.said += texts

    def warn(self, *texts: str) -> None:
        self.said += texts


@pytest.fixture
def read(tmp_path: Path):
    def run(text: str, thickness: float | None = None, direction: float = 0.0):
        (tmp_path / "test.csv").write_text(text)
        console = Listening()
        job = Job("drape", [], console)
        return read_curve(job, "--warp-test", str(tmp_path / "test.csv"), direction, thickness), console.said

    return run


HEAD = "stretch [-],stress [MPa]\n"


def rows(*pairs: tuple[float, float]) -> str:
    return HEAD + "".join(f"{a},{b}\n" for a, b in pairs)


def test_a_curve_is_taken_as_it_stands_up_to_its_last_reading(read):
    curve, said = read(rows((1.0, 0.0), (1.2, 0.1), (1.5, 0.4), (1.8, 1.0)))
    assert [line.split(": ", 1)[1] for line in said] == ["1 row left out: not stretched"]
    assert curve.tested == 1.8
    assert curve.fails_at is None
    assert curve.thickness is None
    assert curve.per_width is False
    stretch = [1.1, 1.2, 1.35, 1.8, 2.1]
    # Straight between readings, and on with the last slope, 2 MPa.
    assert curve.law(stretch)[1] == pytest.approx([0.05, 0.1, 0.25, 1.0, 1.6], rel=1e-12)
    # Energy: the area under it, triangles and trapezes.
    assert float(curve.law(1.8)[0][0]) == pytest.approx(0.5 * 0.2 * 0.1 + 0.3 * 0.25 + 0.3 * 0.7, rel=1e-12)


def test_the_way_back_is_left_out(read):
    curve, said = read(rows((1.0, 0.0), (1.2, 0.1), (1.5, 0.4), (1.2, 0.02), (1.0, 0.0)))
    assert curve.law([1.2, 1.5])[1] == pytest.approx([0.1, 0.4], rel=1e-12)
    assert any("2 rows left out: unloading" in line for line in said)


def test_of_pulls_that_nothing_numbers_the_first_is_taken(read):
    """The second goes farther and is softer: its rows, and the way back between both, are no law of the first."""
    first, second = [(1.2, 0.2), (1.5, 0.6), (1.25, 0.1)], [(1.05, 0.01), (1.4, 0.2), (1.8, 0.7)]
    curve, said = read(rows((1.0, 0.0), *first, *second))
    assert curve.tested == 1.5
    assert curve.law([1.2, 1.35, 1.5])[1] == pytest.approx([0.2, 0.4, 0.6], rel=1e-12)
    assert any("4 rows left out: unloading and later pulls" in line for line in said)


def test_specimens_are_averaged_as_far_as_all_of_them_go(read):
    """Read at 1.2, 1.4 and at 1.3, 1.5: between readings straight; beyond 1.4 one of them has no say."""
    text = "specimen,stretch [-],stress [MPa]\na,1,0\na,1.2,0.2\na,1.4,0.4\nb,1,0\nb,1.3,0.6\nb,1.5,1.0\n"
    curve, said = read(text)
    assert curve.tested == pytest.approx(1.4)
    expected = [0.5 * (0.2 + 0.4), 0.5 * (0.3 + 0.6), 0.5 * (0.4 + 0.8)]
    assert curve.law([1.2, 1.3, 1.4])[1] == pytest.approx(expected, rel=1e-12)
    assert any("1 row left out: beyond the stretch that all specimens reach" in line for line in said)


def test_a_stress_that_falls_is_levelled_to_the_nearest_rising_curve(read):
    """0.5 before 0.3 becomes 0.4 twice: the least squares that rise; how far readings moved is said."""
    curve, said = read(rows((1.0, 0.0), (1.1, 0.2), (1.2, 0.5), (1.3, 0.3), (1.4, 1.0)))
    assert curve.law([1.1, 1.2, 1.3, 1.4])[1] == pytest.approx([0.2, 0.4, 0.4, 1.0], rel=1e-12)
    assert any("2 of 5 readings were moved, by up to 10 % of the peak" in line for line in said)
    curve, _ = read(rows((1.0, 0.0), (1.1, 0.6), (1.2, 0.5), (1.3, 0.1), (1.4, 1.0)))
    assert curve.law([1.1, 1.2, 1.3])[1] == pytest.approx([0.4, 0.4, 0.4], rel=1e-12)


def test_a_specimen_that_fails_ends_the_curve_at_its_peak(read):
    curve, said = read(rows((1.0, 0.0), (1.2, 0.2), (1.6, 1.0), (1.7, 0.5), (1.8, 0.3)))
    assert curve.fails_at == 1.6
    assert curve.tested == 1.6
    assert curve.law([1.6, 1.8])[1] == pytest.approx([1.0, 1.4], rel=1e-12)
    assert any("2 rows left out: after the peak stress" in line for line in said)
    # A tenth below the peak is no failure.
    whole, _ = read(rows((1.0, 0.0), (1.2, 0.2), (1.6, 1.0), (1.7, 0.95)))
    assert whole.fails_at is None
    assert whole.tested == 1.7


def test_force_a_width_becomes_stress_by_the_thickness(read):
    text = "stretch [-],membrane stress [N/mm]\n1,0\n1.2,0.1\n1.5,0.4\n"
    curve, _ = read(text, thickness=0.8)
    assert curve.law(1.5)[1] == pytest.approx([0.5], rel=1e-12)
    assert curve.thickness == pytest.approx(0.8)
    assert curve.per_width is False
    bare, _ = read(text)
    assert bare.law(1.5)[1] == pytest.approx([0.4], rel=1e-12)
    assert bare.per_width is True


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (rows((1.0, 0.0), (0.9, -0.1)), "fewer than two readings|tension"),
        (rows((1.0, 0.0), (1.2, 0.0), (1.5, 0.4)), "does not rise from zero"),
    ],
)
def test_a_curve_that_is_no_spring_is_refused(read, text, words):
    with pytest.raises(InputError, match=words):
        read(text)


def test_a_test_of_another_direction_is_refused(read):
    text = "# direction: weft\n" + rows((1.0, 0.0), (1.2, 0.2), (1.5, 0.4))
    with pytest.raises(InputError, match="exchange the files"):
        read(text)
    curve, _ = read(text, direction=90.0)
    assert float(curve.law(1.5)[1][0]) == pytest.approx(0.4)


def test_curves_that_meet_at_the_same_stretch_are_averaged_there(read):
    """Two readings of one stretch count half each."""
    curve, _ = read(rows((1.0, 0.0), (1.2, 0.1), (1.2, 0.3), (1.5, 0.8)))
    assert np.asarray(curve.law(1.2)[1])[0] == pytest.approx(0.2, rel=1e-12)
