"""All laws on Treloar's rubber: constants from uniaxial tension (A) against constants from all tests (B) on the sphere.

Fits each law twice to ``specimens/treloar-1944``, pushes a sphere of radius 40 mm into a disc of diameter 200 mm and
thickness 1 mm, and prints the tables of docs/fabric-contact-laws.md:

    python benchmarks/contact_laws.py > docs/fabric-contact-laws.md

``--data FOLDER`` reads uniaxial.csv, shear.csv and biaxial.csv from elsewhere; names of laws restrict the table.
"""

from __future__ import annotations

import argparse
import json
import re
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
TESTS = ROOT / "specimens" / "treloar-1944"
DEPTH_MM = 80
STEPS = 8

HEAD = """# The sphere's verdict on all laws

Made by `python benchmarks/contact_laws.py`. Constants of each law from Treloar's uniaxial test alone (A) and from
uniaxial, planar and equibiaxial tests together (B); a sphere of radius 40 mm pushed 10 to 80 mm into a clamped disc of
diameter 200 mm and thickness 1 mm. Force in N at 40, 60 and 80 mm; e is the largest difference of the Cauchy principal
stresses at the same material points over the largest stress of A, at the last depth both reach (80 mm unless said
otherwise); F_A/F_B there. Unstable: the depth and the larger stretch where the constants first lose Drucker stability.
Bands: from this depth on the constants let the stretch gather in bands as narrow as the elements (the larger stretch is
in brackets); no result beyond it would hold on a finer mesh, so the path ends there.

| law | F_A 40 | F_A 60 | F_A 80 | F_B 40 | F_B 60 | F_B 80 | e % | F_A/F_B | A | B |
|---|---|---|---|---|---|---|---|---|---|---|"""

DEPTHS_HEAD = (
    "Force [N] with A / with B:\n\n| law | "
    + " | ".join(f"{DEPTH_MM * step // STEPS} mm" for step in range(1, STEPS + 1))
    + " |\n"
    + "|---" * (STEPS + 1)
    + "|"
)


def hf(*words: str, folder: Path) -> int:
    """Run a command quietly and return its exit status."""
    command = [sys.executable, "-m", "hyperfab", *words, "--quiet"]
    return subprocess.run(command, cwd=folder, check=False, stderr=subprocess.DEVNULL).returncode


def fitted(law: str, case: str, folder: Path, tests: Path) -> str | None:
    """Fit a law; case A on the uniaxial test alone. Returns the document's name, None where there is no fit."""
    name = f"{law}-{case}.json"
    words = ["fit", "--model", law, "--accept", "1000000", "-o", name]
    for test in ("uniaxial", "shear", "biaxial"):
        words += [f"--{test}", str(tests / f"{test}.csv")]
    hf(*words, *(["--fit-on", "uniaxial"] if case == "A" else []), folder=folder)
    return name if (folder / name).exists() else None


def pressed(law: str, folder: Path, tests: Path) -> dict | None:
    """Press both sets of constants; None where a law has no fit."""
    names = [fitted(law, case, folder, tests) for case in "AB"]
    if None in names:
        return None
    out = f"{law}.json"
    hf(
        "fabric-contact", names[0], "--against", names[1], "--depth", f"{DEPTH_MM}mm", "--steps", str(STEPS),
        "-o", out, folder=folder,
    )  # fmt: skip
    path = folder / out
    return json.loads(path.read_text()) if path.exists() else None


def verdict(part: dict) -> str:
    """Say how a set of constants ended: fine, unstable from a depth on, or without equilibrium beyond one."""
    words = []
    stability = part["stability"]
    if not stability["stable"]:
        words.append(f"unstable at {stability['first_unstable_depth_mm']:.1f} mm ({stability['stretches'][0]:.2f})")
    snap = re.search(r"snaps between ([\d.]+) and ([\d.]+) mm", part.get("status") or "")
    if snap:
        words.append(f"snaps between {snap[1]} and {snap[2]} mm")
    if "bands_depth_mm" in stability:
        words.append(f"bands at {stability['bands_depth_mm']:.2f} mm ({stability['bands_stretches'][0]:.2f})")
    elif not part["converged"]:
        words.append(f"ends at {part['depth_reached_mm']:.2f} mm")
    return ", ".join(words) or "stable"


def row(law: str, found: dict | None) -> str:
    """Return the table's line of one law."""
    if found is None:
        return f"| {law} | no result |" + " |" * 9
    cells = [law]
    for part in (found, found["against"]):
        forces = {round(depth, 6): force for depth, force in part["force_depth"]}
        cells += [f"{forces[depth]:.2f}" if depth in forces else "–" for depth in (40.0, 60.0, 80.0)]
    at = found.get("compared_at_depth_mm")
    where = "" if at is None or at == DEPTH_MM else f" (at {at:.1f} mm)"
    cells.append(f"{found['stress_difference_percent']:.1f}{where}" if at is not None else "–")
    cells.append(f"{found['force_ratio']:.3f}" if "force_ratio" in found else "–")
    cells += [verdict(found), verdict(found["against"])]
    return "| " + " | ".join(cells) + " |"


def depths(law: str, found: dict | None) -> str:
    """Return the lines of one law in the table of all depths: force with A over force with B."""
    if found is None:
        return f"| {law} | no result |" + " |" * (STEPS - 1)
    a, b = ({round(d, 6): f for d, f in part["force_depth"]} for part in (found, found["against"]))
    marks = [float(DEPTH_MM * step // STEPS) for step in range(1, STEPS + 1)]
    cells = [f"{a[d]:.2f} / {b[d]:.2f}" if d in a and d in b else "–" for d in marks]
    return "| " + " | ".join([law, *cells]) + " |"


def main() -> None:
    """Print the tables, law by law."""
    parser = argparse.ArgumentParser(description="All laws on the sphere: constants A against constants B.")
    parser.add_argument("laws", nargs="*", help="names of laws; all where none is given")
    parser.add_argument("--data", type=Path, default=TESTS, help="folder of uniaxial.csv, shear.csv, biaxial.csv")
    given = parser.parse_args()
    laws = given.laws
    if not laws:
        from hyperfab.materials import laws as known

        laws = [name for name, one in known().items() if one.isotropic]
    print(HEAD)
    results: dict[str, dict | None] = {}
    with tempfile.TemporaryDirectory() as folder:
        for law in laws:
            results[law] = pressed(law, Path(folder), given.data.resolve())
            print(row(law, results[law]), flush=True)
    parts = [part for found in results.values() if found for part in (found, found["against"])]
    reached = sum(part["converged"] for part in parts)
    print(f"\n{reached} of {len(parts)} sets of constants reach {DEPTH_MM} mm.\n")
    print(DEPTHS_HEAD)
    for law, found in results.items():
        print(depths(law, found))


if __name__ == "__main__":
    main()
