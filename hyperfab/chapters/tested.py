"""How far the tests behind a fabric's constants went."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import ArrayLike

from hyperfab.documents.material import Tested


def tested_by(curves: Iterable[tuple[str, ArrayLike, ArrayLike | None]]) -> dict[str, Tested] | None:
    """Return the range of stretch and temperature of each test, None where there is no curve.

    A curve is its test (``uniaxial``, ...), its stretches, along both axes where there are two, and its temperatures
    [degC], None or nan where they are not known.

    >>> tested_by([("shear", [1.1, 1.5], 23.0), ("shear", [1.2, 1.4], None)])["shear"].stretch
    (1.0, 1.5)
    """
    stretches: dict[str, list[float]] = {}
    warmths: dict[str, list[float]] = {}
    for test, stretch, temperature in curves:
        # Every test passes through rest, whether or not its first reading is taken there.
        stretches.setdefault(test, [1.0]).extend(_finite(stretch))
        warmths.setdefault(test, []).extend(_finite(temperature))
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
