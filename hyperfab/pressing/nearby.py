"""Presses beside one that has been closed: the gaps follow to the first order, nothing is searched again.

Where a point of the male moves by u against the point of the female that is nearest, the gap changes by its gradient
times u (``sensitivity``). What the molds grow, how far they are closed and how they are tilted move points; all else is
in the sandwich. Forces, areas and where a female balances then follow by the same code as of the press itself.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from hyperfab.arrays import Array
from hyperfab.pressing.balance import balance
from hyperfab.pressing.clip import Quadrature
from hyperfab.pressing.closing import Closed
from hyperfab.pressing.contact import Contact
from hyperfab.pressing.gap import Front, Gap
from hyperfab.pressing.growth import Growth, ungrown
from hyperfab.pressing.pose import Pose
from hyperfab.pressing.press import Press
from hyperfab.pressing.sandwich import Sandwich

#: The male's normal meets a wall no flatter than this: what it sees of a change is bounded.
_STEEP = 0.2
#: Displacements (n, 3) [mm] of cold points (n, 3).
Displacement = Callable[[Array], Array]


@dataclass(frozen=True)
class _Known:
    """Gaps at one pose: of the points ``at`` (n, 3), in the female's coordinates; ``touch`` decides what touches, and
    changes by ``rate`` (n,) of what the nearest gap does."""

    gap: Gap
    at: Array
    touch: Array
    rate: Array

    @staticmethod
    def of(press: Press, pose: Pose) -> _Known:
        gap = press.gap(pose)
        _, touch = press.touch(pose, gap.nearest)
        seen = np.maximum(-(press.front.normals * gap.direction).sum(axis=1), _STEEP)
        back = gap.direction if pose.angle == 0.0 else gap.direction @ pose.rotation
        rate = np.where(touch == gap.nearest, 1.0, 1.0 / seen)
        return _Known(replace(gap, direction=back), pose.into_female(press.front.vertices), touch, rate)


@dataclass(frozen=True)
class Beside(Press):
    """A press whose gaps are those ``known`` at a pose, but for the moves of its points and ``moved`` (n, 3) [mm] of
    the female's."""

    known: _Known | None = None
    moved: Array | float = 0.0

    def gap(self, pose: Pose) -> Gap:
        """Return the nearest gap from each vertex of the front to the female at ``pose``."""
        known = self.known
        assert known is not None
        away = pose.into_female(self.front.vertices) - known.at - self.moved
        direction = known.gap.direction
        nearest = known.gap.nearest + np.einsum("nc,nc->n", away, direction)
        turned = direction if pose.angle == 0.0 else direction @ pose.rotation.T
        return replace(known.gap, nearest=nearest, direction=turned)

    def decides(self, nearest: Array) -> Array:
        """Return the gap that decides what touches, where the nearest one is ``nearest``."""
        assert self.known is not None
        return self.known.touch + self.known.rate * (nearest - self.known.gap.nearest)

    def touched_at(self) -> float:
        """Return the opening at which the sandwich is first touched, from what is known near it."""
        nearest = self.gap(self.base).nearest
        assert self.known is not None
        direction = self.known.gap.direction
        opens = -(direction if self.base.angle == 0.0 else direction @ self.base.rotation.T)[:, 2]
        facing = opens > _STEEP
        room = np.broadcast_to(np.asarray(self.sandwich.thickness), nearest.shape) - nearest
        return float((room[facing] / opens[facing]).max())


@dataclass(frozen=True)
class Found:
    """What a press beside another one does: its ``press``, ``pose`` and ``contact``, the gap that decides what touches,
    the touching part, and the ``stroke`` [mm] since the first touch."""

    press: Beside
    pose: Pose
    contact: Contact
    touch: Array
    part: Quadrature
    stroke: float


