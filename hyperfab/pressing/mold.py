"""A mold as the press sees it: closing direction upward, mounting face, and the faces that mold; and where the female
stands: raised along the axis and turned about the joint it hangs on; thermal growth about its mounting face.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from hyperfab.arrays import Array, Flags, Ints
from hyperfab.pressing.curved import Curving, Drawn, curving
from hyperfab.pressing.tetra import TetraMesh, at_boundary
from hyperfab.surface import Surface

#: Columns of the press frame's coordinates for each closing axis: a cyclic change keeps right-handedness.
AXES = {"x": (1, 2, 0), "y": (2, 0, 1), "z": (0, 1, 2)}
#: A face looks along the closing direction when its normal's share along it exceeds this (about 1 degree).
LOOKING = 0.02


@dataclass(frozen=True)
class PressFrame:
    """Coordinates whose third axis is the closing direction, from the male to the female.

    >>> frame = PressFrame("x", -1)
    >>> import numpy as np
    >>> frame.inward(np.array([[1.0, 2.0, 3.0]])).tolist(), frame.outward(np.array([[2.0, -3.0, -1.0]])).tolist()
    ([[2.0, -3.0, -1.0]], [[1.0, 2.0, 3.0]])
    """

    axis: str
    sign: int

    @property
    def direction(self) -> Array:
        """The closing direction in the STL's own coordinates."""
        vector = np.zeros(3)
        vector["xyz".index(self.axis)] = self.sign
        return vector

    @property
    def plan(self) -> tuple[str, str]:
        """The names of the STL's axes across the closing direction."""
        first, second, _ = AXES[self.axis]
        return "xyz"[first], "xyz"[second]

    def inward(self, points: Array) -> Array:
        """Carry points (..., 3) from the STL's coordinates into the press frame."""
        turned = np.asarray(points)[..., AXES[self.axis]]
        return turned if self.sign > 0 else turned * np.array([1.0, -1.0, -1.0])

    def outward(self, points: Array) -> Array:
        """Carry points (..., 3) back."""
        turned = np.asarray(points) if self.sign > 0 else np.asarray(points) * np.array([1.0, -1.0, -1.0])
        back = np.argsort(AXES[self.axis])
        return np.asarray(turned[..., back])


@dataclass(frozen=True)
class Mold:
    """One mold in the press frame: ``vertices`` (n, 3) [mm], ``faces`` (m, 3), outward normals.

    ``side`` is +1 for the male, which looks up, and -1 for the female. ``mount`` is the height [mm] of its mounting
    face, about which it grows when it is heated. With ``smooth`` the facets stand for the smooth surface through
    their vertices (see ``curved``), else for themselves. ``drawn`` is what they are parts of where they were cut.
    """

    vertices: Array
    faces: Ints
    side: int
    mount: float
    smooth: bool = True
    drawn: Drawn | None = None

    @cached_property
    def surface(self) -> Surface:
        """All of the mold, for nearest points and rays."""
        return Surface(self.vertices, self.faces)

    @cached_property
    def border(self) -> tuple[Flags, Flags]:
        """Which edges ab, bc, ca of each face are open, (m, 3), and which vertices lie on such an edge, (n,)."""
        open_edge = np.asarray(self.surface.twins < 0)
        vertex = np.zeros(len(self.vertices), dtype=bool)
        for edge in range(3):
            vertex[self.faces[open_edge[:, edge]][:, [edge, (edge + 1) % 3]]] = True
        return open_edge, vertex

    @cached_property
    def looking(self) -> Flags:
        """Which faces look at the other mold, (m,)."""
        return self.surface.normals[:, 2] * self.side > LOOKING

    @cached_property
    def front(self) -> Surface:
        """The faces that look at the other mold, as a surface of its own (for heights along the axis)."""
        return Surface(self.vertices, self.faces[self.looking])

    @cached_property
    def curving(self) -> Curving:
        """How the smooth surface stands off the facets of ``surface``."""
        return curving(self.surface, self.smooth, self.drawn)

    @cached_property
    def corner_normals(self) -> Array:
        """Unit normals (m, 3, 3) of the smooth surface at the corners of each facet, on its side of creases."""
        return (self.curving if self.smooth else curving(self.surface, drawn=self.drawn)).normals

    @cached_property
    def front_curving(self) -> Curving:
        """The same for the facets of ``front``."""
        return self.curving.part(self.front, self.looking)

    def moved(self, vertices: Array, mount: float | None = None) -> Mold:
        """The same mold with its vertices elsewhere."""
        return replace(self, vertices=vertices, mount=self.mount if mount is None else mount)

    def raised(self, height: float) -> Mold:
        """The same mold, ``height`` [mm] further along the closing axis."""
        shift = np.array([0.0, 0.0, height])
        return self.moved(self.vertices + shift, self.mount + height)


