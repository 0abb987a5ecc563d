"""How two molds lie to each other: which way they close, which is which, and the clearance at the datum."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hyperfab.arrays import Array, Flags
from hyperfab.errors import InputError
from hyperfab.pressing.curved import Drawn
from hyperfab.pressing.gap import gap_towards
from hyperfab.pressing.mold import LOOKING, Mold, PressFrame, mold
from hyperfab.surface import Surface

#: How many places of the male are tried when the closing direction is looked for.
_PROBES = 1500
#: Share of the probes that must see the female in front, and may see it behind.
_AHEAD, _BEHIND = 0.15, 0.05
#: Molds drawn deeper into each other than this, as a share of the lower one's height, are no closed tool.
_MOST_OVERLAP = 0.75


@dataclass(frozen=True)
class Clearance:
    """The closest pair along the closing axis: ``gap`` [mm] and its place on the male (3,), in the press frame."""

    gap: float
    at: Array


def closing_frame(male: Surface, female: Surface, axis: str) -> PressFrame:
    """Return the frame in which the molds close along ``axis``, male below.

    Both senses of the axis are tried; molds that are drawn into each other are parted first. InputError where the
    molds do not close along the axis, naming the axis that fits.
    """
    fits = [
        frame for name in "xyz" for frame in (PressFrame(name, 1), PressFrame(name, -1)) if _closes(male, female, frame)
    ]
    for frame in fits:
        if frame.axis == axis:
            return frame
    others = sorted({frame.axis for frame in fits})
    if not others:
        # Drawn into each other they close too, as soon as the female is taken out.
        parted = {name: _closing_when_parted(male, female, name) for name in axis + "xyz".replace(axis, "")}
        mine = parted[axis]
        if mine is not None:
            return mine
        others = [name for name, frame in parted.items() if frame is not None]
    if others:
        raise InputError(
            f"the molds do not close along {axis}",
            remedy=f"they would along {' or '.join(others)}: use --axis {others[0]}",
        )
    raise InputError(
        f"the molds do not face each other along {axis}, nor along another axis",
        remedy="check that both STL files are in the coordinates of the closed tool and in the same unit",
    )


def check_roles(male: Mold, female: Mold) -> None:
    """Refuse molds given in exchange: the male is hollow and the female bulges."""
    if _bulge(male) < -0.5 and _bulge(female) > 0.5:
        raise InputError(
            "the male mold is hollow towards the female, which bulges into it: the molds are swapped",
            remedy="exchange --male and --female",
        )


def clearance(male: Mold, female: Mold) -> Clearance:
    """Return the closest pair along the closing axis, from the vertices of both fronts.

    Raises InputError where nothing of one mold lies above the other.
    """
    up, down = np.array([0.0, 0.0, 1.0]), np.array([0.0, 0.0, -1.0])
    candidates = []
    for here, there, direction in ((male, female, up), (female, male, down)):
        if not (here.looking.any() and there.looking.any()):  # an open surface that faces away
            continue
        used = np.unique(here.faces[here.looking])
        starts = here.vertices[used]
        far = 1.0 + float(np.ptp(np.concatenate([here.vertices[:, 2], there.vertices[:, 2]])))
        gaps = gap_towards(starts, there, direction, far)
        if np.isnan(gaps).all():
            continue
        best = int(np.nanargmin(gaps))
        at = starts[best] + (0.0 if here is male else gaps[best]) * direction
        candidates.append((float(gaps[best]), at))
    if not candidates:
        raise InputError("no part of the female lies above the male", remedy="check --axis and the two STL files")
    gap, at = min(candidates, key=lambda pair: pair[0])
    return Clearance(gap, at)


def in_frame(surface: Surface, frame: PressFrame, side: int, smooth: bool = True, drawn: Drawn | None = None) -> Mold:
    """Return a mold in the press frame; it is mounted on the face that is turned away from the other mold."""
    return mold(frame.inward(surface.vertices), surface.faces, side, smooth=smooth, drawn=drawn)


def _closing_when_parted(male: Surface, female: Surface, axis: str) -> PressFrame | None:
    """The frame in which molds that overlap as drawn close once the female is taken out; the shorter way counts."""
    ways = []
    for frame in (PressFrame(axis, 1), PressFrame(axis, -1)):
        try:
            gap = clearance(in_frame(male, frame, 1), in_frame(female, frame, -1)).gap
        except InputError:
            continue
        height = min(float(np.ptp(one.vertices @ frame.direction)) for one in (male, female))
        out = Surface(female.vertices + (1.0 - gap) * frame.direction, female.faces)
        if -_MOST_OVERLAP * height < gap < 0.0 and _closes(male, out, frame):
            ways.append((-gap, frame))
    return min(ways, key=lambda way: way[0])[1] if ways else None


def _closes(male: Surface, female: Surface, frame: PressFrame) -> bool:
    """Whether much of the male sees the female in front of it along the axis, and next to nothing behind it."""
    towards = male.normals @ frame.direction
    looking = np.flatnonzero(towards > LOOKING)
    if len(looking) == 0:
        return False
    plan = np.cumsum(male.areas[looking] * towards[looking])
    chosen = looking[np.searchsorted(plan, (np.arange(_PROBES) + 0.5) / _PROBES * plan[-1])]
    starts = male.vertices[male.faces[chosen]].mean(axis=1)
    facing = female.normals @ frame.direction
    ahead = _hits(female, starts, frame.direction, facing < -LOOKING)
    behind = _hits(female, starts, -frame.direction, facing > LOOKING)
    return ahead > _AHEAD and behind < _BEHIND


def _hits(surface: Surface, starts: Array, direction: Array, right_side: Flags) -> float:
    """Share of rays whose first hit is on a face of the right side."""
    _, face = surface.ray(starts, direction)
    return float(np.mean((face >= 0) & right_side[face]))


def _bulge(one: Mold) -> float:
    """How clearly the front stands out in its middle (towards 1) or is hollow there (towards -1), seen from outside.

    The correlation of height with nearness to the middle of the plan; 0 for a flat front.
    """
    faces = one.front.faces
    centres = one.vertices[faces].mean(axis=1)
    weight = one.front.areas * np.abs(one.front.normals[:, 2])
    middle = 0.5 * (centres[:, :2].min(axis=0) + centres[:, :2].max(axis=0))
    half = 0.5 * np.ptp(centres[:, :2], axis=0)
    height = one.side * centres[:, 2]
    nearness = -np.sum(((centres[:, :2] - middle) / np.where(half > 0.0, half, 1.0)) ** 2, axis=1)
    if np.ptp(height) < 0.02 * np.max(np.ptp(centres[:, :2], axis=0)):
        return 0.0
    height = height - np.average(height, weights=weight)
    nearness = nearness - np.average(nearness, weights=weight)
    spread = np.sqrt(np.sum(weight * height**2) * np.sum(weight * nearness**2))
    return float(np.sum(weight * height * nearness) / spread) if spread > 0.0 else 0.0
