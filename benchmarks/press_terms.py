"""What of a hot, compressible sandwich matters most on the sample press: each term alone, and all together.

Drapes the sample fabric on the sample cup and presses the sample sandwich, first as a cold law on incompressible foam
between rigid fabrics that touch without resistance, then with one term changed at a time, and prints
docs/press-contact-terms.md:

    python benchmarks/press_terms.py > docs/press-contact-terms.md

``--drape DRAPE.json`` takes a drape that is there already, ``--gap`` and ``--dwell`` other settings.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
KNIT = "strain [-],stress [kPa]\n0,0\n0.1,0.5\n0.2,1.5\n0.3,4\n0.4,10\n0.5,30\n0.6,100\n"
SOFTENED, COLD, CONDUCTANCE = 0.6, 23, 500

#: A term: the words of the table, and what it replaces in the foam's document.
PLAIN = {"compression": "", "fabric": "", "poisson": "0.5", "contact": ""}
TERMS: list[tuple[str, dict[str, str]]] = [
    ("none: incompressible foam, cold law, rigid fabric, perfect contact", {}),
    ("foam thins with a Poisson's ratio of 0.3", {"poisson": "0.3"}),
    (
        f"foam at 200 degC has {SOFTENED:g} of its stress (assumed)",
        {"compression": f", factor = {SOFTENED:g}"},
    ),
    (
        f"the same at each place's own temperature, in a line from {COLD} degC (assumed)",
        {"compression": "by place"},
    ),
    (
        "fabric gives way across: 0.32 at 5 kPa (assumed)",
        {"fabric": ', compression = { table = "knit.csv" }'},
    ),
    (
        f"{CONDUCTANCE} W/m²/K between molds and sandwich (the sample's)",
        {"contact": f'contact_conductance = "{CONDUCTANCE} W/m^2/K"'},
    ),
]

HEAD = """# What matters most in the press

Made by `python benchmarks/press_terms.py`. The sample sandwich between the sample cups at 200 °C, {gap} apart, under
the sample drape (60 x 60 nodes), closed for {dwell}: first without any of the terms, then with each alone, then with
all of them (the softening at each place's temperature). The softening and the fabric's curve are assumed: of the size
that such materials have, not measured on them. What is formed goes by the sample's set law in every row.

| | force N | spotted % | middle of the foam, least / mean / greatest °C | formed, least / mean / greatest mm |
|---|---|---|---|---|"""


def hf(*words: str, folder: Path) -> None:
    """Run a command of this tree quietly; it must end well."""
    here = {**os.environ, "PYTHONPATH": str(ROOT)}
    subprocess.run([sys.executable, "-m", "hyperfab", *words, "--quiet"], cwd=folder, check=True, env=here)


def foam(changed: dict[str, str]) -> str:
    """Return the sample's foam document with terms changed."""
    said = {**PLAIN, **changed}
    text = (ROOT / "specimens" / "foam.toml").read_text()
    law, fabric = '{ table = "foam.csv" }', 'below = "0.5 mm" }'
    assert law in text
    assert fabric in text
    # The sample's own contact is a term of its own.
    text = "\n".join(line for line in text.splitlines() if not line.startswith("contact_conductance"))
    if said["compression"] == "by place":
        rows = (f'{{ table = "foam.csv", factor = {factor}, temperature = "{celsius} degC" }}'
                for factor, celsius in ((1, COLD), (SOFTENED, 200)))  # fmt: skip
        text = text.replace(law, f"[{', '.join(rows)}]")
    text = text.replace(law, f'{{ table = "foam.csv"{said["compression"]} }}')
    text = text.replace(fabric, f'below = "0.5 mm"{said["fabric"]} }}')
    return f"{text}\npoisson = {said['poisson']}\n{said['contact']}\n"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--drape", type=Path)
    parser.add_argument("--gap", default="3mm")
    parser.add_argument("--dwell", default="5s")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        drape = given.drape.resolve() if given.drape else folder / "drape.json"
        if given.drape is None:
            tests = [f"{ROOT}/specimens/lycra/{way}-23C.csv" for way in ("warp", "weft")]
            hf("fit", "--uniaxial", tests[0], "--uniaxial", tests[1], "--model", "yeoh-3", "-o", "fabric.json",
               folder=folder)  # fmt: skip
            hf("drape", "fabric.json", "--mold", f"{ROOT}/molds/cup-male.stl", "--grid", "60x60", "--size",
               "220mmx220mm", "--depth", "60mm", "-o", drape.name, folder=folder)  # fmt: skip
        (folder / "foam.csv").write_bytes((ROOT / "specimens" / "foam.csv").read_bytes())
        (folder / "knit.csv").write_text(KNIT)
        together = {key: value for _, changed in TERMS for key, value in changed.items()}
        print(HEAD.format(gap=given.gap, dwell=given.dwell))
        for words, changed in [*TERMS, ("all together", together)]:
            (folder / "foam.toml").write_text(foam(changed))
            hf("press-contact", "--male", f"{ROOT}/molds/cup-male.stl", "--female", f"{ROOT}/molds/cup-female.stl",
               "--axis", "z", "--foam", "foam.toml", "--gap", given.gap, "--temperature", "200degC", "--drape",
               str(drape), "--dwell", given.dwell, "--strokes", "2", "-o", "press.json", folder=folder)  # fmt: skip
            found = json.loads((folder / "press.json").read_text())
            middle, made = found["warming"], found["formed"]
            print(
                f"| {words} | {found['force_N']:.1f} | {100.0 * found['contact_fraction']:.1f} | "
                + " / ".join(f"{middle[f'middle_{key}_degC']:.1f}" for key in ("min", "mean", "max"))
                + " | "
                + " / ".join(f"{made[f'thickness_{key}_mm']:.2f}" for key in ("min", "mean", "max"))
                + " |",
                flush=True,
            )


if __name__ == "__main__":
    main()
