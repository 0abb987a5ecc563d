"""Which test to do next, done: a lab drawn from known constants follows the budget of its force, test by test.

Draws specimens of warp and weft and readings of a caliper, fits them, presses a sphere in, and does what the largest
share of the budget asks for; the budget foretells what that brings. Prints docs/uncertainty-story.md:

    python benchmarks/next_test.py > docs/uncertainty-story.md
"""

from __future__ import annotations

import json
import os
import tempfile
from math import sqrt
from typing import Any

import numpy as np

from hyperfab.cases.options import read
from hyperfab.cases.registry import case_class
from hyperfab.chapters.rerun import rerun
from hyperfab.materials import bind
from hyperfab.materials.modes import nominal_stress
from hyperfab.report.bands import figure

#: What the lab does not know.
TRUE = {"warp": {"C10_MPa": 0.060, "C20_MPa": 0.012}, "weft": {"C10_MPa": 0.048, "C20_MPa": 0.009}}
TRUE_THICKNESS = 0.6
#: Specimens differ in stiffness by so much, readings of stress by so much, and one of the caliper by so many mm.
SCATTER, NOISE, CALIPER = 0.03, 0.003, 0.03
SEED = 2026
FIRST, MORE, READINGS = 3, 5, 10
CONTACT = ("--size", "200mm", "--sphere-radius", "40mm", "--depth", "40mm", "--steps", "3", "--mesh-size", "16mm",
           "--tolerance", "1e-2")  # fmt: skip

HEAD = """# Which test to do next, done

Made by `python benchmarks/next_test.py`. A lab that does not know the fabric's constants measures {first} specimens of
the warp and {first} of the weft, drawn with a stiffness that scatters by {scatter:.0f} %, and reads the thickness once
with a caliper that errs by {caliper:g} mm. It presses a sphere of 40 mm radius 40 mm deep into a held disc of 200 mm by
`hf fabric-contact`, asks the budget of the force what to measure next, and does that. A share of the variance goes with
one over the number of readings or specimens: that is what is foretold. The true force is {truth:.3f} N.

| measured | force N, ± sd | 95 % N | what it is made of | next | sd foretold N | sd then N |
|---|---|---|---|---|---|---|"""
TAIL = """
The caliper's error is stated, and what is foretold of it is met. The scatter of {first} specimens is known to half of
itself only, one over the root of twice the degrees of freedom; so is what is foretold of more of them. 400 labs each
that did draw them (`python -m trials.foretold`; a sphere's force, specimens that scatter by 3 %):

| specimens | and then | sd that came over sd foretold, median | within 20 % | by chance alone |
|---|---|---|---|---|
| 3 | 8 | 1.08 | 36 % | 35 % |
| 5 | 10 | 1.00 | 56 % | 56 % |
| 8 | 16 | 1.03 | 70 % | 71 % |
| 16 | 32 | 0.98 | 88 % | 87 % |
| 30 | 60 | 1.00 | 93 % | 95 % |

The budget's word is right in the middle, and as often within 20 % as what few specimens can know of their own scatter
lets it be."""


def curve(way: str, number: int) -> bytes:
    """Return the file of one specimen; the same for the same number."""
    draw = np.random.default_rng([SEED, len(way), ord(way[-1]), number])
    stretch = np.linspace(1.0, 1.6, 31)[1:]
    stress = nominal_stress(bind("yeoh-2", TRUE[way]), "uniaxial", stretch)
    stress = stress * (1.0 + SCATTER * draw.standard_normal() + NOISE * draw.standard_normal(len(stretch)))
    rows = "".join(f"{a!r},{b!r}\n" for a, b in zip(stretch.tolist(), stress.tolist(), strict=True))
    return f"# direction: {way}\nstretch [-],stress [MPa]\n{rows}".encode()


