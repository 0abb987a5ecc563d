"""A fabric with a flat toe: the law that carries over is not the one that lies closest, and that is said."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
from conftest import Run


def fitted(hf: Run, folder: Path, stress: np.ndarray, stretch: np.ndarray) -> dict[str, object]:
    rows = "".join(f"{a:.6g},{b:.6g}\n" for a, b in zip(stretch, stress, strict=True))
    (folder / "pull.csv").write_text("# test: uniaxial\nstretch,stress [MPa]\n" + rows)
    done = hf("fit", "pull.csv", "--model", "all", "-o", "law.json", cwd=folder)
    assert done.returncode == 0, done.stderr
    return json.loads((folder / "law.json").read_text())  # type: ignore[no-any-return]


def test_a_law_that_lies_much_closer_is_pointed_at(hf: Run, tmp_path: Path) -> None:
    stretch = np.linspace(1.02, 1.8, 50)
    noise = 1e-3 * np.random.default_rng(2).standard_normal(50)
    pull = 0.05 * np.expm1(6.0 * (stretch - 1.0) ** 2) + 0.1 * (stretch - 1.0)
    found = fitted(hf, tmp_path, pull + noise * pull.max(), stretch)
    models = {one["model"]: one for one in found["models"]}  # type: ignore[attr-defined]
    missed = models[found["model"]]["fit"]["nrmse"]
    [told] = [text for text in found["warnings"] if "carry over" in text]  # type: ignore[attr-defined]
    other = told.rsplit(" ", 1)[1]
    assert models[other]["fit"]["nrmse"] < missed / 3.0
    assert other in ("ogden-2", "ogden-3")


def test_none_is_pointed_at_where_the_law_fits(hf: Run, tmp_path: Path) -> None:
    stretch = np.linspace(1.02, 1.8, 50)
    found = fitted(hf, tmp_path, 0.4 * (stretch - stretch**-2.0) * (1.0 + 0.1 * stretch), stretch)
    assert not any("carry over" in text for text in found.get("warnings") or [])  # type: ignore[attr-defined]
