"""Noise: one standard deviation a row, and what rows have in common, taken out of what is left."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from hyperfab.arrays import Array, Ints
from hyperfab.loop.problem import Curve
from hyperfab.loop.thresholds import TOLD

#: A common cause is left out along what it widens the noise by less than half of this, as a share.
_FELT = 1e-3
#: How many times as loud readings are, and as much specimens scatter, at most where that is nearly the same.
_NEARLY = 1.5
#: Rows of a specimen, the unit shape of what is alike in them, and how much of that is scatter.
Shape = tuple[Ints, Array, float]


@dataclass(frozen=True)
class Noise:
    """One standard deviation a row, its degrees of freedom, and what rows have in common.

    ``gain_sd`` is the scatter of the stiffness between specimens (relative), ``across_sd`` that of how much narrower
    they become, ``correlation`` that of each row with the one before it in its curve. ``whiten`` takes these out, so
    that noise becomes unit and uncorrelated. ``gain_doubt`` is what the scatter may be as well, known as it is from few
    pairs of specimens. ``groups`` are the rows of each specimen, ``across`` those of its transverse stretch, ``alike``
    and ``alike_across`` which of these are of each way of testing; where they are ``centred`` they scatter about a mean
    of their own, which is told.
    ``raised`` is how many times what readings tell of it the noise is, where a machine is off by more at least.
    ``pattern`` is what scatter is in proportion to: stresses, and 1 less a transverse stretch. ``least`` is what a
    machine may be off, in all tests alike, as a share of the largest reading of each. ``common`` (rows, k) is what k
    causes that are known to about a standard deviation, and to no fit, would each do to the readings. It is
    ``estimated`` where all of it was told by the readings themselves.
    """

    sd: Array
    dof: float
    source: str
    gain_sd: float = 0.0
    gain_doubt: float = 0.0
    correlation: Array | float = 0.0
    across_sd: float = 0.0
    starts: tuple[int, ...] = ()
    groups: tuple[Ints, ...] = ()
    across: tuple[Ints, ...] = ()
    alike: tuple[tuple[int, ...], ...] = ()
    alike_across: tuple[tuple[int, ...], ...] = ()
    pattern: Array = field(default_factory=lambda: np.empty(0))
    measured: Array = field(default_factory=lambda: np.empty(0))
    centred: bool = False
    least: float = 0.0
    raised: float = 1.0
    common: Array = field(default_factory=lambda: np.empty((0, 0)))
    estimated: bool = False

    def louder(self, chi_squared: Array) -> Array:
        """Return how many times as large its variance is where what told it drew a ``chi_squared`` of its ``dof``.

        >>> few, drew = Noise(np.ones(1), 4.0, "differences"), np.array([1.0, 4.0, 8.0])
        >>> few.louder(drew).tolist(), replace(few, raised=1.25).louder(drew).tolist()
        ([4.0, 1.0, 0.5], [2.56, 1.0, 1.0])
        """
        told = self.dof / chi_squared / self.raised**2
        return np.maximum(told, 1.0) if self.raised > 1.0 else told

    @property
    def is_correlated(self) -> bool:
        """Whether any row has something in common with the one before it."""
        return bool(np.any(self.correlation))

    @property
    def plain(self) -> Noise:
        """The noise without what the scatter of specimens and of neighbouring rows has in common."""
        return replace(self, gain_sd=0.0, across_sd=0.0, correlation=0.0)

    @cached_property
    def about_means(self) -> Noise:
        """The noise of which what specimens led alike have in common is no part: they scatter about their mean."""
        return replace(self, correlation=0.0, centred=True)

    @property
    def about(self) -> tuple[float, ...]:
        """What tells ``about_means`` of one noise from that of another of as loud readings: by how much specimens
        scatter, 0 where no two were led alike."""
        kinds = ((self.gain_sd, self.alike), (self.across_sd, self.alike_across))
        return tuple(sd if _several(alike) else 0.0 for sd, alike in kinds)

    def is_near(self, other: Noise) -> bool:
        """Whether readings are nearly as loud under another noise, and specimens scatter by nearly as much."""
        pairs = ((self.gain_sd, other.gain_sd), (self.across_sd, other.across_sd))
        alike = all(max(pair) <= _NEARLY * min(pair) for pair in pairs)
        return alike and bool(np.all(np.abs(np.log(other.sd / self.sd)) <= np.log(_NEARLY)))

    def among(self, predicted: Array, gain_sd: float) -> Noise:
        """Return the noise of specimens that scatter so much in proportion to a prediction.

        For a model that may still move: a pattern that follows the readings would draw it off the data.
        """
        return replace(self, gain_sd=gain_sd, pattern=self._sizes(predicted))

    @property
    def entropy(self) -> float:
        """Minus twice what the scatter of the specimens costs in logarithm of likelihood, above white noise."""
        if not self.gain_sd:
            return 0.0
        return float(sum(-2.0 * np.log1p(-shrink) for _, _, shrink in self._shapes(self.groups, self.gain_sd)))

    def at(self, predicted: Array) -> Noise:
        """Return the noise around a prediction: specimens scatter in proportion to prediction and reading.

        In proportion to the readings alone would reward a model for predicting too little, to the prediction alone
        for too much; their geometric mean makes the scatter one of the logarithm.
        """
        if not (self.gain_sd or self.across_sd):
            return self
        read = self._sizes(self.measured)
        # With its sign: a specimen that is stiffer has more of a pull and more of a pressure.
        both = np.sqrt(np.maximum(self._sizes(predicted) * read, 0.0))
        return replace(self, pattern=np.copysign(both, read))

    def spread(self, predicted: Array) -> Array:
        """Return one standard deviation a row of all that is noise: of the reading and of its specimen.

        It is what a perfect model would miss by, while ``sd`` is what readings of one specimen scatter by.
        """
        common, pattern = np.zeros(len(self.sd)), self.at(predicted).pattern
        for sd, groups in ((self.gain_sd, self.groups), (self.across_sd, self.across)):
            for rows in groups if sd else ():
                common[rows] = sd * pattern[rows]
        return np.hypot(self.sd, common)

    @property
    def common_sd(self) -> Array:
        """One standard deviation a row of what the causes known beforehand do to it, all together."""
        return np.sqrt(np.sum(self.common**2, axis=1)) if self.common.size else np.zeros(len(self.sd))

    def whiten(self, values: Array) -> Array:
        """Return values (rows) or columns (rows, k) in units of the noise, uncorrelated."""
        scaled = values / (self.sd if values.ndim == 1 else self.sd[:, None])
        if self.is_correlated:
            scaled = self._along(scaled)
        return self._less(self._along_causes(scaled, -1.0), -0.5 if self.centred else None)

    def coloured(self, whitened: Array) -> Array:
        """Return columns (rows, k) that were whitened as they were, of noise about means."""
        return self._along_causes(self._less(whitened, 0.5), 1.0) * self.sd[:, None]

    def weights(self, whitened: Array) -> Array:
        """Return how sums over columns (rows, k) that were whitened, of noise about means, weigh the readings,
        (rows, k): the transpose of ``whiten``."""
        return self._along_causes(self._less(whitened, -0.5), -1.0) / self.sd[:, None]

    def covariances(self, weights: Array) -> tuple[Array, Array]:
        """Return the covariance (k, k) of sums of the readings by ``weights`` (rows, k): what readings and causes that
        they have in common add, and what specimens do that differ."""
        along = weights * self.sd[:, None]
        rho = np.broadcast_to(self.correlation, len(along)).copy()
        rho[[0, *self.starts]] = 0.0
        own = np.sqrt(1.0 - rho * rho)[:, None]
        for row in range(len(along) - 2, -1, -1) if np.any(rho) else ():
            along[row] += rho[row + 1] * along[row + 1]
        along *= own
        of_readings = along.T @ along
        if self.common.size:
            together = self.common.T @ weights
            of_readings += together.T @ together
        kinds = ((self.gain_sd, self.groups), (self.across_sd, self.across))
        each = [sd * (self.pattern[rows] @ weights[rows]) for sd, groups in kinds if sd for rows in groups]
        apart = np.array(each).reshape(-1, weights.shape[1])
        return of_readings, apart.T @ apart

    def owed(self, left: Array) -> Array:
        """Return what of ``left`` (rows) the common causes are likely to have done, (rows,).

        While a model is wrong its misfit counts as noise: no cause does many times what it may to make up for it.
        """
        if not self.common.size:
            return np.zeros(len(self.sd))
        _, wide, ways = self._causes
        told, missed = self.common.T @ (left / self.sd**2), max(float(np.mean(self.whiten(left) ** 2)), 1.0)
        return self.common @ (ways @ ((ways.T @ told) / (wide**2 - 1.0 + missed)))

    def _along_causes(self, scaled: Array, power: float) -> Array:
        """Return values or columns as many times as large, along what the common causes do, as a power of how wide that
        is."""
        if not self.common.size:
            return scaled
        shapes, wide, _ = self._causes
        return scaled + (shapes * (wide**power - 1.0)) @ (shapes.T @ scaled)

    @cached_property
    def _causes(self) -> tuple[Array, Array, Array]:
        """Unit shapes (rows, r) of what the common causes do to the readings together, how many times as wide as the
        noise of a reading these scatter along each (r,), and how much of each cause is in them (k, r)."""
        told = self.common / self.sd[:, None]
        squares, ways = np.linalg.eigh(told.T @ told)
        seen = squares > _FELT
        ways, size = ways[:, seen], np.sqrt(squares[seen])
        return (told @ ways) / size, np.sqrt(1.0 + squares[seen]), ways

    def _sizes(self, values: Array) -> Array:
        """Return values (rows), of the transverse stretch by how much it is narrower."""
        found = values.copy()
        for rows in self.across:
            found[rows] = 1.0 - values[rows]
        return found

    def _less(self, scaled: Array, power: float | None) -> Array:
        """Return values or columns less what of them is scatter: about the model, or about the means of those led alike
        to a power of their covariance."""
        found = scaled.copy()
        if power is None:
            for rows, shape, shrink in (one for shapes, _ in self._scatters for one in shapes):
                found[rows] -= np.multiply.outer(shape, shrink * (shape @ scaled[rows]))
            return found
        for own, sizes, ways in self._about:
            along = np.stack([shape @ scaled[rows] for rows, shape, _ in own])
            less = along - (ways * sizes**power) @ (ways.T @ along)
            for (rows, shape, _), one in zip(own, less, strict=True):
                found[rows] -= np.multiply.outer(shape, one)
        return found

    @cached_property
    def _scatters(self) -> list[tuple[list[Shape], tuple[tuple[int, ...], ...]]]:
        """The shapes of each kind of scatter that there is, and which of them were led alike."""
        kinds = ((self.gain_sd, self.groups, self.alike), (self.across_sd, self.across, self.alike_across))
        return [(self._shapes(groups, sd), alike) for sd, groups, alike in kinds if sd]

    @cached_property
    def _about(self) -> list[tuple[list[Shape], Array, Array]]:
        """Of those led alike the shapes, and eigenvalues and eigenvectors of how they scatter about their mean."""
        found = []
        for shapes, alike in self._scatters:
            for which in _several(alike):
                own = [shapes[k] for k in which]
                wide = np.array([np.sqrt((1.0 - shrink) ** -2 - 1.0) for _, _, shrink in own])
                about = np.eye(len(own)) - 1.0 / len(own)
                found.append((own, *np.linalg.eigh(np.eye(len(own)) + np.outer(wide, wide) * about)))
        return found

    def along_stiffness(self, whitened: Array) -> Array:
        """Return what of whitened values (rows) is as another stiffness would be, of each specimen."""
        return np.array([float(shape @ whitened[rows]) for rows, shape, _ in self._shapes(self.groups, self.gain_sd)])

    def stiffness(self, whitened: Array, miss: float) -> Array:
        """Return what of whitened values (rows) is as another stiffness would be, of each way of testing.

        The sum over those tested alike, in its standard deviation: that of the readings, of all that specimens may
        scatter by, and of a smooth ``miss`` (in standard deviations of a reading) of any model.
        """
        widest = self._shapes(self.groups, max(self.gain_sd, self.gain_doubt))
        off = self.along_stiffness(whitened)
        variance, missed = np.empty((2, len(self.groups)))
        for k, (one, other) in enumerate(zip(self._shapes(self.groups, self.gain_sd), widest, strict=True)):
            rows, _, shrink = one
            off[k] /= 1.0 - shrink
            variance[k] = 1.0 / (1.0 - other[2]) ** 2
            missed[k] = miss * np.sqrt(len(rows))
        each = [list(which) for which in self.alike]
        return np.array([np.sum(off[one]) / np.sqrt(np.sum(variance[one]) + np.sum(missed[one]) ** 2) for one in each])

    def _along(self, scaled: Array) -> Array:
        rho = np.broadcast_to(self.correlation, len(scaled))[1:]
        rho = rho if scaled.ndim == 1 else rho[:, None]
        found = scaled.copy()
        found[1:] = (scaled[1:] - rho * scaled[:-1]) / np.sqrt(1.0 - rho * rho)
        first = list(self.starts)
        found[first] = scaled[first]
        return found

    def _shapes(self, groups: Sequence[Ints], sd: float) -> list[Shape]:
        """Return the rows of each group, the unit shape of what is alike in them, and how much of that is scatter."""
        pattern = self.pattern / self.sd
        if self.is_correlated:
            pattern = self._along(pattern)
        found = []
        for rows in groups:
            length = max(float(np.sqrt(pattern[rows] @ pattern[rows])), 1e-300)
            shrink = 1.0 - 1.0 / np.sqrt(1.0 + (sd * length) ** 2)
            found.append((rows, pattern[rows] / length, shrink))
        return found


def _several(alike: Sequence[tuple[int, ...]]) -> list[tuple[int, ...]]:
    """Return those led alike that are several: one alone is its own mean."""
    return [which for which in alike if len(which) > 1]


def with_misfit(noise: Noise, left: Array, residual: Array, curves: Sequence[Curve]) -> Noise:
    """Return the noise with what a model leaves, ``left`` (rows), as part of it: alike in all rows of a channel.

    A kind of reading that it meets beside another that it misses (``residual``, in standard deviations of the noise)
    and what is known beforehand stay as sure as they are.
    """
    sd = noise.sd.copy()
    kinds = [
        np.concatenate([np.arange(curve.start, curve.stop) for curve in curves if curve.channel == channel])
        for channel in {curve.channel for curve in curves if not curve.beforehand}
    ]
    missed = [rows for rows in kinds if np.mean(residual[rows] ** 2) > TOLD**2]
    for rows in missed or kinds:
        sd[rows] = np.hypot(sd[rows], np.sqrt(np.mean(left[rows] ** 2)))
    return replace(noise, sd=sd)
