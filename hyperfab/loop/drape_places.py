"""At which settings a sheet is draped for the loop: along each axis, and where effects act together."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import combinations

from hyperfab.loop.emulator import Axis
from hyperfab.loop.problem import Array

#: Places along an effect's axis, of its reach, and of two that act together: closer where little is there to hold.
_ALONE = (0.08, 0.2, 0.5, 0.8, 1.0)
_PAIRS = (
    (0.08, 0.4), (0.4, 0.08), (0.2, 0.2), (0.2, 0.5), (0.5, 0.2), (0.5, 0.5), (0.2, 0.8), (0.8, 0.2), (0.8, 0.5),
    (0.5, 0.8),
)  # fmt: skip
#: With friction, which takes ten times as long.
_RUBBING = ((0.3, 0.3), (0.7, 0.3), (0.3, 0.7))
_TRIPLES = ((0.3, 0.3, 0.3), (0.6, 0.3, 0.3), (0.3, 0.6, 0.3), (0.3, 0.3, 0.6))
#: The stretch along the warp, and how much more along the weft.
_UNEVEN = ((0.2, 0.3), (0.5, 0.3), (0.5, -0.3), (0.8, -0.5), (0.3, -0.2))
#: A constant of the model beside an effect.
_OWN, _BESIDE = 0.7, 0.35

_SMOOTH = ("prestretch", "shear", "mass")


def places(axes: Sequence[Axis]) -> list[dict[str, float]]:
    """Return the settings to run besides the base, by axis, as shares of its reach.

    >>> axes = [Axis("law warp", 1.0, 0.3), *(Axis(n, 0.0, 1.0) for n in ("prestretch", "shear", "mass", "friction"))]
    >>> len(places([*axes, Axis("weft more", 0.0, 1.0)]))
    84
    """
    own = [axis.name for axis in axes if axis.name.startswith("law ") or axis.name == "depth"]
    found = [{name: way} for name in own for way in (1.0, -1.0)]
    found += [{name: share} for name in (*_SMOOTH, "friction") for share in _ALONE]
    down = next(axis.down / axis.up for axis in axes if axis.name == "prestretch")
    found += [{"prestretch": -share * down} for share in (0.5, 1.0) if down > 0.0]
    for one, other in combinations(_SMOOTH, 2):
        found += [{one: a, other: b} for a, b in _PAIRS]
    found += [dict(zip(_SMOOTH, shares, strict=True)) for shares in _TRIPLES]
    found += [{"weft more": share} for share in (0.2, 0.5, 1.0)]
    found += [{"prestretch": a, "weft more": b} for a, b in _UNEVEN]
    for name in ("shear", "mass"):
        found += [{"weft more": 0.3, name: 0.3}]
        found += [{"prestretch": 0.5, "weft more": b, name: 0.3} for b in (-0.3, 0.3)]
    found += [{"friction": a, name: b} for name in _SMOOTH for a, b in _RUBBING]
    found += [{"friction": 0.5, "weft more": 0.3}]
    found += [{name: _OWN, effect: _BESIDE} for name in own for effect in (*_SMOOTH, "friction")]
    return found


def reached(axis: Axis, settings: Array) -> Axis:
    """Return the axis no longer than the runs (t,) that found a rest."""
    return replace(
        axis,
        up=max(float((settings - axis.base).max()), 1e-9 * axis.up),
        down=min(axis.down, max(float((axis.base - settings).max()), 0.0)),
    )
