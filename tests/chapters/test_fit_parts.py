"""What several kinds of tests add to how unsure constants are, from the specimens to what hangs on the constants."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import t as student

from hyperfab.chapters.fit.describe import uncertainty
from hyperfab.chapters.fit.identify import Identified, Setting, identify
from hyperfab.curve import TestCurve
from hyperfab.materials import bind, law
from hyperfab.materials.modes import nominal_stress
from hyperfab.numerics.propagation import Source, linear

TRUTH = {"C10_MPa": 0.12, "C01_MPa": 0.03}
SPECIMENS, SCATTER = 3, 0.005


def fitted(draw: np.random.Generator) -> Identified:
    """Return the constants of a lab of uniaxial and planar specimens that differ in stiffness alone."""
    curves = []
    for mode, most in (("uniaxial", 1.8), ("shear", 1.7)):
        lam = np.linspace(1.0, most, 21)[1:]
        stress = nominal_stress(bind("mooney-rivlin-2", TRUTH), mode, lam)
        for number in range(SPECIMENS):
            read = stress * (1.0 + SCATTER * draw.standard_normal())
            curves.append(TestCurve(mode, lam, read, source=mode, specimen=str(number)))
    found = identify(law("mooney-rivlin-2"), curves, Setting(("uniaxial", "shear"), True, False, 1.0))
    assert isinstance(found, Identified)
    return found


@pytest.mark.slow
def test_intervals_of_all_that_hangs_on_the_constants_hold_the_truth() -> None:
    """Forces along every way in the plane of the constants: some hang on one of the two tests nearly alone."""
    draw = np.random.default_rng(4)
    angles = np.radians(np.arange(0.0, 180.0, 7.5))
    ways = np.array([np.cos(angles), np.sin(angles)]).T
    held = []
    for _ in range(400):
        found = fitted(draw)
        known = found.certainty.scatter
        assert known is not None
        source = Source("constants", known.covariance, known.freedom, known.parts)
        off = ways @ (np.array(list(TRUTH.values())) - list(found.material.parameters.values()))
        bands = [linear(0.0, source.root.T @ way, [source]) for way in ways]
        held.append([band.low <= value <= band.high for band, value in zip(bands, off, strict=True)])
    share = np.mean(held, axis=0)
    # 400 labs know 95 % within 1.1 %; Welch and Satterthwaite's t is on the safe side between its parts.
    assert share.min() > 0.92, share
    assert share.max() < 0.99, share


def test_parts_stand_in_the_document_where_there_are_several() -> None:
    found = fitted(np.random.default_rng(1))
    told = uncertainty(found.certainty, found.specimens)
    assert told.parts is not None
    assert [part.degrees_of_freedom for part in told.parts] == [2, 2]
    total = sum(np.array(part.covariance) for part in told.parts)
    # Each constant's own interval is the same by both.
    variance = np.array([np.diag(part.covariance) for part in told.parts])
    each = variance.sum(axis=0) ** 2 / (variance**2 / 2.0).sum(axis=0)
    half = student.ppf(0.975, each) * np.sqrt(np.diag(total))
    widened = student.ppf(0.975, told.degrees_of_freedom) * np.sqrt(np.diag(told.covariance or []))
    assert half == pytest.approx(widened, rel=1e-9)
