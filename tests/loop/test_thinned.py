"""Tests that a machine logged much closer than any law bends."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from conftest import Run

from hyperfab.curve import TestCurve
from hyperfab.loop.fabric_tests import thinned

MODEL = {"format": "hyperfab.material/1", "model": "neo-hookean", "parameters": {"C10_MPa": 0.15}}


def led(each: int) -> TestCurve:
    """Return a pull, a hold, and the way back, each read so many times."""
    strain = np.concatenate([np.linspace(0.0, 0.5, each), np.full(each, 0.5), np.linspace(0.5, 0.0, each)])
    return TestCurve("uniaxial", 1.0 + strain, 2.0 * strain, time_s=np.arange(3.0 * each), source="logged.csv")


def test_each_way_and_hold_keeps_its_ends_and_what_tells_its_curve() -> None:
    every = led(5000)
    few = thinned(every)
    assert len(few.stretch) < 1000
    assert few.time_s is not None
    assert {0.0, 4999.0, 14999.0} <= {*few.time_s}
    assert np.min(np.abs(few.time_s - 10000.0)) < 10.0  # what moves by less than a reading tells is held
    went = few.time_s[few.time_s <= 4999.0]
    assert np.max(np.diff(went)) <= 20.0
    held = few.time_s[(few.time_s > 4999.0) & (few.time_s <= 9999.0)] - 4999.0
    assert np.count_nonzero(held < 50.0) > 20  # a stress that relaxes does most of it at once
    assert np.max(np.diff(held)) <= 50.0


def test_tests_read_no_closer_than_they_bend_are_taken_whole() -> None:
    every = led(250)
    assert thinned(every).stretch.tolist() == every.stretch.tolist()


def test_what_is_not_taken_is_counted(hf: Run, tmp_path: Path) -> None:
    """Two thousand readings of each way, of a sheet that is softer when it is hot."""
    random = np.random.default_rng(3)
    strain = np.concatenate([np.linspace(0.0, 0.5, 2000), np.linspace(0.5, 0.0, 2000)])
    stress = 0.3 * (1.0 + strain - (1.0 + strain) ** -2)
    (tmp_path / "model.json").write_text(json.dumps(MODEL))
    for celsius, softer in ((23, 1.0), (80, 0.8)):
        read = softer * stress + 0.001 * random.standard_normal(len(strain))
        lines = ["# test: uniaxial", f"# temperature: {celsius} degC", "time [s],strain [-],stress [MPa]"]
        rows = zip(np.arange(len(strain)) * 1e-2, strain, read, strict=True)
        lines += [",".join(f"{value:.6g}" for value in row) for row in rows]
        (tmp_path / f"{celsius}.csv").write_text("\n".join(lines))
    done = hf("close-loop", "model.json", "23.csv", "80.csv", cwd=tmp_path)
    found = json.loads(done.stdout)
    assert found["left_out"] == {f"{name}.csv: between readings that tell as much": 3400 for name in ("23", "80")}
    assert [effect["id"] for effect in found["effects"]] == ["thermal-softening"]
    assert found["error"]["after"]["rms"] == pytest.approx(0.001, rel=0.1)
