"""Markers on a draped sheet as a problem of the loop, on a forward model known from runs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import combinations
from typing import Any, ClassVar, Self

import numpy as np
from scipy.interpolate import RectBivariateSpline
from scipy.spatial import cKDTree

from hyperfab.arrays import Array, Ints
from hyperfab.cloth.round import rounded, squared
from hyperfab.loop.catalogue.drape import DataContext, entries
from hyperfab.loop.emulator import Axis, Kriged, krige
from hyperfab.loop.known import FilesProblem
from hyperfab.loop.problem import Constant, Curve, Extra
from hyperfab.loop.scatter import Guess, guess_of_cloud, patches

#: Neighbours that a marker is held against; of all markers the share that may be lost, or one; and how many times
#: further from their neighbours these are than most are, and than any other is.
_AROUND, _FEW, _FAR, _CLEARLY = 8, 0.05, 8.0, 3.0
#: What is known of how far the mold was pushed up [mm].
DEPTH_SD = 0.1
#: What the mold's size is told by: shares added to it across the way it is pushed, and along.
SIZES = ("mold width", "mold height")
#: How far the mold's middle is from the sheet's [mm].
ASIDE = ("aside x", "aside y")


@dataclass(frozen=True)
class Markers:
    """One file: places (m, 2) on the flat sheet and where they are found (m, 3) [mm]; ``index`` (3 m,) is where the
    values of a part stand in the file, ``lines`` (m,) where the markers do; ``sd`` (3 m,) is what a whole file states
    of its values."""

    name: str
    flat: Array
    found: Array
    index: Ints | None = None
    lines: Ints | None = None
    sd: Array | None = None
    kind: ClassVar[str] = "place"

    @property
    def values(self) -> Array:
        """What was read: x of all markers, then y, then z."""
        return self.found.T.ravel()

    def of(self, rows: Ints) -> Markers:
        """Return some of the markers of a file."""
        lines = None if self.lines is None else self.lines[rows]
        sd = None if self.sd is None else self.sd.reshape(3, -1)[:, rows].ravel()
        return Markers(self.name, self.flat[rows], self.found[rows], lines=lines, sd=sd)

    def parts(self) -> list[Markers]:
        """Return the patches of neighbours that are left out in turn."""
        axes = len(self.flat) * np.arange(3)[:, None]
        found = patches(self.flat, 6, 10)
        return [Markers(self.name, self.flat[rows], self.found[rows], (axes + rows).ravel()) for rows in found]

    def guess(self, predicted: Array) -> Guess:
        """Return how loud the markers seem, by what neighbours differ by less a prediction (3 m,)."""
        order = np.concatenate(patches(self.flat, 6, 10))
        flat, left = self.flat[order], (self.values - predicted).reshape(3, -1).T[order]
        # What is read of a marker is how far it has gone: where it is depends on where the axes begin.
        gone = self.found[order] - np.pad(flat, ((0, 0), (0, 1)))
        guesses = [guess_of_cloud(flat, left[:, k], gone[:, k]) for k in range(3)]
        size = float(np.sqrt(np.mean([guess.size**2 for guess in guesses])))
        if any(guess.is_assumed for guess in guesses):
            return Guess(size, guesses[0].dof, guesses[0].source)
        return Guess(size, 1.5 * len(flat), "neighbouring markers")


def mistracked(flat: Array, left: Array) -> Ints:
    """Return the few markers (k,) that a camera lost or took for others: their residuals ``left`` (m, 3) [mm] are off
    those of their neighbours on the flat sheet (``flat``, (m, 2) [mm]).

    What a model lacks moves neighbours alike: how far a residual is from the median of its neighbours' is, of a marker
    that is lost, many times what it is of most, and of any other.

    >>> x, y = (one.ravel() for one in np.meshgrid(np.arange(8.0), np.arange(8.0)))
    >>> left = np.stack([0.1 * x, 0.02 * y**2, np.sin(x)], axis=1)
    >>> left[19] += [0.0, 9.0, 0.0]
    >>> mistracked(np.stack([x, y], axis=1), left)
    array([19])
    """
    if len(flat) <= 2 * _AROUND:
        return np.empty(0, np.int64)
    near = cKDTree(flat).query(flat, _AROUND + 1)[1][:, 1:]
    away = np.linalg.norm(left - np.median(left[near], axis=1), axis=1)
    order = np.argsort(away, kind="stable")
    size, usual = away[order], float(np.median(away))
    most = max(int(_FEW * len(flat)), 1)
    alone = [k for k in range(1, most + 1) if size[-k] > max(_FAR * usual, _CLEARLY * size[-k - 1])]
    return np.sort(order[len(order) - max(alone, default=0) :])


@dataclass(frozen=True)
class Draped:
    """The sheet as runs tell it: how its nodes (n, m, 3) move with the settings, and ``base`` (n', m', 3), where the
    model itself has them on its own grid.

    The settings are the law's relative constants ``names``, of which some ``scales`` the stress, then the depth, then
    the effects. A sheet that is stiffer throughout, and heavier by as much, rests as before: settings are brought to a
    sheet as stiff as the model's own, ``carried`` being the shear modulus [MPa] and mass [g/m^2] that has (None where
    it has what does not scale so: a holder, a measured law of shear). ``round``: the sheet is the ellipse within
    ``size``. ``finer``: further runs on the model's own grid, settings and nodes: what they are off the emulated ones
    by fades away from them, and is nothing at the base. ``widths``: how many times as far as a stiffness each constant
    of the law may be off (once where none are given).
    """

    kriged: Kriged
    grid: tuple[int, int]
    base: Array
    size: tuple[float, float]
    names: tuple[str, ...]
    scales: tuple[bool, ...]
    carried: tuple[float, float] | None
    round: bool = False
    finer: tuple[tuple[Array, Array], ...] = ()
    widths: tuple[float, ...] = ()

    @property
    def axes(self) -> dict[str, Axis]:
        """The settings by name."""
        return {axis.name: axis for axis in self.kriged.axes}

    @property
    def friction(self) -> float:
        """The coefficient that the runs reach: 0 where no sheet with friction found a rest."""
        reach = self.axes["friction"].up
        return reach if reach > 1e-3 else 0.0

    def shift(self, settings: Array) -> Array:
        """Return the nodes' shift (n, m, 3) on the emulated grid."""
        return (self.kriged(settings) - self.kriged(self._at_base)).reshape(*self.grid, 3)

    @property
    def _at_base(self) -> Array:
        return np.array([axis.base for axis in self.kriged.axes])

    @cached_property
    def near(self) -> Kriged:
        """How near settings are to those of each further run: 1 there (t,), 0 at the base and at the others."""
        sites = np.stack([self._at_base, *(one for one, _ in self.finer)])
        return krige(self.kriged.axes, sites, np.eye(len(sites))[:, 1:])


