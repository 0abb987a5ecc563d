"""Inputs chosen to break ``hf export``: cards of documents at their limits, read back by the solvers' own formulas.

Run as ``PYTHONPATH=.:tests python -m trials.hunt_export [part of a name]``: one line a case, status 1 if any is wrong.
The readers are those of ``tests/materials/test_export.py``: a solver's energy as its manual prints it, differentiated.
"""

from __future__ import annotations

import json
import re
import sys
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from laws.constants import CONSTANTS
from materials.test_export import READERS, invariants, stress_of

from hyperfab.materials import bind, laws
from hyperfab.materials.export import formats
from hyperfab.materials.law import scaled
from trials.hunting import Array, Hunt, Ran, asked, hf

#: Constants where laws end or change their kind, beside those of rubber.
LIMITS: Mapping[str, Mapping[str, tuple[float, ...]]] = {
    "gent": {
        "a limit of 1": (0.3, 1.0), "a limit of 0.02": (3.0, 0.02), "a limit of 1e-4": (30.0, 1e-4),
        "a limit of 1e6": (0.2, 1e6),
    },
    "arruda-boyce": {"chains of 0.5": (0.2, 0.5), "chains of 1.5": (0.2, 1.5), "chains of 1000": (0.2, 1000.0)},
    "arruda-boyce-langevin": {
        "chains of 1.001": (0.2, 1.001), "chains of 1.3": (0.2, 1.3), "chains of 500": (0.2, 500.0),
    },
    "ogden-1": {"a power of 25": (0.02, 25.0), "a power of -20": (-0.02, -20.0), "a power of 0.01": (20.0, 0.01)},
    "ogden-2": {"a term of nothing": (0.3, 2.0, 0.0, 4.0)},
    "yeoh-3": {"softening": (0.3, -0.02, 0.001), "zeros": (0.2, 0.0, 0.0), "small": (1.23456789012e-3, -1e-12, 1e-300)},
    "mooney-rivlin-2": {"I2 alone": (0.0, 0.2), "negative I1": (-0.1, 0.4)},
    "mooney-rivlin-9": {"negatives": (0.2, 0.05, -0.01, -0.002, -0.003, 1e-4, -2e-5, 3e-5, -4e-6)},
    "blatz-ko": {"stiff": (40.0, 0.0, 0.25)},
    "blatz-ko-general": {
        "I1 alone": (0.4, 1.0, 0.3), "nearly a half": (0.4, 0.5, 0.48), "nearly none": (0.4, 0.5, 0.01),

    },
}  # fmt: skip


def document(name: str, values: tuple[float, ...], **more: Any) -> dict[str, Any]:
    """Return a material document."""
    return {
        "format": "hyperfab.material/1", "model": name,
        "parameters": dict(zip(laws()[name].names, values, strict=True)), **more,
    }  # fmt: skip


def export(content: Mapping[str, Any], *options: object) -> Ran:
    """Write the document and export it."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "fabric.json"
        path.write_text(json.dumps(content))
        return hf("export", path, *options, output=Path(folder) / "card.txt")


def stretches(name: str, values: tuple[float, ...]) -> tuple[Array, Array]:
    """Return pairs of stretches within the law's limit."""
    one, two = np.array([1.2, 2.0, 3.0, 0.9]), np.array([1.1, 0.8, 1.5, 1.3])
    material = bind(name, dict(zip(laws()[name].names, values, strict=True)))
    for share in (1.0, 0.3, 0.1, 0.03, 0.01, 1e-3, 1e-4):
        l1, l2 = 1.0 + share * (one - 1.0), 1.0 + share * (two - 1.0)
        found = material.membrane(l1, l2).P1
        if np.isfinite(found).all() and np.abs(found).max() < 1e6:
            return l1, l2
    raise ValueError(f"{name} has no stress at {values}")


def marlow(card: str, l1: Array, l2: Array) -> Array:
    """Return the stress of Marlow's law: the energy of a state is that of the test at its I1; Abaqus's manual, 22.5.1.

    The energy falls off the curve by the trapezium rule between its points, as straight lines in stress have it.
    """
    rows = np.array([[float(v) for v in line.split(",")] for line in card.split("TEST DATA\n")[1].splitlines()])
    assert np.isfinite(rows).all(), "a row that is no number"
    assert (np.diff(rows[:, 1]) > 0).all(), "strains that do not rise"
    stress, lam = rows[:, 0], 1.0 + rows[:, 1]
    pull = lam >= 1.0
    stress, lam = stress[pull], lam[pull]
    reach = lam[-1] ** 2 + 2.0 / lam[-1]
    I1, _ = invariants(l1, l2, 1.0 / (l1 * l2))
    assert (reach >= I1).all(), f"the curve ends at I1 = {reach:.4g}, {I1.max():.4g} is needed"
    # dW/dI1 = P / (dI1/dlam) at the stretch of the test with that I1.
    low, high = np.ones_like(I1), np.full_like(I1, lam[-1])
    for _ in range(80):
        middle = 0.5 * (low + high)
        below = middle**2 + 2.0 / middle < I1
        low, high = np.where(below, middle, low), np.where(below, high, middle)
    slope = np.interp(low, lam, stress) / (2.0 * low - 2.0 / low**2)
    return slope * 2.0 * (l1 - 1.0 / (l1**3 * l2**2))


