"""A model that tells how each of its specimens was mounted, on specimens that are others and more."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
from conftest import Run


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
