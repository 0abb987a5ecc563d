"""Where the female stands: raised along the axis and turned about the joint it hangs on."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hyperfab.arrays import Array


@dataclass(frozen=True)
class Pose:
    """The female raised by ``opening`` [mm] and turned by ``tilt`` (2,) [rad] about x and y through ``pivot`` (3,).

    >>> import numpy as np
    >>> turned = Pose(2.0, (0.0, np.pi / 2), (0.0, 0.0, 0.0))
    >>> turned.carry(np.array([[1.0, 0.0, 0.0]])).round(12).tolist()
    [[0.0, 0.0, 1.0]]
    >>> turned.into_female(turned.carry(np.array([[1.0, 2.0, 3.0]]))).round(12).tolist()
    [[1.0, 2.0, 3.0]]
    """

    opening: float
    tilt: tuple[float, float] = (0.0, 0.0)
    pivot: tuple[float, float, float] = (0.0, 0.0, 0.0)

    @property
    def angle(self) -> float:
        """How far the female is turned [rad]."""
        return float(np.hypot(*self.tilt))

    @property
    def arm(self) -> Array:
        """Where it turns (3,) [mm]."""
        return np.array([self.pivot[0], self.pivot[1], self.pivot[2] + self.opening])

    @property
    def rotation(self) -> Array:
        """The rotation matrix (3, 3): the rotation vector (tilt x, tilt y, 0), by Rodrigues' formula."""
        angle = self.angle
        if angle == 0.0:
            return np.eye(3)
        x, y = self.tilt[0] / angle, self.tilt[1] / angle
        cross = np.array([[0.0, 0.0, y], [0.0, 0.0, -x], [-y, x, 0.0]])
        return np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * (cross @ cross)

    def carry(self, points: Array) -> Array:
        """Carry points (n, 3) of the female to where they stand."""
        pivot = np.array(self.pivot)
        turned = points - pivot if self.angle == 0.0 else (points - pivot) @ self.rotation.T
        return np.asarray(turned + pivot + np.array([0.0, 0.0, self.opening]))

    def into_female(self, points: Array) -> Array:
        """Carry points (n, 3) of space into the coordinates in which the female was given."""
        pivot = np.array(self.pivot)
        moved = points - np.array([0.0, 0.0, self.opening])
        return moved if self.angle == 0.0 else np.asarray((moved - pivot) @ self.rotation + pivot)


#: The female where it was given.
UPRIGHT = Pose(0.0)
