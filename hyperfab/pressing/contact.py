"""One position of the press: pressure, force, moments and the area that touches."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np

from hyperfab.arrays import Array, Ints
from hyperfab.pressing.clip import Quadrature, positive_part
from hyperfab.pressing.gap import Front, Gap
from hyperfab.pressing.sandwich import Sandwich
from hyperfab.pressing.sums import Totals


@dataclass(frozen=True)
class Contact(Totals):
    """What the sandwich does at one position.

    ``gap`` (n,) [mm], its ``direction`` (n, 3) and the ``pressure`` (n,) [MPa] at the vertices of the front, from the
    nearest distance. ``pressed`` are the quadrature points of the totals, ``face`` (n,) the female's nearest faces.
    """

    gap: Array
    direction: Array
    face: Ints
    pressure: Array
    pressed: Quadrature

    @property
    def pressed_area(self) -> float:
        """Area [mm^2] of the male that bears: its nearest gap is less than the sandwich."""
        return float(self.pressed.area.sum())


def contact(front: Front, gap: Gap, sandwich: Sandwich) -> Contact:
    """Press the sandwich: the pressure acts along the direction to the nearest point, on the male's area.

    That direction is the gradient of the nearest gap, so the force is exactly the rate at which the stored energy
    grows with the travel.
    """
    points = positive_part(np.asarray(sandwich.thickness - gap.nearest), front.faces, front.areas)
    there = sandwich.at(partial(points.at_corners, front.faces))
    gap_there = points.at_corners(front.faces, gap.nearest)
    pressure, energy = there.borne(gap_there)
    load = pressure * points.area
    # The gap's gradient points from the female to the male: so does the push on the male.
    force, moment = points.resultant(front.faces, load, gap.direction, front.vertices)
    return Contact(
        gap=gap.nearest,
        direction=gap.direction,
        face=gap.face,
        pressure=sandwich.pressure(gap.nearest),
        force=force,
        moment=moment,
        load=float(load.sum()),
        energy=float((energy * points.area).sum()),
        pressed=points,
    )


def modes_of(points: Array, arm: Array, turns: bool = True) -> Array:
    """Return what raising the female by 1 mm and, where it ``turns``, turning it by 1 rad about x and y through ``arm``
    (3,) are for ``points`` (n, 3) [mm] of the male: displacements (n, 3, 1 or 3), the other way."""
    modes = np.zeros((len(points), 3, 3 if turns else 1))
    modes[:, 2, 0] = -1.0
    if turns:
        modes[:, :, 1] = -np.cross([1.0, 0.0, 0.0], points - arm)
        modes[:, :, 2] = -np.cross([0.0, 1.0, 0.0], points - arm)
    return modes


def stiffness(front: Front, result: Contact, sandwich: Sandwich, modes: Array) -> Array:
    """Return the tangent (d, d) of the force along ``modes`` (n, 3, d): displacements of the male per unit.

    The term of the turning directions is left out: it is small beside the foam's own, and without it the tangent
    is symmetric and never negative.
    """
    points = result.pressed
    gap = points.at_corners(front.faces, result.gap)
    rate = sandwich.at(partial(points.at_corners, front.faces)).stiffness(gap) * points.area
    closing = points.at_corners(front.faces, np.einsum("nc,ncd->nd", result.direction, modes))
    return np.asarray(np.einsum("kq,kqd,kqe->de", rate, closing, closing))
