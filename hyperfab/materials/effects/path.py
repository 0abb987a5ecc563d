"""What an effect on the stress may ride on, and the way through which specimens were led: stretch, time and
temperature, row after row, test after test."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from hyperfab.arrays import Flags, Ints
from hyperfab.materials.effects.kept import Kept
from hyperfab.materials.law import Array
from hyperfab.numerics.doubt import moving, pace
from hyperfab.numerics.hygiene import branches

#: Codes of the deformation modes in ``Path.mode``.
UNIAXIAL, SHEAR, BIAXIAL, GENERAL, CONFINED, SIMPLE_SHEAR = range(6)
#: Their names; those of a sheet first, then those that the law of a foam alone is asked in.
MODE_NAMES = ("uniaxial", "shear", "biaxial", "biaxial-general", "confined-compression", "simple-shear")

#: A reversal smaller than this share of a curve's range of stretch is a reading's noise, not a turn.
REVERSAL = 0.02
#: Rows of one stretch that are a hold; else it lasts as long as the pace of a test takes for this share of its range.
_HOLD, _LONG = 8, 0.1
#: Bands that a machine wobbles in while it holds, in shares of that range.
_WOBBLE = (0.0005, 0.004)
#: What a held stretch wobbles by is gone through in less than this share of the hold, at the pace of the test.
_STANDS = 0.01


@dataclass(frozen=True)
class Path:
    """Rows of all curves, curve after curve; ``starts`` holds the first row of each and the number of rows.

    ``stretch`` along the pull, in simple shear the larger one in the plane (below 1 where it shears the other way),
    ``across`` the measured second stretch of general biaxial tests (nan
    elsewhere), ``time_s``,
    ``temperature_degC`` and ``angle_deg`` from the warp (nan where unknown), ``branch`` (+1, -1, 0 where not stated).
    ``lengths_mm`` and ``sections`` (in any one unit) are those of each curve's specimen, nan where they are not stated.
    """

    starts: tuple[int, ...]
    mode: Ints
    stretch: Array
    across: Array
    time_s: Array
    temperature_degC: Array
    angle_deg: Array
    branch: Ints
    lengths_mm: tuple[float, ...] = ()
    sections: tuple[float, ...] = ()

    @cached_property
    def shorter(self) -> Array | None:
        """What strain the same length is in each row (n,), over that in the first specimen of a stated length; None
        where all are as long as far as is known.

        >>> pulls = replace(uniaxial_pull(np.ones(4)), starts=(0, 2, 4), lengths_mm=(50.0, 200.0))
        >>> pulls.shorter
        array([1.  , 1.  , 0.25, 0.25])
        """
        return self._smaller(self.lengths_mm)

    @cached_property
    def thinner(self) -> Array | None:
        """What stress the same force is in each row (n,), over that in the first specimen of a stated section; None
        where all are alike as far as is known."""
        return self._smaller(self.sections)

    def _smaller(self, sizes: tuple[float, ...]) -> Array | None:
        known = [size for size in sizes if np.isfinite(size)]
        if len({*known}) < 2:
            return None
        of_each = [known[0] / size if np.isfinite(size) else 1.0 for size in sizes]
        return np.repeat(of_each, np.diff(self.starts))

    @cached_property
    def curves(self) -> list[slice]:
        """Rows of each curve."""
        return [slice(a, b) for a, b in zip(self.starts[:-1], self.starts[1:], strict=True)]

    @cached_property
    def least(self) -> Array:
        """The least elastic stretch: a strip let go hangs slack at 1, a sheet held along two axes may be shorter."""
        return np.where(self.mode == GENERAL, 0.0, 1.0)

    @cached_property
    def other_axis(self) -> Path:
        """The way of the second axis of general biaxial tests; the other rows are as they are."""
        general = self.mode == GENERAL
        return replace(
            self,
            stretch=np.where(general, self.across, self.stretch),
            across=np.where(general, self.stretch, self.across),
        )

    @cached_property
    def pressed(self) -> Flags:
        """Rows of tests that go farther to shorter than to longer stretches."""
        found = np.zeros(len(self.stretch), dtype=bool)
        for rows in self.curves:
            moved = self.moved(rows)
            found[rows] = moved.min() * moved.max() < 1.0 - 1e-9 and self.mode[rows.start] != GENERAL
        return found

    @cached_property
    def of_both_axes(self) -> Flags:
        """Rows of equal biaxial tests that read both axes as one: all, unless several directions were read."""
        equal, known = self.mode == BIAXIAL, np.isfinite(self.angle_deg)
        several = len(np.unique(self.angle_deg[equal & known])) > 1
        return equal & ~(known & several)

    @cached_property
    def weft_share(self) -> Array:
        """How much of the weft's answer a row has: sin^2 of the angle from the warp; half where it reads both axes."""
        share = np.where(self.of_both_axes, 0.5, np.sin(np.radians(self.angle_deg)) ** 2)
        # Rows without a direction answer like the warp.
        share = np.where(np.isfinite(share), share, 0.0)
        # sin(90 deg) squared is 1 to rounding; the weft is the weft.
        return np.asarray(np.where(np.abs(share - 1.0) < 1e-12, 1.0, share))

    @property
    def bias_share(self) -> Array:
        """How much of what lies between warp and weft a row has: sin^2 of twice the angle from the warp."""
        return np.asarray(4.0 * self.weft_share * (1.0 - self.weft_share))

    @cached_property
    def reach(self) -> float:
        """Largest strain, of what was pressed that of a pull as far."""
        return max(float(np.max(self.outward.stretch)) - 1.0, 1e-3)

    @cached_property
    def any_pressed(self) -> bool:
        """Whether any specimen is pressed."""
        return bool(np.any(self.pressed))

    def mirrored(self, stretch: Array) -> Array:
        """Return one over a stretch (n,) of pressed specimens, that of pulled ones as it is."""
        if not self.any_pressed:
            return stretch
        return np.asarray(np.where(self.pressed, 1.0 / np.where(self.pressed, stretch, 1.0), stretch))

    @cached_property
    def outward(self) -> Path:
        """The same way with pressed specimens pulled as far, by the logarithm of their stretch."""
        if not self.any_pressed:
            return self
        return replace(self, stretch=self.mirrored(self.stretch), branch=self.up)

    @cached_property
    def up(self) -> Ints:
        """+1 on the way away from rest, longer or shorter, and in waits there, -1 on the way back."""
        found = np.ones(len(self.stretch), dtype=np.int64)
        for rows in self.curves:
            stated, moved = self.branch[rows], self.moved(rows)
            if np.all(stated != 0):
                found[rows] = stated
            else:
                # A test begins with loading.
                found[rows.start + 1 : rows.stop] = branches(moved, REVERSAL)[1:]
        return found

    @cached_property
    def longer(self) -> Ints:
        """+1 where the stretch grows, -1 where it shrinks: the way a specimen is led, pulled or pressed."""
        found = self.up.copy()
        for rows in self.curves:
            moved = self.moved(rows)
            pressed = moved < 1.0 - REVERSAL * float(np.max(np.abs(moved - 1.0)))
            found[rows][pressed] *= -1
        return found

    def moved(self, rows: slice) -> Array:
        """Return the stretch of a curve that its test moves: of a general biaxial one that which moves most.

        A strip is held at a stretch in one direction while it is pulled in the other: what the held one reads is the
        machine's own wobble.
        """
        if np.any(self.mode[rows] != GENERAL):
            return self.stretch[rows]
        return moving(self.stretch[rows], self.across[rows])

    @cached_property
    def peak(self) -> Array:
        """Largest stretch so far, this row included; 1 at rest."""
        found = np.empty_like(self.stretch)
        for rows in self.curves:
            found[rows] = np.maximum(np.maximum.accumulate(self.stretch[rows]), 1.0)
        return found

    @cached_property
    def earlier_peak(self) -> Array:
        """Largest stretch of the pulls before the present one; 1 in the first pull."""
        found = np.ones_like(self.stretch)
        for rows in self.curves:
            up, peak = self.up[rows], self.peak[rows]
            past = 1.0
            for i in range(1, len(up)):
                if up[i] > 0 and up[i - 1] < 0:
                    past = peak[i - 1]
                found[rows.start + i] = past
        return found

    @cached_property
    def turn(self) -> Ints:
        """Row of the last turn from loading to unloading, -1 while loading."""
        found = np.full(len(self.stretch), -1, dtype=np.int64)
        for rows in self.curves:
            top = rows.start
            for i in range(rows.start, rows.stop):
                if self.up[i] > 0:
                    top = i
                else:
                    found[i] = top
        return found

    @cached_property
    def returns(self) -> Array:
        """How often the specimen was let go so far."""
        found = np.zeros_like(self.stretch)
        for rows in self.curves:
            up = self.up[rows]
            found[rows.start + 1 : rows.stop] = np.cumsum((up[1:] < 0) & (up[:-1] > 0))
        return found

    @cached_property
    def elapsed(self) -> Array:
        """Time since the row before [s]; since rest for the first row, at the pace of the next."""
        found = np.full_like(self.stretch, np.nan)
        for rows in self.curves:
            time, lam = self.time_s[rows], self.stretch[rows]
            step = np.diff(time)
            found[rows.start + 1 : rows.stop] = step
            if len(time) > 1:
                moved = abs(lam[1] - lam[0])
                slowness = step[0] / moved if moved > 1e-9 else 0.0
                found[rows.start] = max(slowness * (lam[0] - 1.0), 0.0)
        return found

    @cached_property
    def waited(self) -> Array:
        """``elapsed``, never less than zero."""
        return np.maximum(self.elapsed, 0.0)

    @cached_property
    def speed(self) -> Array:
        """Rate of the stretch since the row before [1/s], with its sign; 0 in the first row, in a hold and where time
        stands."""
        found = np.zeros_like(self.stretch)
        moved = np.diff(self.stretch, prepend=1.0)
        going = (np.nan_to_num(self.elapsed) > 1e-12) & ~self.still
        going[[rows.start for rows in self.curves]] = False
        found[going] = moved[going] / self.elapsed[going]
        return found

    @cached_property
    def still(self) -> Flags:
        """Rows that stand in a hold of their test."""
        return np.concatenate([held(self.moved(rows), self.time_s[rows]) for rows in self.curves])

    @property
    def knows_time(self) -> bool:
        """Whether every row has a time."""
        return bool(np.all(np.isfinite(self.time_s)))


