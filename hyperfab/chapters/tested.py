"""How far the tests behind a fabric's constants went."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import ArrayLike

from hyperfab.curve import TestCurve
from hyperfab.documents.material import Tested


def tested_by(curves: Iterable[TestCurve]) -> dict[str, Tested] | None:
    """Return the range of stretch and temperature of each kind of test, None where there is no curve.

    In simple shear the stretch is the largest principal one.

    >>> curves = [TestCurve("shear", np.array([1.1, end]), np.zeros(2)) for end in (1.5, 1.4)]
    >>> tested_by(curves)["shear"].stretch
    (1.0, 1.5)
    """
    stretches: dict[str, list[float]] = {}
    warmths: dict[str, list[float]] = {}
    for curve in curves:
        sheared = curve.mode == "simple-shear"
        along = np.exp(np.arcsinh(0.5 * curve.stretch)) if sheared else curve.stretch
        across = curve.stretch2 if curve.mode == "biaxial-general" else None
        warmth = curve.warmth if curve.warmth is not None else curve.temperature_degC
        # Every test passes through rest, whether or not its first reading is taken there.
        stretches.setdefault(curve.mode, [1.0]).extend([*_finite(along), *_finite(across)])
        warmths.setdefault(curve.mode, []).extend(_finite(warmth))
    return {
        test: Tested(
            stretch=(min(found), max(found)),
            temperature_degC=(min(warmths[test]), max(warmths[test])) if warmths[test] else None,
        )
        for test, found in stretches.items()
    } or None


def _finite(values: ArrayLike | None) -> list[float]:
    if values is None:
        return []
    found = np.ravel(np.asarray(values, dtype=np.float64))
    return [float(value) for value in found[np.isfinite(found)]]
