"""What a loop says that its extended model predicts, beside what the command makes of that model."""

from __future__ import annotations

import json
from pathlib import Path

import meshio
import numpy as np
import pytest
from conftest import ROOT, Run


@pytest.mark.slow
def test_the_model_that_is_written_lies_where_the_loop_says(tmp_path: Path, hf: Run) -> None:
    """Markers of a taut sheet on a cup, whose rim a coarser grid meets elsewhere: within a fifth of their noise."""
    ways = {way: {"parameters": {"C10_MPa": one}} for way, one in (("warp", 0.06), ("weft", 0.045))}
    fabric = {"format": "hyperfab.material/1", "model": "neo-hookean", "parameters": {"C10_MPa": 0.06},
              "directions": ways, "thickness_mm": 0.8}  # fmt: skip
    (tmp_path / "fabric.json").write_text(json.dumps(fabric))
    (tmp_path / "cup.stl").write_bytes((ROOT / "molds" / "cup-male.stl").read_bytes())
    words = [
        "fabric.json",
        "--mold",
        "cup.stl",
        "--grid",
        "31x31",
        "--size",
        "220mmx220mm",
    ]
    for name, more in (("net.json", []), ("true.json", ["--prestretch", "1.02"])):
        assert hf("drape", *words, "--depth", "40mm", *more, "-o", name, cwd=tmp_path).returncode == 0
    field, random = meshio.read(tmp_path / "true.vtu"), np.random.default_rng(4)
    inside = np.flatnonzero(np.abs(field.point_data["flat_mm"][:, :2]).max(axis=1) < 100.0)
    rows = np.sort(random.choice(inside, 120, replace=False))
    flat, noisy = (
        field.point_data["flat_mm"][rows, :2],
        field.points[rows] + 0.05 * random.standard_normal((120, 3)),
    )
    rows_of = np.column_stack([flat, noisy])
    np.savetxt(
        tmp_path / "markers.csv",
        rows_of,
        "%.5f",
        ",",
        header="x0 [mm],y0 [mm],x [mm],y [mm],z [mm]",
        comments="",
    )
    done = hf("close-loop", "net.json", "markers.csv", "-o", "loop.json", cwd=tmp_path)
    assert done.returncode == 0, done.stderr.decode()
    written = meshio.read(tmp_path / "loop.model.vtu").points[rows]
    told = np.genfromtxt(tmp_path / "loop.csv", delimiter=",", names=True, usecols=range(9))
    nodes = np.array([np.argmin(np.hypot(*(flat - one).T)) for one in np.stack([told["x0_mm"], told["y0_mm"]], axis=1)])
    off = told["after_mm"] - written[nodes, told["axis"].astype(int)]
    assert len(off) == 360
    assert np.sqrt(np.mean(off**2)) < 0.2 * 0.05
    assert json.loads((tmp_path / "loop.json").read_text())["error"]["after"]["chi2_reduced"] < 1.2