@dataclass
class DrapeProblem(FilesProblem[Markers]):
    """A draped sheet and markers found on it."""

    hiding: ClassVar[bool] = True
    draped: Draped = field(kw_only=True)
    base_at: tuple[Array, ...] = field(kw_only=True)
    weights: tuple[Array, ...] = field(kw_only=True)

    def shown(self, own: Array, terms: Mapping[str, tuple[str, Array]]) -> list[Array]:
        """Return x, y, z of the markers of each file."""
        return self.at(own, self.amounts(terms))

    def at(self, own: Array, amounts: Mapping[str, float]) -> list[Array]:
        """Return x, y, z of the markers of each file, for constants and what effects add to the settings."""
        settings = settings_of(self.draped, own, amounts)
        shift = self.draped.shift(settings).reshape(-1, 3)
        shares = np.append(1.0, self.draped.near(settings) if self.draped.finer else [])
        pairs = zip(self.base_at, self.weights, strict=True)
        return [(np.tensordot(shares, base, 1) + weights @ shift).T.ravel() for base, weights in pairs]

    def on(self, draped: Draped) -> DrapeProblem:
        """Return the problem on a sheet that is known better."""
        pairs = [at_markers(draped, one.flat) for one in self.every]
        return replace(self, draped=draped, base_at=tuple(base for base, _ in pairs))

    def extras(self) -> Sequence[Extra]:
        """Return what could be marked next: all of the sheet, the rim's surroundings, the top."""
        a, b = (0.5 * side for side in self.draped.size)
        line = np.linspace(-0.95, 0.95, 15)
        u, v = (one.ravel() for one in np.meshgrid(line, line, indexing="ij"))
        if self.draped.round:
            u, v = rounded(u, v)
        x, y = a * u, b * v
        far = np.maximum(np.abs(x) / a, np.abs(y) / b)
        menu = [
            ("markers all over the sheet, 15 by 15", np.ones(len(x), dtype=bool)),
            ("markers between the clamp and the mold, where the sheet hangs free", far > 0.6),
            ("markers on the top of the mold", far < 0.45),
        ]
        found = []
        for text, rows in menu:
            flat = np.stack([x, y], axis=1)[rows]
            more = self.with_reading(Markers(text, flat, np.zeros((len(flat), 3))))
            found.append(Extra(text, {"markers": len(flat)}, more))
        return found

    def with_reading(self, reading: Markers, scale: float = 1.0, **changes: Any) -> Self:
        """Return the problem with further markers at its end."""
        base, weights = at_markers(self.draped, reading.flat)
        there = {"base_at": (*self.base_at, base), "weights": (*self.weights, weights)}
        return super().with_reading(reading, scale, **there, **changes)


