"""What is known of a model's own constants, as rows beside the measured ones, and problems that have such rows.

A prior that only pulls would let a constant drift three of its standard deviations off, and carry away there what
an effect does. As a reading of its own it speaks in every test.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Generic, Protocol, Self, TypeVar

import numpy as np

from hyperfab.arrays import Array, Ints
from hyperfab.loop.problem import Constant, Curve, Problem
from hyperfab.loop.scatter import Guess

#: Standard deviations a constant may be off.
SURE = 3.0
#: How many times what was known beforehand the constants of a document at fault may be off, alike beforehand.
SCALES = (0.3, 1.0, 3.0)


class File(Protocol):
    """One file, or a part of it that is left out by itself: its name, and what was read, in the order of the rows."""

    @property
    def name(self) -> str:
        """The file."""

    @property
    def kind(self) -> str:
        """The kind of reading: files of one kind were read with one instrument."""

    @property
    def values(self) -> Array:
        """What was read (m,), row by row."""

    @property
    def sd(self) -> Array | None:
        """The standard deviations that a whole file states of its values (m,)."""

    @property
    def index(self) -> Ints | None:
        """Where the rows stand in the file, of which this is a part."""

    def guess(self, predicted: Array) -> Guess:
        """Return how loud the readings of a whole file seem less a prediction (m,)."""


F = TypeVar("F", bound=File)


@dataclass(kw_only=True)
class FilesProblem(Problem, Generic[F]):
    """A model and the ``files`` that were read, or parts of them; then what is known of its constants (``priors``);
    then ``further`` readings, those that could be taken next or take no part, their rows times ``scale``."""

    files: tuple[F, ...]
    further: tuple[F, ...] = ()
    scale: tuple[float, ...] = ()
    #: The constants as they were posed, before they were held near what is known of them.
    posed_of: tuple[Constant, ...] = ()

    @classmethod
    def posed(
        cls, parts: Sequence[F], curves: Sequence[Curve], constants: Sequence[Constant], fixed: Sequence[str], **of: Any
    ) -> Self:
        """Return the problem of ``parts`` whose rows ``curves`` hold, and what is known of ``constants``, some of them
        ``fixed``, as a curve of its own; the fit sees them without a prior, for which the rows speak."""
        priors, rows = sure(constants, fixed), curves[-1].stop
        count = sum(bool(np.isfinite(one.prior_sd)) for one in priors)
        known = Curve(
            "what is known of the constants",
            rows,
            rows + count,
            np.arange(count, dtype=np.float64),
            channel=max(curve.channel for curve in curves) + 1,
            beforehand=True,
        )
        return cls(
            measured=np.concatenate([*(one.values for one in parts), np.zeros(count)]),
            curves=(*curves, known),
            own=tuple(replace(one, prior_sd=np.inf) for one in priors),
            files=tuple(parts),
            priors=priors,
            posed_of=tuple(constants),
            **of,
        )

    @abstractmethod
    def shown(self, own: Array, terms: Mapping[str, tuple[str, Array]]) -> Sequence[Array]:
        """Return what is read of each file, then of each further reading."""

    @property
    def every(self) -> tuple[F, ...]:
        """The files, then the further readings."""
        return (*self.files, *self.further)

    def predict(self, own: Array, terms: Mapping[str, tuple[str, Array]]) -> Array:
        """Return the readings, then what is known of the constants, then further readings."""
        own, count = np.asarray(own, dtype=np.float64), len(self.files)
        shown = self.shown(own, terms)
        further = (one * scale for one, scale in zip(shown[count:], self.scale, strict=True))
        return np.concatenate([*shown[:count], known(self.priors, own), *further])

    def strained(self, own: Array, far: float = SURE) -> list[str]:
        """Return which of the ``own`` constants (p,) are driven to the end of what is known of them, or so ``far``."""
        away = np.abs(known(self.priors, own)) if self.priors else np.empty(0)
        names = [one.name for one in self.priors if np.isfinite(one.prior_sd)]
        return [name for name, one in zip(names, away, strict=True) if one > far - 1e-6]

    def loosened(self, own: Array) -> Self | None:
        """Return the problem where constants at the end of what is known of them may be as far off as those of a
        document at fault; None where none is there."""
        far = {name: max(SCALES) for name in self.strained(own)}
        return self._looser(far) if far else None

    def counting_from_anywhere(self, name: str) -> Self:
        """Return the problem where a constant may be as far off as it was posed."""
        return self._looser({one.name: one.high / (SURE * one.prior_sd) for one in self.posed_of if one.name == name})

    def _looser(self, times: Mapping[str, float]) -> Self:
        """Return the problem where constants may be so many times as far off as is known of them."""
        held = [one.name for one in self.priors if one.low == one.high]
        loose = [replace(one, prior_sd=times.get(one.name, 1.0) * one.prior_sd) for one in self.posed_of]
        priors = sure(loose, held)
        return replace(self, own=tuple(replace(one, prior_sd=np.inf) for one in priors), priors=priors)

    def with_reading(self, reading: F, scale: float = 1.0, **changes: Any) -> Self:
        """Return the problem with a further reading at its end, its rows times ``scale``."""
        rows, size = len(self.measured), len(reading.values)
        curve = Curve(reading.name, rows, rows + size, np.arange(size, dtype=np.float64))
        return self.longer([curve], further=(*self.further, reading), scale=(*self.scale, scale), **changes)

    def rows_of(self, name: str) -> Ints:
        """Return the rows (m,) of a file, in its own order."""
        ends = np.cumsum([len(one.values) for one in self.files])
        mine = [(one, int(end)) for one, end in zip(self.files, ends, strict=True) if one.name == name]
        rows = np.concatenate([np.arange(end - len(one.values), end) for one, end in mine])
        order = np.concatenate([np.asarray(one.index) for one, _ in mine])
        return np.asarray(rows[np.argsort(order, kind="stable")])


def known(constants: Sequence[Constant], own: Array) -> Array:
    """Return how far the ``own`` constants (..., p) are from what is known, in standard deviations, (..., k)."""
    column = [i for i, one in enumerate(constants) if np.isfinite(one.prior_sd)]
    centre = np.array([constants[i].value for i in column])
    sd = np.array([constants[i].prior_sd for i in column])
    return np.asarray((own[..., column] - centre) / sd)


def sure(constants: Sequence[Constant], fixed: Sequence[str]) -> tuple[Constant, ...]:
    """Return constants that stay within three standard deviations of what is known of them, or are ``fixed``.

    What an effect does beyond them is then left in the readings, where every one of them can tell.
    """
    found = []
    for one in constants:
        reach = 0.0 if one.name in fixed else SURE * one.prior_sd
        low, high = max(one.low, one.value - reach), min(one.high, one.value + reach)
        found.append(replace(one, low=low, high=high, prior_sd=one.prior_sd if reach else np.inf))
    return tuple(found)
