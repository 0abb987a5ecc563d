"""What a machine records behind the break of a specimen is no reading of the cloth."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from conftest import Run

from hyperfab.chapters.fit.prepare import broken

STRETCH = np.linspace(1.05, 3.0, 40)
STRESS = 0.4 * (STRETCH - STRETCH**-2)


def write(path: Path, tail: str) -> None:
    rows = "".join(f"{a:.5f},{b:.6f}\n" for a, b in zip(STRETCH, STRESS, strict=True))
    path.write_text(f"# test: uniaxial\n# thickness: 1 mm\nstretch,stress [MPa]\n{rows}{tail}")


@pytest.mark.slow
@pytest.mark.parametrize(
    "tail",
    [pytest.param("3.01,0.003\n", marks=pytest.mark.slow), "3.0,0.2\n3.01,0.06\n3.02,0.004\n3.03,-0.001\n1.2,0.002\n"],
)
def test_constants_are_those_of_the_whole_specimen(hf: Run, tmp_path: Path, tail: str) -> None:
    write(tmp_path / "a.csv", tail)
    done = hf("fit", "a.csv", "--model", "neo-hookean", "-o", "a.json", cwd=tmp_path)
    count = tail.count("\n")
    assert f"{count} row" in done.stderr.decode()
    assert "behind the break of the specimen" in done.stderr.decode()
    document = json.loads((tmp_path / "a.json").read_text())
    assert document["parameters"]["C10_MPa"] == pytest.approx(0.2, rel=1e-4)
    assert document["left_out"] == {"behind the break of the specimen": count}
    hf("close-loop", "a.json", "--measured", "a.csv", "-o", "b.json", cwd=tmp_path)
    assert json.loads((tmp_path / "b.json").read_text())["verdict"] == "noise"


def test_a_strip_that_is_let_go_or_relaxes_is_whole() -> None:
    way = np.concatenate([STRETCH, STRETCH[::-1]])
    kept = 2.2  # to which it is set
    back = np.where(kept < STRETCH, STRESS * (STRETCH - kept) / (3.0 - kept), 0.0)[::-1]
    assert broken(way, np.concatenate([STRESS, back])) == len(way)
    held = np.concatenate([STRETCH, np.full(30, 3.0)])
    assert broken(held, np.concatenate([STRESS, STRESS[-1] * np.linspace(1.0, 0.3, 30)])) == len(held)
    assert broken(STRETCH[::-1], STRESS[::-1]) == len(STRETCH)


def test_a_preloaded_strip_that_a_sine_lets_go_past_its_rest_is_whole() -> None:
    """As far to shorter as it was pulled: eight readings of a cycle about a preload of half its stress."""
    way = 1.0 + 0.08 * np.sin(np.linspace(0.0, 1.75 * np.pi, 8))
    assert broken(way, np.maximum(0.5 + 8.0 * (way - 1.0), 0.0)) == len(way)
