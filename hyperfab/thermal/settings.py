"""What a reduced mold is run with: faces and joints by a few points, and the numbers of many runs."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields
from functools import cached_property

import numpy as np

from hyperfab.arrays import Array, Ints
from hyperfab.thermal.lumping import lumped
from hyperfab.thermal.tables import Table

#: Points that stand for a face, and how many times as many as there are unknowns at least: fewer points than unknowns
#: cannot carry what is of second degree in them.
POINTS, _MORE = 48, 2
#: A conductance or resistance that varies over a face falls to no less than this share of its mean.
_LEAST = 0.05
#: Resistance of a joint that counts as perfect [m^2 K/W].
PERFECT = 1e-7


@dataclass(frozen=True)
class Film:
    """A face that loses heat: rows of the basis at its points (q, r), their areas (q,), its film and ambient."""

    rows: Array
    weights: Array
    film: Table
    ambient: Table
    emissivity: float = 0.0


@dataclass(frozen=True)
class Patch:
    """A joint, or a bench by a few points: rows of the basis (q, r) (of the jump), areas (q,) and ``places`` (q, 3).

    The places are how far from the middle, and along the two longest axes; each has an area mean of 0 and, but
    for the first, a mean square of 1. A joint keeps all of its points: one that conducts well holds the parts together
    by jumps so small that few points have lost them.
    """

    rows: Array
    weights: Array
    places: Array

    def uneven(self, slopes: Array) -> Array:
        """Return the factor at each point of what changes over the patch with ``slopes`` (3,), or fewer."""
        return np.maximum(1.0 + self.places[:, : len(slopes)] @ slopes, _LEAST)

    def jump(self, resistance: float, slopes: Array) -> Array:
        """Return the joint's matrix (r, r) for a resistance per area [m^2 K/W]."""
        if not np.any(slopes):
            return np.asarray(self._alike / (resistance + PERFECT))
        each = self.weights / (resistance * self.uneven(slopes) + PERFECT)
        return np.asarray(self.rows.T @ (each[:, None] * self.rows))

    @cached_property
    def _alike(self) -> Array:
        """The matrix (r, r) of a joint that conducts 1 W/m^2/K throughout."""
        return np.asarray(self.rows.T @ (self.weights[:, None] * self.rows))


def points_for(rows: Array) -> int:
    """Return how many points stand for a face with ``rows`` (q, r) of the basis."""
    return max(POINTS, _MORE * rows.shape[1])


def patch(rows: Array, weights: Array, points: Array, *, whole: bool = False) -> Patch:
    """Return a patch of quadrature points with rows (q, r), areas (q,) at ``points`` (q, 3) [m]: a few, or the
    ``whole`` of them."""
    if len(weights) == 0:
        return Patch(rows, weights, np.zeros((0, 3)))
    centred = points - weights @ points / weights.sum()
    _, axes = np.linalg.eigh(centred.T @ (weights[:, None] * centred))
    along = centred @ axes[:, :0:-1]
    size = np.sqrt(weights @ along**2 / weights.sum())
    along = along / np.where(size > 0.0, size, 1.0)
    far = np.sum(centred**2, axis=1)
    mean = float(weights @ far) / float(weights.sum())
    places = np.column_stack([far / mean - 1.0 if mean > 0.0 else 0.0 * far, along])
    count = points_for(rows)
    if whole or len(weights) <= count:
        return Patch(rows, weights, places)
    # Points are neighbours by where they lie and by what they feel.
    spread = float(np.sqrt(np.mean(np.var(rows, axis=0).sum()))) or 1.0
    both, areas = lumped(np.hstack([rows / spread, places[:, 1:], places[:, :1]]), weights, count)
    wide = rows.shape[1]
    return Patch(both[:, :wide] * spread, areas, both[:, [wide + 2, wide, wide + 1]])


