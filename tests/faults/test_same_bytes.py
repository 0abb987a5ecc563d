"""The same inputs give the same bytes: in another folder, with another seed of the hashes, on one core or on all."""

from __future__ import annotations

import hashlib
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from builders import PLATE

ROOT = Path(__file__).resolve().parents[2]

PROBE = """
[[probe]]
name = "top"
at = ["30 mm", "30 mm", "20 mm"]
"""
TESTS = [f"--{mode}={mode}.csv" for mode in ("uniaxial", "shear", "biaxial")]
COMMANDS = {
    "fit": ["fit", *TESTS, "--model", "all"],
    "fabric-contact": ["fabric-contact", "fabric.json", "--depth", "30mm", "--mesh-size", "15mm"],
    "drape": [
        "drape", "fabric.json", "--mold", "male.stl", "--grid", "40x40", "--size", "260mmx260mm", "--depth", "50mm",
    ],
    "mold-heat": ["mold-heat", "mold.toml"],
    "press-contact": [
        "press-contact", "--male", "male.stl", "--female", "female.stl", "--foam", "foam.toml", "--gap", "3mm",
        "--temperature", "150degC", "--strokes", "5",
    ],
}  # fmt: skip
FABRIC = {
    "format": "hyperfab.material/1",
    "model": "yeoh-3",
    "parameters": {"C10_MPa": 0.18, "C20_MPa": -0.004, "C30_MPa": 0.0008},
    "thickness_mm": 1.0,
}


def prepare(folder: Path) -> None:
    folder.mkdir(parents=True)
    for mode in ("uniaxial", "shear", "biaxial"):
        (folder / f"{mode}.csv").write_bytes((ROOT / f"specimens/treloar-1944/{mode}.csv").read_bytes())
    for name in ("male", "female"):
        (folder / f"{name}.stl").write_bytes((ROOT / f"molds/cup-{name}.stl").read_bytes())
    for name in ("foam.toml", "foam.csv", "film.csv"):
        (folder / name).write_bytes((ROOT / "specimens" / name).read_bytes())
    (folder / "fabric.json").write_text(json.dumps(FABRIC))
    (folder / "mold.toml").write_text(PLATE + PROBE)


def hashes(arguments: list[str], folder: Path, **environment: str) -> dict[str, str]:
    prepare(folder)
    before = {path.name for path in folder.iterdir()}
    done = subprocess.run(
        [sys.executable, "-m", "hyperfab", *arguments, "-o", "out.json"],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": str(ROOT), **environment},
        capture_output=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr.decode()
    assert done.stdout == b""
    written = {path.name: path.read_bytes() for path in folder.iterdir() if path.name not in before}
    listed = json.loads(written["out.json"])["files"]
    assert set(written) == {"out.json", *listed}
    for name, data in written.items():
        for private in (str(folder), str(ROOT), os.uname().nodename):
            # A short host name stands in any compressed data by chance.
            assert len(private) < 8 or private.encode() not in data, f"{name} names this machine"
    return {name: hashlib.sha256(data).hexdigest() for name, data in written.items()}


@pytest.mark.parametrize(
    "command", [one if one == "fit" else pytest.param(one, marks=pytest.mark.slow) for one in COMMANDS]
)
def test_same_inputs_same_bytes(command: str, tmp_path: Path) -> None:
    first = hashes(COMMANDS[command], tmp_path / "a", PYTHONHASHSEED="1", HYPERFAB_THREADS="")
    again = hashes(
        COMMANDS[command], tmp_path / "another place" / "b", PYTHONHASHSEED="2", HYPERFAB_THREADS="1",
        OMP_NUM_THREADS="1", OPENBLAS_NUM_THREADS="1", NUMBA_NUM_THREADS="1", TZ="Asia/Tokyo", LC_ALL="C",
        HOME=str(tmp_path),
    )  # fmt: skip
    assert first == again
