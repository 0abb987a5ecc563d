"""The position the press finds by itself: floating molds, a yielding frame, a given force."""

from __future__ import annotations

from dataclasses import replace
from typing import Protocol, TypeVar

import numpy as np

from hyperfab.arrays import Array, Flags
from hyperfab.errors import NotConverged
from hyperfab.pressing.gap import Front
from hyperfab.pressing.mold import Pose
from hyperfab.pressing.sums import Totals

#: A floating mold that turns further than this has tipped over.
TIPPED_DEG = 10.0
_TOLERANCE = 1e-9
_STEPS = 60


Acting = TypeVar("Acting", bound=Totals)


class Balanced(Protocol[Acting]):
    """What is balanced: a female over a male's ``front``."""

    @property
    def front(self) -> Front:
        """The molding part of the male."""

    def at(self, pose: Pose) -> Acting:
        """Return what acts with the female at a pose."""

    def tangent(self, pose: Pose, here: Acting) -> Array:
        """Return what raising the female and turning it about x and y change (3, 3), by what acts ``here``."""


def balance(
    press: Balanced[Acting],
    start: Pose,
    force: float | None,
    frame: float | None,
    floating: bool,
    begun: Pose | None = None,
    tolerance: float = _TOLERANCE,
) -> tuple[Pose, Acting]:
    """Return the pose at which everything balances, and what acts there.

    It is looked for from ``start`` on, or from ``begun`` where that is given. With ``force`` [N] the closing force is
    that; else the position was set at ``start`` and the press ``frame`` [N/mm] yields under the force (None: it does
    not). A ``floating`` female turns about its pivot until the pressure has no moment there. Newton's method on the
    energy of sandwich, frame and load, with the tangent of the sandwich, to a ``tolerance`` over the load.

    Raises NotConverged where the female tips over: the force acts outside the area that could carry it.
    """
    # At a set position that cannot yield, only the tilt is free.
    free = np.array([force is not None or frame is not None, floating, floating])
    pose = begun or start
    here = press.at(pose)
    residual = _residual(here, pose, start, force, frame)
    half = 0.5 * float(np.ptp(press.front.vertices[:, :2], axis=0).max()) if floating else 1.0
    for _ in range(_STEPS):
        newton = max(here.load, force or 0.0, 1e-12)
        scale = np.array([newton, newton * half, newton * half])
        if not free.any() or np.abs(residual / scale)[free].max() < tolerance:
            return pose, here
        step = _newton_step(press, here, pose, residual, force, frame, free)
        for _ in range(12):
            moved = _moved(pose, step)
            if np.degrees(moved.angle) > TIPPED_DEG:
                break
            there = press.at(moved)
            left = _residual(there, moved, start, force, frame)
            if np.linalg.norm((left / scale)[free]) < np.linalg.norm((residual / scale)[free]):
                pose, here, residual = moved, there, left
                break
            step = 0.5 * step
        else:
            # Rounding is reached where the residual is already tiny; anything else is no balance.
            if np.abs(residual / scale)[free].max() < 1e-6:
                return pose, here
            break
        if np.degrees(moved.angle) > TIPPED_DEG:
            break
    raise NotConverged(
        "the floating female finds no balance: it tips over" if floating else "no position balances the frame",
        remedy="move the force into the area that touches (--force-at), or guide the mold (without --float)",
    )


def _residual(here: Totals, pose: Pose, start: Pose, force: float | None, frame: float | None) -> Array:
    """Unbalanced force along the axis [N], positive where the female is pushed open, and moments [N mm]."""
    # The female feels the opposite of what acts on the male.
    moment = -(here.moment - np.cross(pose.arm, here.force))
    held = force if force is not None else (frame or 0.0) * (pose.opening - start.opening)
    return np.array([here.closing_force - held, moment[0], moment[1]])


def _newton_step(
    press: Balanced[Acting],
    here: Acting,
    pose: Pose,
    residual: Array,
    force: float | None,
    frame: float | None,
    free: Flags,
) -> Array:
    tangent = press.tangent(pose, here)[np.ix_(free, free)]
    if force is None and frame is not None:
        tangent[0, 0] += frame
    tangent += 1e-12 * np.trace(tangent) * np.eye(len(tangent)) + 1e-300 * np.eye(len(tangent))
    step = np.zeros(3)
    step[free] = np.linalg.solve(tangent, residual[free])
    return step


def _moved(pose: Pose, step: Array) -> Pose:
    tilt = (pose.tilt[0] + float(step[1]), pose.tilt[1] + float(step[2]))
    return replace(pose, opening=pose.opening + float(step[0]), tilt=tilt)
