"""Figures of a material document against ordinary regression and hand-made scatter, with their sizes."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from conftest import Run
from matplotlib.figure import Figure

from hyperfab.chapters.fit.identify import Identified, Setting, identify
from hyperfab.chapters.fit.siblings import _general, line
from hyperfab.curve import TestCurve
from hyperfab.materials import bind
from hyperfab.materials.registry import law
from hyperfab.materials.stability import stable_ranges
from hyperfab.report.figures_fit import _panel

from .test_fit import fit

STRETCH = np.linspace(1.1, 2.4, 14)
#: dW/dI1 of a uniaxial test: neo-Hooke's law is ``C10`` times this.
SHAPE = 2.0 * (STRETCH - STRETCH**-2)


def write(path: Path, stretch: np.ndarray, stress: np.ndarray, **head: str) -> Path:
    lines = [f"# {key}: {value}" for key, value in head.items()]
    rows = [f"{a!r},{b!r}" for a, b in zip(stretch.tolist(), stress.tolist(), strict=True)]
    path.write_text("\n".join([*lines, "stretch [-],stress [MPa]", *rows]) + "\n")
    return path


def test_a_reading_that_does_not_belong_is_told_with_its_distance_and_its_leverage(hf: Run, tmp_path: Path) -> None:
    """A relative fit of one constant: what regression says of row 10, which is half of what it should be."""
    ripple = 1.0 + 0.002 * (-1.0) ** np.arange(14)
    stress = 0.2 * SHAPE * ripple
    stress[9] *= 0.5
    name = write(tmp_path / "test.csv", STRETCH, stress, thickness="1 mm")
    found = fit(hf, "--uniaxial", name, "--model", "neo-hookean", "--accept", "0.9")
    column = SHAPE / stress
    c = float(column.sum() / (column @ column))
    left = 1.0 - c * column
    assert found["parameters"]["C10_MPa"] == pytest.approx(c, rel=1e-9)
    assert (found["setup"]["thickness_mm"], found["setup"]["derived"]) == (1.0, ["thickness_mm"])
    told = found["fit"]
    assert told["E2"] == pytest.approx(float(left @ left), rel=1e-9)
    assert told["relative_rms"] == pytest.approx(np.sqrt(np.mean(left**2)), rel=1e-9)
    error = c * SHAPE - stress
    assert told["nrmse"] == pytest.approx(np.sqrt(np.mean(error**2)) / stress.max(), rel=1e-9)
    assert told["points"] == 14
    assert told["condition_number"] == pytest.approx(1.0, rel=1e-9)
    assert told["correlation"] == [[pytest.approx(1.0)]]
    test = told["tests"]["uniaxial"]
    assert (test["stretch_min"], test["stretch_max"], test["points"]) == (1.0, pytest.approx(2.4), 14)
    [outlier] = told["outliers"]
    leverage = column**2 / (column @ column)
    without = (float(left @ left) - left[9] ** 2 / (1.0 - leverage[9])) / 12.0
    assert outlier["line"] == 12  # two lines of heading, then the tenth
    assert outlier["test"] == "uniaxial"
    assert outlier["stretch"] == pytest.approx(STRETCH[9], rel=1e-12)
    assert outlier["stress_MPa"] == pytest.approx(stress[9], rel=1e-12)
    assert outlier["leverage"] == pytest.approx(leverage[9], rel=1e-6)
    assert abs(outlier["studentised"]) == pytest.approx(abs(left[9]) / np.sqrt(without * (1.0 - leverage[9])), rel=1e-6)


def test_specimens_that_differ_by_a_tenth_scatter_so_much(hf: Run, tmp_path: Path) -> None:
    """Stiffer and softer by 5 %: between two, a standard deviation of 0.1/sqrt(2) of the mean at each stretch."""
    files = [
        write(tmp_path / f"{name}.csv", STRETCH, factor * 0.2 * SHAPE, thickness="1 mm", specimen=name)
        for name, factor in (("soft", 0.95), ("stiff", 1.05))
    ]
    found = fit(hf, "--uniaxial", files[0], "--uniaxial", files[1], "--model", "neo-hookean", "--accept", "0.9")
    [kind] = found["replicates"]
    assert kind["specimens"] == 2
    assert kind["test"] == "uniaxial"
    # At 21 stretches between the ends, straight between readings, over the largest of both.
    mean = np.interp(np.linspace(1.1, 2.4, 21), STRETCH, 0.2 * SHAPE)
    expected = np.sqrt(np.mean((0.1 / np.sqrt(2.0) * mean) ** 2)) / (1.05 * 0.2 * SHAPE.max())
    assert kind["scatter"] == pytest.approx(expected, rel=1e-9)


def test_the_range_of_stability_is_told_with_what_ends_it(hf: Run, tmp_path: Path) -> None:
    """Readings of a law that softens: the fit finds its constants, and where they become unstable."""
    truth = {"C10_MPa": 0.3, "C20_MPa": -0.03}
    x = STRETCH**2 + 2.0 / STRETCH - 3.0
    stress = SHAPE * (0.3 - 0.06 * x)
    name = write(tmp_path / "test.csv", STRETCH[:9], stress[:9], thickness="1 mm")
    found = fit(hf, "--uniaxial", name, "--model", "yeoh-2")
    assert found["parameters"] == pytest.approx(truth, rel=1e-6)
    seen = stable_ranges(bind("yeoh-2", truth))["uniaxial"]
    told = found["stability"]["uniaxial"]
    assert told["ended_by"] == "instability"
    assert told["stretch_max"] == pytest.approx(seen.high, rel=1e-5)
    assert told["first_unstable_stretch"] == pytest.approx(seen.first_unstable, rel=1e-5)
    # In uniaxial tension t = P l; with e = ln l free to contract, instability comes no later than that of dt/de = 0.
    fine = np.linspace(1.0, 3.0, 200_001)
    y = fine**2 + 2.0 / fine - 3.0
    t = fine * 2.0 * (fine - fine**-2) * (0.3 - 0.06 * y)
    assert told["first_unstable_stretch"] <= fine[np.argmax(t)] + 1e-4
    assert told["first_unstable_stretch"] > 1.2


def test_readings_on_the_way_back_are_drawn_apart() -> None:
    stretch = np.array([1.0, 1.5, 2.0, 1.5, 1.1])
    curve = TestCurve("uniaxial", stretch, np.array([0.0, 0.4, 1.0, 0.2, 0.0]))
    drawn = line([curve], None, (stretch, stretch), ["uniaxial"])
    assert drawn.back is not None
    assert drawn.back.tolist() == [False, False, False, True, True]
    told = replace(curve, branch=np.array([1, 1, 1, 1, -1]))
    assert line([told], None, (stretch, stretch), ["uniaxial"]).back.tolist() == [False] * 4 + [True]  # type: ignore[union-attr]
    axes = Figure().add_subplot()
    _panel(axes, "", [drawn], (0.0, 1.0))
    assert [len(one.get_xdata()) for one in axes.lines][:2] == [3, 2]
    assert "unloading" in [text.get_text() for text in axes.get_legend().get_texts()]


def test_tests_of_both_axes_alone_are_drawn_over_the_stretch_of_each(hf: Run, tmp_path: Path) -> None:
    """Two strips of a sheet pulled at once, no plain test beside them: neo-Hooke's stresses, C10 = 0.2 MPa."""
    one, two = np.linspace(1.1, 1.5, 9), np.linspace(1.05, 1.2, 9)
    name = tmp_path / "cross.csv"
    rows = [
        f"{a!r},{b!r},{0.4 * (a - a**-3 * b**-2)!r},{0.4 * (b - b**-3 * a**-2)!r}"
        for a, b in zip(one.tolist(), two.tolist(), strict=True)
    ]
    name.write_text("\n".join(["stretch,stretch 2,stress [MPa],stress 2 [MPa]", *rows]) + "\n")
    done = hf("fit", "--biaxial", name, "--model", "neo-hookean", "-o", tmp_path / "fit.json")
    assert done.returncode == 0, done.stderr.decode()
    assert (tmp_path / "fit.png").read_bytes().startswith(b"\x89PNG")
    curve = TestCurve("biaxial-general", one, one - 1.0, np.ones(9), stretch2=two, stress2=two - 1.0)
    part = identify(law("neo-hookean"), [curve], Setting(("biaxial-general",), True, False, 1.0))
    assert isinstance(part, Identified)
    drawn = _general([curve], None, part, predicted=False)
    assert drawn.stretch.tolist() == [*one, *two]
    assert drawn.stress.tolist() == [*(one - 1.0), *(two - 1.0)]
    (c10,) = part.materials[0].parameters.values()
    first, second = drawn.model[:9], drawn.model[10:19]
    np.testing.assert_allclose(first, 2.0 * c10 * (one - one**-3 * two**-2), rtol=1e-9)
    np.testing.assert_allclose(second, 2.0 * c10 * (two - two**-3 * one**-2), rtol=1e-9)
    assert np.isnan(drawn.grid[[9, 19]]).all()