def second_stretch(mode: Ints, stretch: Array, strip: Array, side: Array) -> Array:
    """Return the stretch across the pull: ``strip`` of uniaxial rows, as along it where both axes go alike, 1 where the
    sheet is held across, else ``side``.

    >>> mode = np.array([UNIAXIAL, SHEAR, BIAXIAL, GENERAL])
    >>> second_stretch(mode, np.full(4, 1.5), np.full(4, 0.8), np.full(4, 1.2))
    array([0.8, 1. , 1.5, 1.2])
    """
    given = np.where(mode == BIAXIAL, stretch, np.where(mode == SHEAR, 1.0, side))
    return np.where(mode == UNIAXIAL, strip, given)


def held(stretch: Array, clock: Array) -> Flags:
    """Return which rows stand in a hold: about the same stretch for several rows, more than digits would repeat.

    A machine that holds wobbles: the stretch stays in a narrow band, for far longer than the test takes to cross it.
    ``clock`` is the time; where it is unknown each row takes as long.

    >>> wobble = 1.3 + 1e-4 * np.sin(np.arange(12.0) ** 2)
    >>> path = np.concatenate([np.linspace(1.0, 1.3, 11), wobble])
    >>> held(path, np.arange(23.0)).sum(), held(np.linspace(1.0, 1.3, 9999), np.arange(9999.0)).sum()
    (np.int64(12), np.int64(0))
    """
    still = np.zeros(len(stretch), dtype=bool)
    step, span, reach = np.abs(np.diff(stretch)), np.diff(clock), float(np.ptp(stretch))
    if reach <= _WOBBLE[0] * float(np.max(np.abs(stretch - 1.0), initial=0.0)):
        still[1:] = len(stretch) > _HOLD
        return still
    timed = bool(np.all(span >= 0.0) and np.any(span > 0.0))
    since = clock if timed else np.arange(float(len(stretch)))
    usual = pace(step, np.diff(since))
    alike = np.concatenate([[0], np.cumsum(step > 1e-9)])
    # A wobble about the edge of one band is inside another that is shifted by half.
    bands = [np.floor(stretch / (share * reach) + shift) for share in _WOBBLE for shift in (0.0, 0.5)]
    for band in (alike, *bands):
        edges = [0, *(1 + np.flatnonzero(np.diff(band))), len(stretch)]
        for start, stop in itertools.pairwise(edges):
            ways = usual * float(since[stop - 1] - since[start])
            long = ways >= _LONG * reach and stop - start > (2 if timed else _HOLD)
            if long or (band is alike and stop - start > _HOLD):
                still[start + 1 : stop] |= float(np.ptp(stretch[start:stop])) <= _STANDS * ways
    return still


