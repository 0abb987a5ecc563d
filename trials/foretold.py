"""How a budget's word on more specimens is met: the sd of a sphere's force foretold, and that of the lab with them.

A lab of n specimens foretells that its share of the force's variance goes with one over their number. Each lab then
draws as many more as it is told and fits them all. What is foretold hangs on a scatter that is itself known from n
specimens: to one over the root of 2 (n - 1). Prints, of each pair of numbers, the median of what came over what was
foretold, in how many labs it is within 20 %, and in how many it would be if the scatter alone stood between them:

    PYTHONPATH=. python -m trials.foretold [LABS]
"""

from __future__ import annotations

import sys
from math import sqrt

import numpy as np

from hyperfab.chapters.fit.identify import Identified, Setting, identify
from hyperfab.curve import TestCurve
from hyperfab.materials.registry import law
from hyperfab.numerics.propagation import Source
from trials.coverage import lab
from trials.coverage_force import Near, band_of, press_of

NAME, TESTS, SCATTER = "yeoh-3", ("uniaxial",), 0.03
#: Specimens that there are, and those that come.
STEPS = ((3, 5), (5, 5), (8, 8), (16, 16), (30, 30))
WITHIN = 0.2


def fit_of(curves: list[TestCurve]) -> tuple[np.ndarray, Source]:
    """Return the constants of a lab's curves, and how sure they are."""
    found = identify(law(NAME), curves, Setting(TESTS, relative=True, stable=False, accept=1.0))
    assert isinstance(found, Identified)
    known = found.certainty.scatter
    assert known is not None
    values = np.array(list(found.material.parameters.values()))
    return values, Source("constants", known.covariance, known.freedom, known.parts)


def ratios_by_chance(first: int, more: int, draw: np.random.Generator) -> np.ndarray:
    """Return what the scatter of ``first`` specimens and that of all would alone make of the ratio."""
    chi_first = draw.chisquare(first - 1, 100_000)
    between = draw.standard_normal(100_000) ** 2  # of the two means
    chi_all = chi_first + draw.chisquare(more - 1, 100_000) + between
    return np.sqrt(chi_all / (first + more - 1) / (chi_first / (first - 1)))


def main() -> None:
    """Print the table."""
    labs = int(sys.argv[1]) if len(sys.argv) > 1 else 400
    draw = np.random.default_rng(2026)
    press = press_of("sphere", NAME)
    print("specimens  and then  median of sd over foretold  within 20 %  by chance alone")
    for first, more in STEPS:
        pairs = []
        for _ in range(labs):
            curves = lab(NAME, TESTS, first + more, SCATTER, draw)
            pairs.append((fit_of([one for one in curves if int(one.specimen or 0) < first]), fit_of(curves)))
        near = Near(press, NAME, np.array([values for pair in pairs for values, _ in pair]))
        before, after = (
            np.array([band_of(0.0, near.slopes(pair[k][0]), pair[k][1]).sd for pair in pairs]) for k in (0, 1)
        )
        ratio = after / (before * sqrt(first / (first + more)))
        chance = ratios_by_chance(first, more, draw)
        shares = [100.0 * float(np.mean(np.abs(one - 1.0) <= WITHIN)) for one in (ratio, chance)]
        print(
            f"{first:9} {first + more:9} {np.median(ratio):27.2f} {shares[0]:10.0f} % {shares[1]:14.0f} %",
            flush=True,
        )


if __name__ == "__main__":
    main()