def thickness(readings: int) -> tuple[float, float]:
    """Return the mean of so many readings of the caliper, and its standard deviation [mm]."""
    draw = np.random.default_rng([SEED, 0])
    found = TRUE_THICKNESS + CALIPER * draw.standard_normal(READINGS)
    return round(float(found[:readings].mean()), 4), CALIPER / sqrt(readings)


def force(specimens: dict[str, int], readings: int) -> dict[str, Any]:
    """Return the contact document of what was measured."""
    given = {f"{way}-{k}.csv": curve(way, k) for way, count in specimens.items() for k in range(count)}
    words = [word for name in given for word in ("--uniaxial", name)]
    fitted = rerun(read(case_class("fit"), [*words, "--model", "yeoh-2"]), "-", given).document
    size, sd = thickness(readings)
    stated = ("--thickness", f"{size}mm +- {sd}mm")
    return press({**fitted, "files": []}, *stated)


def press(material: dict[str, Any], *words: str) -> dict[str, Any]:
    """Return what a sphere meets on a fabric."""
    case = read(case_class("fabric-contact"), ["fabric.json", *CONTACT, *words])
    return rerun(case, "-", {"fabric.json": json.dumps(material).encode()}).document


def true_force() -> float:
    """Return the force of the constants that the lab does not know."""
    ways = {way: {"parameters": own} for way, own in TRUE.items()}
    plain = {
        "format": "hyperfab.material/1",
        "model": "yeoh-2",
        "parameters": TRUE["warp"],
        "directions": ways,
    }
    return float(press(plain, "--thickness", f"{TRUE_THICKNESS}mm")["force_N"])


def short(source: str) -> str:
    """Return what a source is, for the table.

    >>> short("fabric.json: constants of warp, 3 specimens"), short("thickness_mm")
    ('warp', 'thickness')
    """
    return next((way for way in TRUE if f"of {way}" in source), "thickness")


def story(rounds: int = 2) -> list[dict[str, Any]]:
    """Return the rounds: what is measured, the band and budget of the force, the next test, what is foretold of it."""
    specimens, readings = dict.fromkeys(TRUE, FIRST), 1
    found: list[dict[str, Any]] = []
    for number in range(rounds):
        document = force(specimens, readings)
        band = document["uncertainty"]["quantities"]["force_N"]
        shares = {short(one["source"]): one["share"] for one in band["budget"]}
        top = short(band["budget"][0]["source"])
        row = {"force": document["force_N"], "band": band, "shares": shares, "specimens": dict(specimens),
               "readings": readings}  # fmt: skip
        if found:
            found[-1]["then"] = band["sd"]
        found.append(row)
        if number == rounds - 1:
            break
        if top == "thickness":
            left, readings = readings / READINGS, READINGS
        else:
            left = specimens[top] / (specimens[top] + MORE)
            specimens[top] += MORE
        row["next"] = top
        row["foretold"] = band["sd"] * sqrt(1.0 - shares[top] * (1.0 - left))
    return found


def page() -> str:
    """Return the page."""
    rows, truth = story(), true_force()
    lines = [HEAD.format(first=FIRST, scatter=100.0 * SCATTER, caliper=CALIPER, truth=truth)]
    for row in rows:
        band = row["band"]
        counts = ", ".join(f"{count} of {way}" for way, count in row["specimens"].items())
        read_ = f"{row['readings']} reading{'s' if row['readings'] > 1 else ''}"
        made_of = ", ".join(f"{name} {100.0 * share:.0f} %" for name, share in row["shares"].items())
        then = ("nothing", "", "")
        if "next" in row:
            what = f"{READINGS} readings" if row["next"] == "thickness" else f"{MORE} more of {row['next']}"
            then = (what, f"{row['foretold']:.3f}", f"{row['then']:.3f}")
        cells = [
            f"{counts}; {read_}",
            figure(row["force"], band["sd"]),
            f"{band['low']:.3g} to {band['high']:.3g}",
            made_of,
            *then,
        ]
        lines.append("| " + " | ".join(cells) + " |")
    lines.append(TAIL.format(first=FIRST))
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        print(page(), end="")
