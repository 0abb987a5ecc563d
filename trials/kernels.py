"""Which kernels the commands call, with which types: the list of those that the build compiles ahead.

    python -m trials.kernels          (about five minutes)

Runs every command once or more, in all its ways to compute, with an empty cache, and writes ``hyperfab/ahead.json``.
A kernel that is missing there is compiled when it is first called.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
DRAPE = "drape fabric.json --mold molds/cup-male.stl --grid 24x20 --size 220mmx220mm"
CONTACT = "fabric-contact fabric.json --thickness 1mm --depth 20mm --steps 2 --mesh-size 12mm"
PRESS = "press-contact --male molds/cup-male.stl --female molds/cup-female.stl --foam specimens/foam.toml"
LYCRA = ("warp-23C", "weft-23C", "warp-80C")
#: Every way to compute. Each line is a command; {name} is the document it writes.
_LINES = f"""
fit --uniaxial specimens/lycra/warp-23C.csv --uniaxial specimens/lycra/weft-23C.csv --model yeoh-3 -o fabric.json
fit --uniaxial specimens/lycra/warp-23C.csv --model yeoh-3 -o warp.json
fit --uniaxial specimens/treloar-1944/uniaxial.csv --model ogden-3 --stable -o rubber.json
{DRAPE} -o drape.json
{DRAPE.replace("24x20", "80x60")} --depth 30mm -o drape.json
{DRAPE} --sheet membrane --depth 50mm -o shell.json
{DRAPE.replace("220mmx220mm", "220mm")} --sheet membrane --shape disc --depth 30mm -o disc.json
drape fabric.json --sheet membrane --mold molds/plate-male.stl --grid 24x20 --depth 10mm -o edges.json
{DRAPE} --friction 0.3 --load-steps 3 --depth 40mm -o rubbing.json
{DRAPE} --shear-modulus 0.1MPa --thickness 0.5mm --mass 200g/m2 --blank-holder 50N/m --prestretch 1.05 -o held.json
{DRAPE} --clamp y-,y+ --slide x-,x+ --states 2 --depth 30mm -o slid.json
drape fabric.json --mold molds/torso.stl --grid 24x20 --size 700mmx700mm --depth 30mm -o torso.json
{DRAPE} --solver dynamic -o dynamic.json
{DRAPE} --solver relaxation --steps 20 -o relaxed.json
{CONTACT} --shape disc --size 200mm -o contact.json
{CONTACT} --shape square --size 200mm --friction 0.3 --element P1 -o square.json
{CONTACT} --shape disc --size 200mm --friction stick -o stuck.json
{CONTACT} --shape outline.csv -o outline.json
{CONTACT} --shape disc --size 300mm --punch molds/cup-male.stl -o punch.json
mold-heat molds/original.toml -o original.json
mold-heat molds/cup-on-plate.toml -o cup.json
mold-heat molds/production.toml -o production.json
{PRESS} --gap 3mm --temperature 200degC --drape drape.json -o press.json
{PRESS} --force 60N --float --dwell 20s --strokes 4 -o force.json
{PRESS} --gap 3mm --design-gap 4mm --facets flat -o design.json
close-loop warp.json {" ".join(f"--measured specimens/lycra/{way}.csv" for way in LYCRA)} -o loop.json
report fabric.json drape.json contact.json original.json press.json loop.json -o report.html
export fabric.json --to abaqus -o card.inp
"""
LINES = _LINES.strip().splitlines()
#: What the lines read beside the samples.
FILES = {"outline.csv": "x [mm],y [mm]\n-90,-60\n90,-60\n90,70\n0,90\n-90,70\n"}
#: Effects with time, and molds reduced to a few unknowns, are called in their tests.
TESTS = [
    "tests/chapters/test_mold_heat_variations.py",
    "tests/materials/test_effects_as_stated.py",
    "tests/loop/test_applied_fabric.py",
    "tests/loop/test_heat.py",
]


def ends(line: str) -> tuple[int, ...]:
    """Return the statuses with which a line may end: the report's own relaxation comes to no rest."""
    return (4,) if "--solver relaxation" in line else (0, 1)


def run(folder: Path, cache: Path, lines: list[str] = LINES) -> list[str]:
    """Run the lines in ``folder`` with a cache of their own, and return those that ended otherwise than they may."""
    env = os.environ | {"PYTHONPATH": str(ROOT), "NUMBA_CACHE_DIR": str(cache)}
    failed = []
    for name, text in FILES.items():
        (folder / name).write_text(text, encoding="utf-8")
    for line in [*([] if folder.joinpath("molds").exists() else ["sample ."]), *lines]:
        words = [sys.executable, "-m", "hyperfab", *line.split(), *([] if "sample" in line else ["-q"])]
        done = subprocess.run(words, cwd=folder, env=env, check=False)
        if done.returncode not in ends(line):
            failed.append(f"{line}: {done.returncode}")
    return failed


def main() -> None:
    """Run all lines and write the list."""
    with tempfile.TemporaryDirectory() as folder:
        for line in run(Path(folder), Path(folder, "cache")):
            print(line)
        env = os.environ | {"PYTHONPATH": str(ROOT), "NUMBA_CACHE_DIR": str(Path(folder, "cache"))}
        subprocess.run([sys.executable, "-m", "pytest", "-q", *TESTS], cwd=ROOT, env=env, check=True)
        subprocess.run([sys.executable, "-m", "hyperfab.ahead", "--list"], env=env, check=True)


if __name__ == "__main__":
    main()
