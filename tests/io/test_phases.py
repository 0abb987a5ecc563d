"""A test that a machine writes phase by phase, a table each, is one test."""

from __future__ import annotations

import numpy as np
import pytest

from hyperfab.arrays import Array
from hyperfab.io.csv_tests import read_tests

STRIP = "Tensile test\nWidth;50;mm\nThickness;0.8;mm\nGauge length;100;mm\n"
HEAD = "Time (s);Position (mm);Load (N)\n"


def table(place: Array, pace: float, began: float = 0.0, comma: bool = False) -> str:
    """A phase whose clock begins anew; 0.4 N a mm from ``began``."""
    rows = [f"{k * pace:.3f};{one:.3f};{0.4 * (one - began):.4f}\n" for k, one in enumerate(place)]
    text = "".join(rows)
    return text.replace(".", ",") if comma else text


@pytest.mark.parametrize("comma", [False, True])
def test_phases_that_go_on_where_the_last_ended_are_one_test(comma: bool) -> None:
    """Pulled to 20 mm, held, pulled to 40 mm at twice the pace and let go: from 300 mm between the grips."""
    places = [np.linspace(300, 320, 11), np.full(5, 320.0), np.linspace(320, 340, 11), np.linspace(340, 300, 21)]
    paces = [0.2, 1.0, 0.1, 0.2]
    text = STRIP + "\n".join(
        f"Speed;{speed};mm/s\n{HEAD}{table(place, pace, 300.0, comma)}"
        for place, pace, speed in zip(places, paces, (10, 0, 20, 10), strict=True)
    )
    [found] = read_tests(text.encode(), "k17.csv")
    assert found.stretch == pytest.approx(1.0 + (np.concatenate(places) - 300.0) / 100.0)
    assert found.stress == pytest.approx(0.4 * (np.concatenate(places) - 300.0) / 40.0)
    assert found.time_s is not None
    assert np.all(np.diff(found.time_s) >= 0.0)
    assert found.time_s[-1] == pytest.approx(2.0 + 4.0 + 1.0 + 4.0)
    assert found.specimen is None, "phases are no specimens"
    assert found.rate_1_s is None  # each phase had its own


def test_specimens_one_under_another_stay_apart() -> None:
    places = [np.linspace(300, 340, 11), np.linspace(300, 350, 11), np.linspace(300, 330, 11)]
    text = STRIP + "\n".join(HEAD + table(place, 0.2, 300.0) for place in places)
    found = read_tests(text.encode(), "k17.csv")
    assert [part.specimen for part in found] == ["1", "2", "3"]
    assert [part.stretch.max() for part in found] == pytest.approx([1.4, 1.5, 1.3])
    # Each pulled and let go again: the next begins where the last ended, at rest.
    there = [np.concatenate([place, place[::-1]]) for place in places]
    text = STRIP + "\n".join(HEAD + table(place, 0.2, 300.0) for place in there)
    assert len(read_tests(text.encode(), "k17.csv")) == 3


@pytest.mark.parametrize("wander", [0.0, 0.4])
def test_an_extension_that_begins_anew_with_each_part_of_a_cycle_gives_way_to_the_length_beside_it(
    wander: float,
) -> None:
    """A stand that preloads and then counts from there, cycle by cycle: its length alone tells the stretch."""
    parts = [("1-Preload", 30.0, 31.0), ("1-Stretch", 31.0, 36.0), ("1-Recover", 36.0, 31.0), ("2-Stretch", 31.0, 36.0)]
    rows, lengths = [], []
    for name, start, end in parts:
        anew = start if name.endswith(("Preload", "Stretch")) else 31.0
        for k, length in enumerate(np.linspace(start, end, 11)):
            moved = length - anew + wander * np.sin(k)  # an extensometer's own way is no count anew
            rows.append(f"Ramp,{name},{len(rows) * 0.2:.1f},{length:.3f},{moved:.3f},{0.5 * (length - 30.0):.4f}\n")
            lengths.append(length)
    head = "# test: uniaxial\n# width: 5 mm\n# thickness: 2 mm\n"
    if wander:
        head += "# gauge length: 30 mm\n"
    text = f"{head}SetName,Cycle,Time_S,Size_mm,Displacement_mm,Force_N\n{''.join(rows)}"
    [found] = read_tests(text.encode(), "a.csv")
    assert found.cycle is not None
    assert found.time_s is not None
    assert found.cycle.tolist() == [1] * 33 + [2] * 11
    assert found.time_s[-1] == pytest.approx(8.6)
    assert ("Displacement_mm begins anew in mid-test; Size_mm is taken" in found.notes) is (wander == 0.0)
    if not wander:
        assert found.stretch == pytest.approx(np.array(lengths) / 30.0, abs=1e-4)


@pytest.mark.parametrize(
    ("title", "cell"),
    [("length [mm]", ""), ("gap [mm]", "n/a"), ("length [%]", "104"), ("size [kB]", "7"), ("size_min_mm", "5")],
)
def test_a_length_beside_an_extension_may_lack_readings_or_be_none(title: str, cell: str) -> None:
    rows = "".join(f"{k},{2 * k},{50 + k if k % 3 else cell}\n" for k in range(12))
    sizes = "# test: uniaxial\n# width: 10 mm\n# thickness: 2 mm\n# gauge length: 50 mm\n"
    [found] = read_tests(f"{sizes}extension [mm],force [N],{title}\n{rows}".encode(), "a.csv")
    assert found.stretch == pytest.approx(1.0 + np.arange(12) / 50.0)