@dataclass(frozen=True)
class Settings:
    """Numbers of a batch of b runs; each array is (b, how many there are).

    ``film``, ``conductivity``, ``capacity``, ``power`` scale what the document says; ``joint`` is the
    conductance of each joint [W/m^2/K], ``opened`` the resistance of each joint between parts that conduct perfectly
    in the document [m^2 K/W]; ``start_K`` (b, groups of parts) and ``ambient_K`` (b, faces), or (b, 1) for all of them,
    [K] are added to the start and to the ambient.

    ``effects`` (b,) are absent at 0:

    - ``emissivity``, and ``surroundings_K`` by which what it faces is warmer than the ambient;
    - ``bench`` [W/m^2/K] through faces without a film, ``bench_from_middle``, ``bench_along_x``, ``bench_along_y`` over
      them, ``bench_share`` of the face's warmth that the bench takes on within ``bench_s``;
    - ``lost``, ``lost_per_K``, ``lost_per_K2`` shares of the power, ``back_W_K`` lost while it is on, ``wire_per_K`` by
      which the heater's wire resists more at the same voltage;
    - ``conductivity_per_K``, ``capacity_per_K``, ``capacity_per_K2``;
    - those of ``air_drift``;
    - ``exponent`` of a film coefficient in its temperature difference;
    - ``joint_from_middle``, ``joint_along_x``, ``joint_along_y`` over the opened joints, ``joint_per_K`` by which they
      conduct better, ``joint_closes`` the share by which they do once they have closed, the slower the longer it
      takes, by ``joint_closes_s``; ``joint_tightens`` the same evenly, within ``joint_tightens_s``.
    """

    film: Array
    conductivity: Array
    capacity: Array
    power: Array
    joint: Array
    opened: Array
    start_K: Array
    ambient_K: Array
    effects: Mapping[str, Array] = field(default_factory=dict)

    def of(self, run: int, *names: str) -> Array:
        """Return the effects of one run, 0 where they are not given."""
        return np.array([float(self.effects[name][run]) if name in self.effects else 0.0 for name in names])

    def distinct(self) -> tuple[Settings, Ints]:
        """Return the runs that differ, in the order in which each comes first, and which of them (b,) each run is."""
        given = {one.name: getattr(self, one.name) for one in fields(self)}
        effects = given.pop("effects")
        every = np.column_stack([*given.values(), *effects.values()])
        _, first, which = np.unique(every, axis=0, return_index=True, return_inverse=True)
        rows = np.sort(first)
        kept = {name: values[rows] for name, values in given.items()}
        only = Settings(**kept, effects={name: values[rows] for name, values in effects.items()})
        return only, np.searchsorted(rows, first[which.ravel()])

    def air_K(self, run: int, times: Array) -> Array:
        """Return by how much the ambient of each face is off at ``times`` [s]: one more axis."""
        drifts = any(name.startswith("ambient_") for name in self.effects)
        drift = air_drift(lambda name: float(self.of(run, name)[0]), times) if drifts else np.zeros_like(times)
        return np.asarray(drift[..., None] + self.ambient_K[run])

    def closes(self, run: int, times: Array) -> Array:
        """Return how many times better the opened joints of one run conduct at ``times`` [s] than at the start."""
        share, slow = self.of(run, "joint_closes", "joint_closes_s")
        more, within = self.of(run, "joint_tightens", "joint_tightens_s")
        past = np.maximum(times, 0.0)
        closed = -np.expm1(-past / max(slow, 1e-9))
        return np.asarray(1.0 + share * closed + more * np.minimum(past / max(within, 1e-9), 1.0))


def air_drift(of: Callable[[str], float], times: Array) -> Array:
    """Return by how much [K] the ambient has moved at ``times`` [s], of amounts by their names.

    A cubic of ``ambient_per_s``, ``ambient_per_s2``, ``ambient_per_s3``, and a swing of ``ambient_sin_K`` and
    ``ambient_cos_K`` with the period ``ambient_period_s``.

    >>> swing = {"ambient_sin_K": 2.0, "ambient_cos_K": 1.0, "ambient_period_s": 4.0}
    >>> air_drift(lambda name: swing.get(name, 0.0), np.array([0.0, 1.0, 2.0])).round(12).tolist()
    [0.0, 1.0, -2.0]
    """
    slope, bend, twist = (of(f"ambient_per_s{power}") for power in ("", "2", "3"))
    angle = times * (2.0 * np.pi / max(of("ambient_period_s"), 1e-9))
    swing = of("ambient_sin_K") * np.sin(angle) + of("ambient_cos_K") * (np.cos(angle) - 1.0)
    return np.asarray(((twist * times + bend) * times + slope) * times + swing)