class Neighbourhood:
    """A press that is closed, and those beside it; ``growths`` are those of the male and the female, and ``modes`` of
    each what it may grow by besides."""

    def __init__(
        self,
        closed: Closed,
        growths: tuple[Growth, Growth],
        modes: tuple[Sequence[Growth], Sequence[Growth]] = ((), ()),
    ) -> None:
        self._closed = closed
        press, pose = closed.press, closed.pose
        first = replace(press.base, opening=closed.first_touch)
        self._known, self._first = _Known.of(press, pose), _Known.of(press, first)
        self._start = closed.clearance_cold - closed.datum.gap - pose.opening
        self._offset = np.zeros(2) if closed.case.offset is None else closed.case.offset
        self._cold = [closed.cold, self._feet(self._known, growths[1]), self._feet(self._first, growths[1])]
        self._grown = [
            growth.at(points)
            for growth, points in zip((growths[0], *2 * (growths[1],)), self._cold, strict=True)
        ]
        self._modes = [
            np.array([mode.at(points) for mode in each]).reshape(len(each), *points.shape)
            for each, points in zip((modes[0], *2 * (modes[1],)), self._cold, strict=True)
        ]

    def _feet(self, known: _Known, growth: Growth) -> Array:
        """Return where the female's nearest points lie on the cold mold as drawn."""
        feet = known.at - known.gap.nearest[:, None] * known.gap.direction
        return ungrown(feet - [*self._offset, self._start], growth)

    def close(
        self,
        sandwich: Sandwich,
        *,
        growths: tuple[Displacement | float, Displacement | float] = (1.0, 1.0),
        modes: tuple[Array | None, Array | None] = (None, None),
        gap: float | None,
        force: float | None,
        frame: float | None,
        tilt: tuple[float, float],
        offset: Array,
        at: tuple[float, float],
    ) -> Found:
        """Return what the press does with another ``sandwich`` and other settings.

        ``growths`` of male and female are other displacements, or factors on those there are, and ``modes`` so much of
        each mode (k,) more. Raises NotConverged where the female finds no balance.
        """
        closed = self._closed
        start = self._start if gap is None else gap - closed.datum.gap
        male, female, first = (
            (grown * by if isinstance(by, float) else by(cold))
            + (0.0 if amounts is None else np.tensordot(amounts, along, axes=1))
            for grown, by, cold, amounts, along in zip(
                self._grown,
                (growths[0], *2 * (growths[1],)),
                self._cold,
                (modes[0], *2 * (modes[1],)),
                self._modes,
                strict=True,
            )
        )
        stays = growths[0] == 1.0 and modes[0] is None
        front = closed.front if stays else _moved(closed.front, closed.cold + male)
        rise = np.array([*(offset - self._offset), start - self._start])
        mount = closed.press.base.pivot[2] + float(rise[2])
        base = Pose(0.0, tilt, (*at, mount))
        press = Beside(
            front, closed.press.female, sandwich, base, self._known, female - self._grown[1] + rise
        )
        pose = replace(base, opening=closed.pose.opening if force is not None else 0.0)
        if force is not None or frame is not None or closed.case.floating:
            begun = replace(base, opening=closed.pose.opening)
            if closed.case.floating:
                begun = replace(begun, tilt=closed.pose.tilt)
            pose = balance(press, pose, force, frame, closed.case.floating, begun)
        contact = press.at(pose)
        touch = press.decides(contact.gap)
        there = replace(press, known=self._first, moved=first - self._grown[2] + rise)
        return Found(press, pose, contact, touch, press.touching(touch), there.touched_at() - pose.opening)


def _moved(front: Front, vertices: Array) -> Front:
    """Return the front with its vertices elsewhere; its faces grow alike."""
    ends = [int(np.argmin(front.vertices[:, 0])), int(np.argmax(front.vertices[:, 0]))]
    before, now = (np.linalg.norm(np.diff(points[ends], axis=0)) for points in (front.vertices, vertices))
    return replace(front, vertices=vertices, areas=float(now / before) ** 2 * front.areas)
