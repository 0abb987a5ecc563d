"""Which constants of the orthotropic law the tests of a sheet tell, and which test would tell the others."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hyperfab.curve import TestCurve
from hyperfab.materials.orthotropic.energy import ABSENT, NAMES
from hyperfab.materials.orthotropic.rows import SLIGHT, across, strained


@dataclass(frozen=True)
class Unknown:
    """A constant the tests leave open, the value it has for want of one, and the test that would tell it."""

    name: str
    value: float
    test: str


def sought_by(tests: Sequence[TestCurve]) -> tuple[tuple[str, ...], tuple[Unknown, ...]]:
    """Return the constants these tests can tell, and those they leave open, each with the test that would tell it.

    >>> import numpy as np
    >>> lam = np.array([1.1, 1.2]); pull = TestCurve("uniaxial", lam, lam - 1, lam, direction=0.0)
    >>> sought_by([pull])[0]
    ('C10_MPa', 'C20_MPa', 'C30_MPa')
    """
    modes = _kinds(tests)
    angles = {test.direction for test in tests}
    uniaxial = {test.direction for test in tests if test.mode == "uniaxial"}
    ways = {_slant(a) for a in uniaxial if a is not None}
    slanted = {a for a in ways if a % 90.0 > 1e-6}
    # Strips, narrow or wide, nearer to the warp and nearer to the weft tell them apart.
    strips = {_slant(t.direction) for t in tests if t.mode in ("uniaxial", "shear") and t.direction is not None}
    spread = min(strips, default=45.0) < 45.0 - 1e-6 and max(strips, default=45.0) > 45.0 + 1e-6
    both = spread or (
        None not in angles and any(test.mode.startswith("biaxial") and test.stress2 is not None for test in tests)
    )
    contraction = any(test.contraction is not None for test in tests)
    second = contraction or len(modes) > 1
    found, open_ = ["C10_MPa", "C20_MPa", "C30_MPa"], []
    if len(modes) > 1:
        found.append("C2_MPa")
    else:
        open_.append(("C2_MPa", "a biaxial or planar test beside the uniaxial one"))
    if contraction or (both and len(modes) > 1):
        found.append("nu")
    else:
        open_.append(("nu", "the lateral stretch of the uniaxial test (column stretch 2)"))
    # Threads that draw in wherever the tests pull carry nothing in them.
    lengths = {"warp": strained(tests, 0.0), "weft": strained(tests, 90.0)}
    for name, strain in lengths.items():
        if both and strain > SLIGHT * max(lengths.values()):
            found += [f"k1_{name}_MPa", f"k2_{name}"]
        else:
            open_ += [(constant, "uniaxial tests along warp and weft") for constant in (f"k1_{name}_MPa", f"k2_{name}")]
    # Strips cut at one angle tell that angle's stiffness, not whether threads or the resistance of the angle give it; a
    # pair of threads that may lie anywhere would stand in for those of warp or weft.
    slants = "four slanted angles" if slanted else "a biaxial one"
    for name, told, test in (
        (
            "k1_bias_MPa",
            len(slanted) > 1 and len(ways) > 3,
            "uniaxial tests at two slanted angles, as 22 and 45 deg",
        ),
        (
            "k2_bias",
            len(slanted) > 1 and len(ways) > 3,
            "uniaxial tests at two slanted angles, as 22 and 45 deg",
        ),
        ("bias_deg", len(slanted) > 3, f"tests along warp and weft with lateral stretch, or {slants}"),
    ):
        if both and (second or told):
            found.append(name)
        else:
            open_.append((name, test))
    # Threads both ways and the resistance of the angle are three stiffnesses; a single strip has one, the ground's.
    several = len(ways) > 1 or len(modes) > 1
    if slanted and several and (len(ways) > 2 or not spread):
        found.append("G_MPa")
    elif slanted and not several:
        open_.append(("G_MPa", "a uniaxial test along warp or weft"))
    else:
        which = "a third angle" if slanted else "an angle"
        open_.append(("G_MPa", f"a uniaxial test at {which}, as 45 deg"))
    unknown = tuple(Unknown(name, ABSENT[name], test) for name, test in open_)
    return tuple(name for name in NAMES if name in found), unknown


def _kinds(tests: Sequence[TestCurve]) -> set[str]:
    """Return what tests count as: general biaxial stretch at ratios far apart, each axis over what it is strained by at
    most, as more than one kind."""
    general = [test for test in tests if test.mode == "biaxial-general"]
    strains = [np.stack([test.stretch, across(test)]) - 1.0 for test in general]
    # Along warp and weft, whichever is the first axis.
    strains = [
        one if _slant(test.direction or 0.0) < 45.0 else one[::-1] for test, one in zip(general, strains, strict=True)
    ]
    most = np.max([np.abs(one).max(axis=1) for one in strains], axis=0, initial=1e-9)
    found = {test.mode for test in tests} - {"biaxial-general"}
    for strain in strains:
        less, more = np.sort(strain / most[:, None], axis=0)
        # What is hardly pulled yet tells no ratio.
        ratio = (less / np.where(more > 0.0, more, 1.0))[more > 0.2 * more.max()]
        kinds = ("trellis", "uniaxial", "shear", "between", "biaxial")
        found |= {kinds[place] for place in np.digitize(ratio, (-0.5, -0.15, 0.35, 0.8))}
    return found


def _slant(angle: float) -> float:
    """Return the angle [deg] from the warp, 0 to 90, of a strip that cannot be told from its mirror image."""
    turned = angle % 180.0
    return min(turned, 180.0 - turned)