def error(solver: str, card: str, name: str, values: tuple[float, ...]) -> float:
    """Return how far the card's stress is from the law's, relative to the largest."""
    l1, l2 = stretches(name, values)
    expected = bind(name, dict(zip(laws()[name].names, values, strict=True))).membrane(l1, l2).P1
    if "MARLOW" in card:
        found = marlow(card, l1, l2)
    elif name.startswith("blatz"):
        found = stress_of(READERS[solver](card), l1, l2)
    else:
        energy, step = READERS[solver](card), 1e-4 * np.abs(l1 - 1.0).max()
        at = [energy(l1 + k * step, l2, 1.0 / ((l1 + k * step) * l2)) for k in (-2, -1, 1, 2)]
        found = (at[0] - 8 * at[1] + 8 * at[2] - at[3]) / (12 * step)
    return float(np.abs(found - expected).max() / np.abs(expected).max())


def cards(hunt: Hunt) -> None:
    """Every law in every format that takes it, of rubber, softer, stiffer, and at its limits."""
    for solver, form in formats().items():
        for name in form.writers:
            sets = {"rubber": CONSTANTS[name], **LIMITS.get(name, {})}
            for factor in (1e-4, 1e3):
                softer = scaled(dict(zip(laws()[name].names, CONSTANTS[name], strict=True)), factor)
                sets[f"times {factor:g}"] = tuple(softer.values())
            for label, values in sets.items():
                title = f"{solver}, {name}: {label}"
                if not hunt.wanted(title):
                    continue
                ran = export(document(name, values), "--to", solver)
                if not isinstance(ran.document, str):
                    hunt.judge(title, False, f"{ran.status} {ran.said.strip()[:110]}")
                    continue
                try:
                    off = error(solver, ran.document, name, values)
                except (AssertionError, ValueError, KeyError) as wrong:
                    hunt.judge(title, False, f"{type(wrong).__name__} {wrong}"[:110])
                    continue
                # Straight lines between the points of a curve; differences of an energy.
                limit = 5e-3 if "MARLOW" in ran.document else 1e-4 if name.startswith("blatz") else 1e-6
                hunt.judge(title, off < limit, f"{off:.1e}")
        for name in sorted(set(CONSTANTS) - set(form.writers)):
            title = f"{solver}, {name}: has none"
            if hunt.wanted(title):
                ran = export(document(name, CONSTANTS[name]), "--to", solver)
                good = ran.status == 2 and ran.document is None and "yeoh-3" in ran.said
                hunt.judge(title, good, f"{ran.status} {ran.said.strip()[:60]}")


def numbers(text: str) -> list[float]:
    """Return all numbers of a card's lines that are no comment."""
    kept = "\n".join(line for line in text.splitlines() if not line.startswith(("**", "! ", "$")))
    kept = re.sub(r"<!--.*?-->", "", kept)
    return [float(one) for one in re.findall(r"(?<![\w.])[-+]?\d+\.?\d*(?:e[-+]?\d+)?", kept)]


def has(text: str, value: float, digits: float = 1e-12) -> bool:
    """Whether a number stands in a card."""
    return any(abs(one - value) <= digits * abs(value) for one in numbers(text))


def volume(hunt: Hunt) -> None:
    """The bulk modulus: in each solver's own constant, the change of volume at rest is the one that was asked for."""
    for K in (0.5, 20.0, 2000.0):
        for name in ("neo-hookean", "yeoh-3", "ogden-2", "arruda-boyce", "gent"):
            for solver in sorted(formats()):
                title = f"bulk {K:g} MPa: {solver}, {name}"
                if name not in formats()[solver].writers or not hunt.wanted(title):
                    continue
                values = CONSTANTS[name]
                card = export(document(name, values), "--to", solver, "--bulk-modulus", f"{K}MPa").document or ""
                own = dict(zip(laws()[name].names, values, strict=True))
                E = float(bind(name, own).uniaxial(1.0).A)
                nu = (3.0 * K - 2.0 * E / 3.0) / (6.0 * K + 2.0 * E / 3.0)
                # Poisson's ratio where the solver goes by it; D1 = d = 2/K; or K itself.
                good = has(card, 2.0 / K) or has(card, K) or has(card, nu, 1e-9)
                hunt.judge(title, good, "" if good else card.splitlines()[-3:])


