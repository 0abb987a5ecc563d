"""What stiffness tests show at rest, and whether one isotropic law can have those of all of them."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from hyperfab.curve import TestCurve

#: Strains up to which a curve tells its slope at rest, and readings that takes.
_SMALL, _ROWS = 0.1, 5
#: What readings and curved toes leave of a ratio of two slopes, beside the scatter of the readings.
_SURE = 1.05


def slope_at_rest(curves: Iterable[TestCurve]) -> tuple[float, float] | None:
    """Return the slope of the stress [MPa] at strains near zero, and how sure it is (one deviation); None: not told.

    >>> strain = np.linspace(0.0, 0.1, 11)
    >>> curve = TestCurve("uniaxial", 1.0 + strain, 0.5 * strain - 0.3 * strain**2)
    >>> round(slope_at_rest([curve])[0], 9)
    0.5
    """
    rows = [(one.stretch - (0.0 if one.mode == "simple-shear" else 1.0), one.stress) for one in curves]
    if not rows:
        return None
    strain, stress = (np.concatenate(column) for column in zip(*rows, strict=True))
    near = (np.abs(strain) <= _SMALL) & (strain != 0.0)
    if np.count_nonzero(near) < _ROWS:
        return None
    strain, stress = strain[near], stress[near]
    A = np.column_stack([strain, strain * np.abs(strain)])
    found, *_ = np.linalg.lstsq(A, stress, rcond=None)
    left = stress - A @ found
    variance = float(left @ left) / max(len(strain) - 2, 1) * float(np.linalg.pinv(A.T @ A)[0, 0])
    return float(found[0]), float(np.sqrt(variance))


def beyond_isotropy(curves: Iterable[TestCurve]) -> str | None:
    """Say where strips and simple shear are so stiff at rest that no isotropic law has both; None where one may.

    Young's modulus over the shear modulus is 2 (1 + nu): 3 where the volume is kept, and never more.
    """
    curves = tuple(curves)
    sheared = slope_at_rest(one for one in curves if one.mode == "simple-shear")
    strips = [one for one in curves if one.mode == "uniaxial"]
    pulled = slope_at_rest(one.take(one.stretch >= 1.0) for one in strips) or slope_at_rest(strips)
    if sheared is None or pulled is None or min(sheared[0], pulled[0]) <= 0.0:
        return None
    (E, sd_E), (G, sd_G) = pulled, sheared
    ratio, sure = E / G, np.hypot(sd_E / E, sd_G / G)
    if ratio * (1.0 - 2.0 * sure) <= 3.0 * _SURE:
        return None
    return (
        f"at rest strips have a modulus of {E:.3g} MPa and simple shear one of {G:.3g} MPa: E/G = {ratio:.2g}, where "
        "an isotropic law has 2 (Poisson's ratio 0) to 3 (0.5): none carries both tests; the material is not "
        "isotropic, or one of the tests is not what it is taken for"
    )