def settings_of(draped: Draped, own: Array, amounts: Mapping[str, float]) -> Array:
    """Return the emulator's settings for factors of the law and the depth's offset (last), and what effects add."""
    count = len(draped.names)
    law, axes = np.array(own[:count], dtype=np.float64), draped.kriged.axes[count:]
    added = {axis.name: 0.0 for axis in axes} | {"depth": float(own[-1]), **amounts}
    if draped.carried is not None:
        stresses = np.array(draped.scales)
        factor = float(np.exp(np.mean(np.log(law[stresses])))) if stresses.any() else 1.0
        law[stresses] /= factor
        for name, had in zip(("shear", "mass"), draped.carried, strict=True):
            if name in added:
                added[name] = (had + added[name]) / factor - had
    return np.array([*law, *(added[axis.name] for axis in axes)])


def at_markers(draped: Draped, flat: Array) -> tuple[Array, Array]:
    """Return where the model has markers, and what each finer run is off there (1 + t, m, 3), and the weights (m, n m)
    of the emulated nodes there."""
    if draped.round:
        half = 0.5 * np.array(draped.size)
        flat = half * np.stack(squared(*(flat / half).T), axis=1)
    n, m = draped.grid
    weights = np.stack([
        np.outer(_lagrange(x, n, draped.size[0]), _lagrange(y, m, draped.size[1])).ravel() for x, y in flat
    ])  # fmt: skip
    base = _between(draped.base, draped.size, flat)
    off = [
        _between(nodes, draped.size, flat) - base - weights @ draped.shift(settings).reshape(-1, 3)
        for settings, nodes in draped.finer
    ]
    return np.stack([base, *off]), weights


def _between(nodes: Array, size: tuple[float, float], flat: Array) -> Array:
    """Return where a sheet of nodes (n, m, 3) is at places (k, 2) of the flat one."""
    return np.stack([_spline(nodes[:, :, k], size)(*flat.T, grid=False) for k in range(3)], axis=1)