def places(hunt: Hunt) -> None:
    """Directions, temperatures, effects, names, units: the card has the constants that other commands compute with."""

    def yeoh(factor: float) -> dict[str, float]:
        return {"C10_MPa": 0.2 * factor, "C20_MPa": -0.004 * factor, "C30_MPa": 0.0008 * factor}

    def row(degrees: float, factor: float) -> dict[str, Any]:
        return {"temperature_degC": degrees, "parameters": yeoh(factor)}

    fabric = document(
        "yeoh-3", tuple(yeoh(1.0).values()), temperature_degC=23.0,
        temperatures=[row(23.0, 1.0), row(80.0, 0.8), row(105.0, 0.7)],
        directions={
            way: {"parameters": yeoh(f), "temperatures": [row(23.0, f), row(80.0, 0.8 * f), row(105.0, 0.7 * f)]}
            for way, f in (("warp", 1.3), ("weft", 0.6))
        },
    )  # fmt: skip
    asks: dict[str, tuple[tuple[object, ...], float]] = {
        "both together": ((), 1.0), "warp": (("--direction", "warp"), 1.3), "weft": (("--direction", "weft"), 0.6),
        "at 80 degC": (("--temperature", "80degC"), 0.8), "at 51.5 degC": (("--temperature", "51.5degC"), 0.9),
        "at 353.15 K": (("--temperature", "353.15K"), 0.8), "weft at 176 degF": (
            ("--direction", "weft", "--temperature", "176degF"), 0.48),
        "hotter than known": (("--temperature", "200degC"), 0.7),
        "colder than known": (("--temperature", "-20degC"), 1.0),
    }  # fmt: skip
    for label, (options, factor) in asks.items():
        for solver in sorted(formats()):
            title = f"constants, {label}: {solver}"
            if hunt.wanted(title):
                card = export(fabric, "--to", solver, *options).document or ""
                good = all(has(card, value, 1e-10) for value in yeoh(factor).values())
                hunt.judge(title, good, f"{factor}")
    soft = document(
        "yeoh-3", tuple(yeoh(1.0).values()), temperature_degC=23.0,
        effects=[{"id": "thermal-softening", "form": "exponential", "parameters": {"softening_1_K": 0.004},
                  "reference_degC": 23.0}],
    )  # fmt: skip
    richer = {
        **soft,
        "effects": [{"id": "elastic-law", "form": "yeoh-3-lni2", "parameters": {"C2_MPa": 0.05}}],
    }
    if hunt.wanted("effects"):
        card = export(soft, "--to", "abaqus", "--temperature", "100degC")
        plain = export(soft, "--to", "abaqus", "--temperature", "23degC")
        ratio = [a / b for a, b in zip(numbers(card.document or ""), numbers(plain.document or ""), strict=False) if b]
        good = any(abs(one - np.exp(-0.004 * 77.0)) < 1e-9 for one in ratio) or "softening" in card.said
        hunt.judge("effects: softened by heat", good, ratio[:3] or card.said[:90])
        odd = export(richer, "--to", "abaqus")
        told = "elastic-law" in odd.said or odd.status != 0
        hunt.judge("effects: a richer law that no card has is told", told, odd.said.strip()[:90])
    for text, value in {"1.2 g/cm^3": 1.2e-9, "950 kg/m^3": 9.5e-10, "0.5 t/m^3": 5e-10}.items():
        for solver in sorted(formats()):
            if hunt.wanted(f"density {text}"):
                card = export(document("yeoh-2", (0.2, 0.01)), "--to", solver, "--density", text)
                good = card.status == 0 and has(str(card.document), value)
                hunt.judge(f"density {text}: {solver}", good, card.said.strip()[:80])
    for name in ("a", "X" * 200, "9lives", "_"):
        for solver in sorted(formats()):
            title = f"name {name[:9]}: {solver}"
            if hunt.wanted(title):
                card = export(document("yeoh-2", (0.2, 0.01)), "--to", solver, "--name", name)
                most = 80 if solver != "ls-dyna" else 160
                longest = max(map(len, str(card.document).splitlines()), default=0)
                good = card.status == 2 or (card.status == 0 and longest <= most)
                hunt.judge(title, good, f"{card.status}, lines of {longest}")


def main() -> None:
    """Run the cases and count."""
    hunt = asked(sys.argv)
    for part in (cards, volume, places):
        part(hunt)
    raise SystemExit(hunt.ended("export"))


if __name__ == "__main__":
    main()
