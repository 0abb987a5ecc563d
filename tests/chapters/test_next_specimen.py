"""Where the next specimen is to be expected: laboratories drawn at random, and measured knits left out in turn."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from conftest import Run

from hyperfab.chapters.fit.replicates import band, next_specimens
from hyperfab.curve import TestCurve
from hyperfab.io.csv_tests import read_tests


def specimens(count: int, scatter: float, noise: float, draw: np.random.Generator) -> list[TestCurve]:
    """Return curves that differ in stiffness and in slack, read at stretches of their own."""
    found = []
    for number in range(count):
        lam = np.sort(draw.uniform(1.0, 1.8, 60))
        strain = np.maximum(lam - 1.0 - 0.01 * draw.standard_normal(), 0.0)
        stress = (strain + strain**3) * (1.0 + scatter * draw.standard_normal())
        read = stress + noise * draw.standard_normal(len(lam))
        found.append(TestCurve("uniaxial", lam, read, source="lab", specimen=str(number)))
    return found


def share_within(known: list[TestCurve], new: TestCurve) -> tuple[float, int]:
    """Return the share of a new specimen's readings within the band of the others, and how many it speaks of."""
    (one,) = next_specimens(known)
    rows = (new.stretch >= one.stretch[0]) & (new.stretch <= one.stretch[-1])
    low, high = (np.interp(new.stretch[rows], one.stretch, end) for end in (one.low_MPa, one.high_MPa))
    read = new.stress[rows]
    return float(np.mean((read >= low) & (read <= high))), int(rows.sum())


@pytest.mark.parametrize(("scatter", "noise"), [(0.05, 0.0), (0.05, 0.03), (0.002, 0.03)])
@pytest.mark.parametrize("count", [3, 4, 8])
def test_readings_of_another_specimen_are_within_as_often_as_stated(count: int, scatter: float, noise: float) -> None:
    draw = np.random.default_rng(count)
    labs = [specimens(count + 1, scatter, noise, draw) for _ in range(300)]
    shares = [share_within(known, new)[0] for *known, new in labs]
    # 300 specimens, each on one side all along: 0.95 is known within 0.0126, one standard deviation.
    assert np.mean(shares) == pytest.approx(0.95, abs=0.03)


def test_specimens_that_differ_by_chance_alone_give_students_interval() -> None:
    """Exact where curves are straight between knots: mean -+ t times sd times the root of 1 + 1/n."""
    lam = np.linspace(1.0, 2.0, 23)
    factors = np.array([0.8, 1.0, 1.1, 1.3])
    stretch, low, high = band([(lam, k * (lam - 1.0)) for k in factors], (1.0, 2.0))
    half = 3.182446305284263 * factors.std(ddof=1) * np.sqrt(1.25)
    np.testing.assert_allclose(high, (factors.mean() + half) * (stretch - 1.0), atol=1e-6)
    np.testing.assert_allclose(low, (factors.mean() - half) * (stretch - 1.0), atol=1e-6)


def test_one_specimen_tells_nothing_of_the_next() -> None:
    assert next_specimens(specimens(1, 0.05, 0.01, np.random.default_rng(1))) == []


def test_rows_of_one_specimen_in_two_curves_are_one_specimen() -> None:
    one, two, three = specimens(3, 0.05, 0.01, np.random.default_rng(2))
    halves = [one.take(one.stretch < 1.4), one.take(one.stretch >= 1.4)]
    assert next_specimens([*halves, two, three]) == next_specimens([one, two, three])


@pytest.mark.parametrize("knit", ["knit-acrylic-rib", "knit-acrylic-stockinette"])
def test_knits_measured_five_times_foretell_each_of_their_curves(data_dir: Path, knit: str) -> None:
    shares = []
    for way in ("warp", "weft"):
        file = data_dir / knit / f"uniaxial-{way}.csv"
        every = read_tests(file.read_bytes(), str(file))
        assert len(every) == 5
        for left in range(5):
            known = [one for number, one in enumerate(every) if number != left]
            shares.append(share_within(known, every[left])[0])
    # Ten curves, each of them on one side nearly all along: a chance of 0.95 shows between 0.8 and 1.
    assert 0.9 <= np.mean(shares) <= 1.0


@pytest.mark.pictures
def test_fit_tells_the_band_with_each_direction_and_draws_it(hf: Run, tmp_path: Path) -> None:
    draw = np.random.default_rng(5)
    for way, stiffer in (("warp", 1.0), ("weft", 0.5)):
        rows = [
            f"{one.specimen},{lam!r},{stiffer * read!r}"
            for one in specimens(3, 0.05, 0.005, draw)
            for lam, read in zip(one.stretch.tolist(), one.stress.tolist(), strict=True)
        ]
        head = f"# test: uniaxial\n# direction: {way}\nspecimen,stretch [-],stress [MPa]\n"
        (tmp_path / f"{way}.csv").write_text(head + "\n".join(rows) + "\n")
    done = hf(
        "fit", "--uniaxial", "warp.csv", "--uniaxial", "weft.csv", "--model", "yeoh-3", "--objective", "absolute",
        "-o", "m.json", cwd=tmp_path,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr.decode()
    document = json.loads((tmp_path / "m.json").read_text())
    assert "next_specimen" not in document["fit"]["uncertainty"]
    ends = {}
    for way in ("warp", "weft"):
        (one,) = document["directions"][way]["fit"]["uncertainty"]["next_specimen"]
        assert (one["test"], one["direction"], one["specimens"], one["level"]) == ("uniaxial", way, 3, 0.95)
        assert np.all(np.diff(one["stretch"]) > 0.0)
        ends[way] = 0.5 * (one["low_MPa"][-1] + one["high_MPa"][-1])
    assert ends["weft"] == pytest.approx(0.5 * ends["warp"], rel=0.15)