def _spline(values: Array, size: tuple[float, float]) -> RectBivariateSpline:
    x, y = (np.linspace(-0.5, 0.5, count) * side for count, side in zip(values.shape, size, strict=True))
    return RectBivariateSpline(x, y, values, kx=min(3, len(x) - 1), ky=min(3, len(y) - 1))


def _lagrange(at: float, count: int, side: float) -> Array:
    """Return weights (count,) of evenly spaced nodes: four-point Lagrange."""
    place = (at / side + 0.5) * (count - 1)
    first = int(np.clip(np.floor(place) - 1, 0, count - 4))
    found = np.zeros(count)
    for k in range(4):
        others = [j for j in range(4) if j != k]
        found[first + k] = np.prod([(place - first - j) / (k - j) for j in others])
    return found


def drape_problem(
    draped: Draped,
    files: Sequence[Markers],
    *,
    prior: float = 0.10,
    fixed: Sequence[str] = (),
) -> DrapeProblem:
    """Return the problem of marker files; each is cut into patches, whose x, y and z are left out in turn."""
    parts = [part for one in files for part in one.parts()]
    wide = draped.widths or np.ones(len(draped.names))
    constants = [
        Constant(name, 1.0, 0.05, 20.0 * far, 0.1 * far, prior * far)
        for name, far in zip(draped.names, wide, strict=True)
    ]
    constants.append(Constant("depth", 0.0, -5.0, 5.0, DEPTH_SD, DEPTH_SD))
    curves, row = [], 0
    for number, part in enumerate(parts):
        for axis in "xyz":
            name, count = f"{part.name}, patch {number + 1}, {axis}", len(part.flat)
            curves.append(Curve(name, row, row + count, np.arange(count, dtype=np.float64)))
            row += count
    places = [at_markers(draped, part.flat) for part in parts]
    axes = draped.axes
    context = DataContext(
        prestretch=(axes["prestretch"].down, axes["prestretch"].up),
        friction=draped.friction,
        shear=axes["shear"].up if "shear" in axes else 0.0,
        mass=axes["mass"].up,
        larger=min((axes[way].up for way in SIZES if way in axes), default=0.0),
        aside=min((min(axes[way].up, axes[way].down) for way in ASIDE if way in axes), default=0.0),
    )

    def state(values: Sequence[Array]) -> Array:
        return np.concatenate([np.tile(one, 3) for one in values])

    return DrapeProblem.posed(
        parts,
        curves,
        constants,
        fixed,
        effects=entries(context),
        states={
            "x0_mm": state([part.flat[:, 0] for part in parts]),
            "y0_mm": state([part.flat[:, 1] for part in parts]),
            "z_mm": state([part.found[:, 2] for part in parts]),
            "from the middle_mm": state([np.hypot(*part.flat.T) for part in parts]),
            "axis": np.concatenate([np.repeat([0.0, 1.0, 2.0], len(part.flat)) for part in parts]),
        },
        units=("mm",),
        draped=draped,
        base_at=tuple(base for base, _ in places),
        weights=tuple(weights for _, weights in places),
    )


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
    """Return the settings to run besides the base, by axis, as shares of its reach; those without an axis are left out.

    >>> names = ("prestretch", "weft more", "shear", "mass", "friction")
    >>> len(places([Axis("law warp", 1.0, 0.3, mixes=False), *(Axis(name, 0.0, 1.0) for name in names)]))
    84
    """
    ends = {axis.name: (axis.down or axis.up) / axis.up for axis in axes if not axis.mixes}
    own = list(ends)
    found = [{name: way} for name in own for way in (1.0, -ends[name])]
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
    names = {axis.name for axis in axes}
    return [place for place in found if place.keys() <= names]


def reached(axis: Axis, settings: Array) -> Axis:
    """Return the axis no longer than the runs (t,) that found a rest."""
    return replace(
        axis,
        up=max(float((settings - axis.base).max()), 1e-9 * axis.up),
        down=min(axis.down, max(float((axis.base - settings).max()), 0.0)),
    )
