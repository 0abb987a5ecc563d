"""Closing the press: cold clearance, growth of both molds, the position asked for, and what is found there."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from hyperfab.arrays import Array, Flags
from hyperfab.pressing.balance import balance
from hyperfab.pressing.gap import Front, axial_gap, molding_front, oblique
from hyperfab.pressing.mold import Mold, Pose, guide_line
from hyperfab.pressing.placement import Clearance, clearance
from hyperfab.pressing.press import Contact, Press
from hyperfab.pressing.sandwich import Sandwich


@dataclass(frozen=True)
class Case:
    """Everything that decides the answer, in the press frame.

    ``male`` and ``female`` are cold and as drawn; ``male_growth`` and ``female_growth`` the displacements (n, 3) [mm]
    of their vertices when hot, zero at the mounting face. Either ``gap`` [mm], the axial clearance at the datum, or
    ``force`` [N] is given; the clearance is set cold, or, with ``zero_hot``, again on the hot molds. The ``sandwich``
    has one value for all or one a vertex of the whole male. The press ``frame`` [N/mm] yields under the force; a
    ``floating`` female turns about a joint in its mounting face, at ``force_at`` (2,) [mm] across the axis, in the
    middle of the tool where not given. A press out of parallel holds the female at a ``tilt`` (2,) [rad] about the
    first and second axis, through the middle of the tool in its mounting face; a female mounted off the axis stands
    at an ``offset`` (2,) [mm] across it. Clearances are set before both.
    """

    male: Mold
    female: Mold
    sandwich: Sandwich
    male_growth: Array
    female_growth: Array
    gap: float | None = None
    force: float | None = None
    zero_hot: bool = False
    frame: float | None = None
    floating: bool = False
    force_at: Array | None = None
    tilt: tuple[float, float] = (0.0, 0.0)
    offset: Array | None = None


@dataclass(frozen=True)
class Closed:
    """The press at its answer.

    ``press`` stands at ``pose``, which puts the hot ``female`` where it is; ``contact`` is what the sandwich does
    there. At the vertices of ``front`` (hot): ``normal`` and ``axial`` gaps, NaN where they miss, ``touch`` the gap
    that decides what touches, flags for feet on an open edge and for oblique ones. ``cold`` (n, 3) are the same
    vertices cold. ``touching`` (m,) [mm^2] is each face's touching area.
    """

    case: Case
    press: Press
    pose: Pose
    female: Mold
    contact: Contact
    cold: Array
    normal: Array
    axial: Array
    touch: Array
    at_border: Flags
    oblique: Flags
    touching: Array
    datum: Clearance
    clearance_cold: float
    clearance_hot: float

    @property
    def front(self) -> Front:
        """The molding part of the hot male."""
        return self.press.front

    @property
    def first_touch(self) -> float:
        """The opening at which the sandwich is first touched [mm]."""
        return self.press.first_touch

    @property
    def stroke(self) -> float:
        """Travel [mm] from the first touch of the sandwich to the answer; negative where it is not touched yet."""
        return self.first_touch - self.pose.opening


def close_press(case: Case) -> Closed:
    """Close the press and look at the sandwich.

    Raises InputError where the molds do not lie over each other, or where the force cannot be reached, and
    NotConverged where a floating female tips over.
    """
    datum = clearance(case.male, case.female)
    # With a force the position is solved below; where the molds start from does not matter.
    start = 0.0 if case.gap is None else case.gap - datum.gap
    male = case.male.moved(case.male.vertices + case.male_growth)
    female = case.female.moved(case.female.vertices + case.female_growth).raised(start)
    if case.gap is not None and case.zero_hot:
        shift = case.gap - clearance(male, female).gap
        female, start = female.raised(shift), start + shift

    if case.offset is not None and case.offset.any():
        female = female.moved(female.vertices + np.array([*case.offset, 0.0]))
    front = molding_front(male, female)
    at = guide_line(case.male) if case.force_at is None else case.force_at
    base = Pose(0.0, case.tilt, (float(at[0]), float(at[1]), female.mount))
    press = Press(front, female, case.sandwich.of_vertices(front.of_mold), base)
    pose = _pose(case, press)
    result = press.at(pose)
    stays = pose.opening == 0.0 and pose.angle == 0.0
    # A female that stays where it is keeps its search tree.
    there = female if stays else female.moved(pose.carry(female.vertices), female.mount + pose.opening)
    nearest = press.gap(pose)
    along, touch = press.touch(pose, result.gap)
    part = press.touching(touch)
    return Closed(
        case=case,
        press=press,
        pose=pose,
        female=there,
        contact=result,
        cold=case.male.vertices[front.of_mold],
        normal=along,
        axial=axial_gap(front.vertices, there),
        touch=touch,
        at_border=nearest.at_border,
        oblique=oblique(front, nearest),
        touching=part.per_face(np.ones(part.area.shape), len(front.faces)),
        datum=datum,
        clearance_cold=datum.gap + start + pose.opening,
        clearance_hot=clearance(male, there).gap,
    )


def press_again(closed: Closed, sandwich: Sandwich) -> Closed:
    """Press a sandwich of the same thickness by another law: closed anew only where the position hangs on it."""
    case = replace(closed.case, sandwich=sandwich)
    if case.force is not None or case.frame is not None or case.floating:
        return close_press(case)
    press = replace(closed.press, sandwich=sandwich.of_vertices(closed.front.of_mold))
    return replace(closed, case=case, press=press, contact=press.at(closed.pose))


def _pose(case: Case, press: Press) -> Pose:
    opening = 0.0 if case.force is None else press.opening_for(case.force)
    start = replace(press.base, opening=opening)
    pose, _ = balance(press, start, case.force, None if case.force else case.frame, case.floating)
    return pose