def uniaxial_pull(stretch: Array, angle_deg: float = 0.0) -> Path:
    """Return the path of one uniaxial pull along a direction, of which nothing else is known."""
    unknown = np.full_like(stretch, np.nan)
    return Path(
        starts=(0, len(stretch)),
        mode=np.full(len(stretch), UNIAXIAL),
        stretch=stretch,
        across=unknown,
        time_s=unknown,
        temperature_degC=unknown,
        angle_deg=np.full_like(stretch, angle_deg),
        branch=np.zeros(len(stretch), dtype=np.int64),
    )


@dataclass(frozen=True)
class State:
    """The rows of all tests once the law has answered.

    path            how specimens were led
    stretch         (n,) of the specimen itself: play is taken up, a set has lengthened it
    energy          (n,) of the law there [MPa], 0 where no effect asks for it
    reference_degC  the temperature that the law's constants are of
    rate            (n,) strain rate of each test [1/s], nan where unknown
    quick           how many times as fast the material's own clock runs up to each row: (n,), or 1
    kept            answers that path and stretch alone decide, beside what they are kept by
    """

    path: Path
    stretch: Array
    energy: Array
    reference_degC: float
    rate: Array | None
    quick: Array | float = 1.0
    kept: Kept = field(default_factory=Kept)

    @cached_property
    def greatest(self) -> Array:
        """The largest energy so far (n,)."""
        found = np.empty_like(self.energy)
        for rows in self.path.curves:
            found[rows] = np.maximum.accumulate(self.energy[rows])
        return found

    @cached_property
    def pace(self) -> float:
        """The usual strain rate of the tests [1/s]."""
        speed = np.abs(self.path.speed)
        return float(np.exp(np.mean(np.log(speed[speed > 0.0])))) if np.any(speed > 0.0) else 1.0

    @cached_property
    def usual_rate(self) -> float:
        """The mean of the stated strain rates [1/s], geometric."""
        assert self.rate is not None
        known = self.rate[np.isfinite(self.rate)]
        return float(np.exp(np.mean(np.log(known))))


#: A form of an effect on the stress: of the state, the stress (n,) [MPa] before it and the form's constants.
Acts = Callable[[State, Array, Array], Array]