def mold(
    vertices: Array,
    faces: Ints,
    side: int,
    mount: float | None = None,
    smooth: bool = True,
    drawn: Drawn | None = None,
) -> Mold:
    """Return the mold; its mounting face is the end that is turned away from the other mold, unless given."""
    heights = vertices[:, 2]
    back = float(heights.min() if side > 0 else heights.max())
    return Mold(vertices, faces, side, back if mount is None else mount, smooth, drawn)


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


@dataclass(frozen=True)
class Expansion:
    """Linear thermal expansion of a mold material, from the temperature at which its drawing holds.

    ``coefficient`` [1/K] is the mean coefficient between ``reference`` [degC] and each of ``temperatures`` [degC],
    as handbooks give it; one number holds throughout. Outside the table the nearest value is kept.

    >>> aluminium = Expansion(20.0, (100.0, 300.0), (23.6e-6, 25.2e-6))
    >>> round(float(aluminium.strain(200.0)), 9)
    0.004392
    """

    reference: float
    temperatures: tuple[float, ...]
    coefficient: tuple[float, ...]

    @classmethod
    def constant(cls, coefficient: float, reference: float) -> Expansion:
        """The same coefficient [1/K] at every temperature."""
        return cls(reference, (reference,), (coefficient,))

    def strain(self, temperature: ArrayLike) -> Array:
        """Thermal strain at ``temperature`` [degC]; zero at the reference."""
        value = np.asarray(temperature, dtype=float)
        mean = np.interp(value, self.temperatures, self.coefficient)
        return np.asarray(mean * (value - self.reference))


def extent(vertices: Array, faces: Ints) -> float:
    """Return how long [mm] a surface is, however it is turned and cut into facets: as an even bar of its largest second
    moment of area. A rectangle is as long as its longer side.

    >>> square = np.array([[0.0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0]])
    >>> round(extent(square, np.array([[0, 1, 2], [0, 2, 3]])), 12)
    2.0
    """
    corners = vertices[faces]
    middle = corners.mean(axis=1)
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    centre = area @ middle / area.sum()
    weights = np.repeat(area, 4) * np.tile([1.0, 1.0, 1.0, 9.0], len(area))
    off = np.concatenate([corners, middle[:, None]], axis=1).reshape(-1, 3) - centre
    moment = np.einsum("k,ki,kj->ij", weights, off, off) / area.sum()
    return float(np.sqrt(np.linalg.eigvalsh(moment)[-1]))


def guide_line(male: Mold) -> Array:
    """Return the line (2,) [mm], seen along the axis, from which both molds grow sideways: the male's middle.

    Guides hold the two molds to each other, so they grow from one line, and it is the middle of the tool.
    """
    plan = male.vertices[:, :2]
    return np.asarray(0.5 * (plan.min(axis=0) + plan.max(axis=0)))


@dataclass(frozen=True)
class EvenGrowth:
    """Growth by one ``strain`` from the ``fixed`` point (3,) [mm].

    >>> EvenGrowth(0.01, np.array([0.0, 0.0, -50.0])).at(np.array([[10.0, 0.0, 50.0]])).tolist()
    [[0.1, 0.0, 1.0]]
    """

    strain: float
    fixed: Array

    def at(self, points: Array) -> Array:
        """Return the displacements (n, 3) [mm] of ``points`` (n, 3)."""
        return np.asarray(self.strain * (points - self.fixed))


@dataclass(frozen=True)
class FieldGrowth:
    """Growth as the finite elements found it: ``moved`` (n, 3) [mm] at the nodes of ``mesh``, outer faces ``faces``."""

    mesh: TetraMesh
    faces: Ints
    moved: Array

    def at(self, points: Array) -> Array:
        """Return the displacements (n, 3) [mm] of the mesh's boundary nearest to ``points`` (n, 3)."""
        return at_boundary(self.mesh, self.faces, self.moved, points)[0]


#: How a hot mold has grown: the displacement of each of its points from where it is cold.
Growth = EvenGrowth | FieldGrowth


def even_growth(mold: Mold, strain: float, line: Array) -> EvenGrowth:
    """Return the growth of a mold that is equally hot throughout: its mounting face stays at its height, and
    sideways it grows from the guides' ``line`` (2,)."""
    return EvenGrowth(strain, np.array([line[0], line[1], mold.mount]))


def ungrown(points: Array, growth: Growth) -> Array:
    """Return where points (n, 3) [mm] of a hot mold's surface lie when it is cold.

    >>> growth = EvenGrowth(0.01, np.zeros(3))
    >>> ungrown(np.array([[101.0, 0.0, 0.0]]), growth).round(9).tolist()
    [[100.0, 0.0, 0.0]]
    """
    cold = points
    # Strains are below one percent: every pass gains two digits or more.
    for _ in range(8):
        cold = points - growth.at(cold)
    return np.asarray(cold)
