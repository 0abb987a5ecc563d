"""A model that tells how each of its specimens was mounted, on specimens that are others and more."""

from __future__ import annotations

import json
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from conftest import Run
from scipy.stats import t as student


def test_specimens_beyond_those_told_begin_at_the_mean(hf: Run, tmp_path: Path) -> None:
    effect = {"id": "grip-slack", "form": "each", "parameters": {"slack": 0.01, "of_test_2": 0.006}}
    model = {
        "format": "hyperfab.material/1",
        "model": "neo-hookean",
        "parameters": {"C10_MPa": 0.3},
        "effects": [effect],
    }
    (tmp_path / "model.json").write_text(json.dumps(model))
    random, stretch, words = np.random.default_rng(4), np.linspace(1.0, 1.8, 40), []
    for number, slack in enumerate((0.004, 0.012, 0.02, 0.008)):
        own = np.maximum(stretch - slack, 1.0)
        stress = 0.6 * (own - own**-2) + 2e-3 * random.standard_normal(40)
        rows = "".join(f"{x:.5f},{y:.5f}\n" for x, y in zip(stretch, stress, strict=True))
        name = f"{number}.csv"
        (tmp_path / name).write_text(f"# test: uniaxial\nstretch,stress [MPa]\n{rows}")
        words += ["--measured", name]
    done = hf("close-loop", "model.json", *words, "-o", "loop.json", cwd=tmp_path)
    assert done.returncode in (0, 1), done.stderr
    found = json.loads((tmp_path / "loop.json").read_text())
    assert found["verdict"] == "noise"
    slack = [value for key, value in found["constants"]["refitted"].items() if key.startswith("grip-slack")]
    np.testing.assert_allclose(slack[0] + np.array([0.0, *slack[1:]]), [0.004, 0.012, 0.02, 0.008], atol=2e-3)
    tested = json.loads((tmp_path / "loop.model.json").read_text())["tested"]["uniaxial"]["stretch"]
    np.testing.assert_allclose(tested, [1.0, 1.8 - 0.004], atol=2e-3)


def test_a_rate_is_no_surer_than_specimens_that_scatter_leave_it(hf: Run, tmp_path: Path) -> None:
    """Pairs at three speeds whose stiffness scatters by 3 %: what those of one speed have in common stands in for the
    rate's constants, whose intervals hold them all the same; so few pairs tell the scatter hardly."""
    turns, draw = (1.0, 1.3, 1.0, 1.6, 1.0), np.random.default_rng(0)
    lam = np.concatenate([[1.0], *(np.linspace(a, b, 41)[1:] for a, b in pairwise(turns))])
    x = lam**2 + 2.0 / lam - 3.0
    elastic = 2.0 * (lam - lam**-2) * (0.12 + 0.024 * x + 0.009 * x * x)
    for number, speed in enumerate(np.repeat([0.002, 0.02, 0.2], 2)):
        time = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(lam)))]) / speed
        branch = np.zeros_like(lam)
        for k, step in enumerate(np.diff(time)):
            fall = np.exp(-step / 10.0)
            branch[k + 1] = fall * branch[k] + 0.4 * (elastic[k + 1] - elastic[k]) * (1.0 - fall) * 10.0 / step
        stress = (1.0 + 0.03 * draw.standard_normal()) * (elastic + branch) + 0.002 * draw.standard_normal(len(lam))
        rows = "".join(f"{t:.9g},{s:.9g},{p:.9g}\n" for t, s, p in zip(time, lam, stress, strict=True))
        head = f"# test: uniaxial\n# specimen: s{number}\ntime [s],stretch [-],stress [MPa]\n"
        (tmp_path / f"{number}.csv").write_text(head + rows)
    given = {"C10_MPa": 0.1, "C20_MPa": 0.02, "C30_MPa": 0.01}
    model = {"format": "hyperfab.material/1", "model": "yeoh-3", "parameters": given}
    (tmp_path / "m.json").write_text(json.dumps(model))
    run = hf("close-loop", "m.json", *(f"{k}.csv" for k in range(6)), "-o", "loop.json", cwd=tmp_path)
    assert run.returncode == 0, run.stderr
    (effect,) = json.loads((tmp_path / "loop.json").read_bytes())["effects"]
    told = json.loads((tmp_path / "loop.model.json").read_bytes())
    joint = told["joint_uncertainty"]
    assert effect["id"] == "rate"
    assert joint["source"] == "specimens"
    assert 3.0 <= joint["degrees_of_freedom"] < 4.0, "of three pairs"
    wide = student.ppf(0.975, joint["degrees_of_freedom"])
    for name, true in (("g1", 0.4), ("tau1_s", 10.0)):
        assert abs(effect["parameters"][name] - true) < wide * effect["parameters_sd"][name], name
        assert effect["parameters_sd"][name] == pytest.approx(told["effects"][0]["parameters_sd"][name], rel=1e-3)
    own = np.sqrt(np.diag(joint["covariance"]))[joint["order"].index("parameters.C10_MPa")]
    assert 0.01 < own / told["parameters"]["C10_MPa"] < 0.05, "the mean of six that scatter by 3 %"
