"""Do 95 % intervals of ``hf fit`` cover? Synthetic labs: specimens that scatter in stiffness, readings with noise.

    python -m trials.coverage [LABS]

For each law, set of tests, number of specimens and scatter, LABS labs (100) are drawn. The table says, in per cent,
how often the interval, constant +- t sd with the document's degrees of freedom, holds the constant, and how often that
of the stress at three stretches of uniaxial tension, from what each kind of test adds, holds the stress. The truth is
the law itself: what the choice of a law adds is another matter.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from itertools import product

import numpy as np
from scipy.stats import t as student

from hyperfab.chapters.fit.identify import Identified, Setting, identify
from hyperfab.curve import TestCurve
from hyperfab.materials import bind
from hyperfab.materials.modes import nominal_stress
from hyperfab.materials.registry import law
from hyperfab.numerics.propagation import Source, linear

TRUTHS = {
    "yeoh-3": {"C10_MPa": 0.060951, "C20_MPa": 0.021463, "C30_MPa": 0.017258},
    "mooney-rivlin-2": {"C10_MPa": 0.12, "C01_MPa": 0.03},
    "gent": {"mu_MPa": 0.2, "Im": 4.0},
}
TESTS = (("uniaxial",), ("uniaxial", "shear"), ("uniaxial", "shear", "biaxial"))
REACH = {"uniaxial": 1.8, "shear": 1.7, "biaxial": 1.45}
STRETCHES = (1.1, 1.3, 1.6)
NOISE_RELATIVE, NOISE_MPA = 0.004, 0.0002


def lab(
    name: str,
    tests: tuple[str, ...],
    specimens: int,
    scatter: float,
    draw: np.random.Generator,
    form: float = 0.0,
) -> list[TestCurve]:
    """Return the curves that one lab reads of specimens that ``scatter`` in stiffness and, to the end of the curve, by
    ``form`` in its shape: no specimen then obeys the law."""
    truth = bind(name, TRUTHS[name])
    found = []
    for mode in tests:
        for number in range(specimens):
            lam = np.linspace(1.0, REACH[mode], 41)[1:]
            stress = nominal_stress(truth, mode, lam) * (1.0 + scatter * draw.standard_normal())
            if form:
                stress *= 1.0 + form * draw.standard_normal() * (lam - 1.0) / (REACH[mode] - 1.0)
            noise = draw.standard_normal((2, len(lam)))
            read = stress * (1.0 + NOISE_RELATIVE * noise[0]) + NOISE_MPA * noise[1]
            found.append(TestCurve(mode=mode, source=mode, specimen=str(number), stretch=lam, stress=read))
    return found


def covered(name: str, found: Identified) -> list[bool]:
    """Return whether the interval of each constant, then of each stress, holds the truth."""
    sure = found.certainty.scatter
    assert sure is not None
    names, wide = found.law.names, student.ppf(0.975, sure.freedom)
    own = np.array([found.material.parameters[key] for key in names])
    true = np.array([TRUTHS[name][key] for key in names])
    inside = list(np.abs(own - true) <= wide * np.sqrt(np.diag(sure.covariance)))
    lam = np.array(STRETCHES)

    def stress(values: np.ndarray) -> np.ndarray:
        return nominal_stress(bind(name, dict(zip(names, map(float, values), strict=True))), "uniaxial", lam)

    slopes = []
    for k, value in enumerate(own):
        step = np.zeros_like(own)
        step[k] = 1e-5 * abs(value)
        slopes.append((stress(own + step) - stress(own - step)) / (2.0 * step[k]))
    slope = np.array(slopes)
    source = Source("constants", sure.covariance, sure.freedom, sure.parts)
    bands = [linear(0.0, source.root.T @ along, [source]) for along in slope.T]
    off = np.abs(stress(own) - stress(true))
    return inside + [bool(away <= band.high) for away, band in zip(off, bands, strict=True)]


def trial(
    name: str, tests: tuple[str, ...], specimens: int, scatter: float, labs: int, form: float = 0.0
) -> np.ndarray:
    """Return the share of labs whose intervals cover: of each constant, then of each stress."""
    draw = np.random.default_rng([labs, specimens, round(1e4 * scatter), len(tests), len(name)])
    setting = Setting(tests, relative=True, stable=False, accept=1.0)
    rows = []
    for _ in range(labs):
        found = identify(law(name), lab(name, tests, specimens, scatter, draw, form), setting)
        assert isinstance(found, Identified)
        rows.append(covered(name, found))
    return np.mean(rows, axis=0)


def main() -> None:
    """Print the tables: specimens that scatter in stiffness, and in the form of their law too."""
    labs = int(sys.argv[1]) if len(sys.argv) > 1 else 100
    table(labs, (0.005, 0.015, 0.05), 0.0)
    print("specimens that scatter by 3 % in the form of their law, too")
    table(labs, (0.015,), 0.03)


def table(labs: int, scatters: Sequence[float], form: float) -> None:
    """Print one table."""
    print(f"{'law':16} {'tests':5} {'specimens':9} {'scatter':8} constants | stress at {STRETCHES}")
    every = []
    for name, tests, specimens, scatter in product(TRUTHS, TESTS, (3, 5, 8), scatters):
        share = 100.0 * trial(name, tests, specimens, scatter, labs, form)
        every.append(share[-3:].tolist() + share[:-3].tolist())
        count = len(TRUTHS[name])
        shown = (
            " ".join(f"{value:5.1f}" for value in share[:count]),
            " ".join(f"{value:5.1f}" for value in share[count:]),
        )
        print(
            f"{name:16} {len(tests):5} {specimens:9} {100 * scatter:7.1f}% {shown[0]} | {shown[1]}",
            flush=True,
        )
    values = np.concatenate(every)
    print(f"mean {values.mean():.1f} %, least {values.min():.1f} %, most {values.max():.1f} % over {labs} labs a row")


if __name__ == "__main__":
    main()
