"""A sheet ready to be computed: its mesh, law and thickness, with forces and stiffness at given nodal places.

A clamp may give: the rim then creeps inward with the tension of the sheet, on springs in the sheet's plane. Its
displacement is ``compliance`` times the membrane traction, the force per undeformed length of the rim [N/mm]: an
elastic foundation of stiffness 1/compliance along the rim, with the elements' own shape functions. Compliance zero is
the rigid clamp.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from hyperfab.arrays import Array, Ints
from hyperfab.membrane.kernels import assemble, strains
from hyperfab.membrane.mesh import SheetMesh
from hyperfab.membrane.tension_field import TAUT, Principal, Response, SheetLaw
from hyperfab.numerics.threads import in_blocks
from hyperfab.surface.topology import sides

#: A clamp this much stiffer than the sheet holds: its force could not be told from the rounding of its slip.
_RIGID = 1e-6
#: Part of the modulus that counts as stress where a sheet has none at all.
_LEAST_STRESS = 1e-6
#: Quadrature points that the law is asked for at once: what it computes on the way stays in the cache.
_POINTS = 8_192


@dataclass(frozen=True)
class Assembled:
    """The sheet at given places: energy [N mm] of what is meshed, nodal forces dE/dx (n, 3) [N], stiffness blocks."""

    energy: float
    force: Array
    blocks: Array


class Sheet:
    """A thin sheet of uniform ``thickness`` [mm], clamped on its rim.

    ``mesh`` and ``law`` say what it is made of; ``prestretch`` s holds the rim at s times its undeformed place;
    ``rim_slip`` [mm per N/mm] lets the rim creep inward from there with the tension.
    """

    def __init__(
        self, mesh: SheetMesh, law: SheetLaw, thickness: float, prestretch: float = 1.0, rim_slip: float = 0.0
    ) -> None:
        self.mesh, self.law, self.thickness, self.prestretch = mesh, law, thickness, prestretch
        gives = rim_slip * self.modulus * thickness > _RIGID * self.reach
        self.clamp = Clamp(mesh, rim_slip, self.flat) if gives else None
        self.pattern = mesh.pattern if self.clamp is None else mesh.slipping_pattern
        self._weights = mesh.weights * thickness
        nothing = np.zeros(0)
        self._answered = nothing, Response(nothing, nothing, nothing, nothing.astype(np.int8))

    @cached_property
    def reach(self) -> float:
        """Smallest distance [mm] from the punch's axis to the held rim."""
        return float(self.prestretch * np.linalg.norm(self.mesh.nodes[self.mesh.rim], axis=1).min())

    @property
    def flat(self) -> Array:
        """Places (n, 3) of the mounted sheet before the punch: the undeformed ones times ``prestretch``."""
        return np.column_stack([self.prestretch * self.mesh.nodes, np.zeros(len(self.mesh.nodes))])

    def strain(self, places: Array) -> Array:
        """Return C11, C22, C12 (m q, 3) at the quadrature points."""
        return np.asarray(strains(places, self.mesh.elements, self.mesh.gradients))

    def response(self, places: Array) -> Response:
        """Return the law's answer at the quadrature points.

        The last one is kept: a step that was tried is most often taken.
        """
        known, found = self._answered
        if np.array_equal(known, places):
            return found
        strain = self.strain(places)
        parts = [self.law(strain[k : k + _POINTS]) for k in range(0, len(strain), _POINTS)]
        found = Response(
            np.concatenate([part.energy for part in parts]),
            np.concatenate([part.stress for part in parts]),
            np.concatenate([part.stiffness for part in parts]),
            np.concatenate([part.state for part in parts]),
        )
        self._answered = places.copy(), found
        return found

    def principal(self, places: Array) -> Principal:
        """Return principal stretches and Cauchy stresses at the quadrature points."""
        return self.law.principal(self.strain(places))

    def energy(self, places: Array) -> float:
        """Return the strain energy [N mm] of the whole sheet, and of its clamp where that gives."""
        own = float((self.response(places).energy * self._weights.ravel()).sum())
        return self.mesh.copies * (own + (self.clamp.energy(places) if self.clamp else 0.0))

    def assemble(self, places: Array, support: float = 0.0, everywhere: bool = False) -> Assembled:
        """Return energy, nodal forces and stiffness at nodal places (n, 3).

        ``support`` is a tension, relative to the mean stress, that is added to the stiffness alone, where the sheet
        is wrinkled or slack, or ``everywhere``.
        """
        found = self.response(places)
        mesh = self.mesh
        level = max(float(np.abs(found.stress[:, :2]).mean()), _LEAST_STRESS * self.modulus)
        carried = np.where(everywhere | (found.state != TAUT), support * level, 0.0)
        force, blocks = np.zeros(places.shape), np.zeros((self.pattern.blocks, 3, 3))
        *batches, between = self.pattern.batches

        def add(turn: Ints) -> None:
            assemble(
                places, mesh.elements, mesh.gradients, self._weights, found.stress, found.stiffness, carried,
                self.pattern.block_of, turn, force, blocks,
            )  # fmt: skip

        in_blocks(lambda first, _: add(batches[first]), len(batches), 1)
        add(between)
        energy = float((found.energy * self._weights.ravel()).sum())
        if self.clamp:
            energy += self.clamp.add(places, force, blocks)
        return Assembled(energy, force, blocks)

    def pull(self, places: Array) -> float:
        """Return the mean force [N] per undeformed length [mm] with which the sheet pulls its rim inward."""
        rim, mesh = self.mesh.rim, self.mesh
        force = self.assemble(places).force[rim, :2]
        outward = mesh.nodes[rim] / np.linalg.norm(mesh.nodes[rim], axis=1)[:, None]
        _, nodes, _ = rim_edges(mesh)
        length = np.linalg.norm(mesh.nodes[nodes[:, 1]] - mesh.nodes[nodes[:, 0]], axis=1).sum()
        return float(np.sum(force * outward) / length)

    @cached_property
    def modulus(self) -> float:
        """Stiffness [MPa] of the barely stretched sheet, dS11/dE11: the scale of its stresses."""
        barely = np.array([[1.002, 1.002, 0.0]])
        return float(self.law(barely).stiffness[0, 0])


#: Gauss's rule of three points on the unit interval: exact for the squares of the shape functions.
_AT = 0.5 + np.sqrt(0.15) * np.array([-1.0, 0.0, 1.0])
_WEIGHT = np.array([5.0, 8.0, 5.0]) / 18.0


class Clamp:
    """Springs along the rim of ``mesh`` that hold it at ``rest`` (n, 3) [mm], free in the plane alone.

    ``compliance`` [mm per N/mm] is above zero. ``rounding`` [N] is what the rounding of places makes of nodal forces.
    """

    def __init__(self, mesh: SheetMesh, compliance: float, rest: Array) -> None:
        self.compliance = compliance
        self._rest = rest[:, :2]
        element, nodes, local = rim_edges(mesh)
        mass = _edge_mass(mesh.nodes[nodes]) / compliance
        self._nodes = nodes
        self._mass = mass
        self.rounding = 4.0 * np.finfo(float).eps * float(np.abs(mass).sum(axis=2).max() * np.abs(rest).max())
        self._block = mesh.slipping_pattern.block_of[element[:, None, None], local[:, :, None], local[:, None, :]]

    def energy(self, places: Array) -> float:
        """Return the energy [N mm] of the springs of what is meshed."""
        slip = self._slip(places)
        return 0.5 * float(np.einsum("eax,eab,ebx->", slip, self._mass, slip))

    def add(self, places: Array, force: Array, blocks: Array) -> float:
        """Add the springs' nodal forces to ``force`` (n, 3) and stiffness to ``blocks``; return their energy."""
        pull = np.einsum("eab,ebx->eax", self._mass, self._slip(places))
        for axis in (0, 1):
            np.add.at(force[:, axis], self._nodes, pull[:, :, axis])
            np.add.at(blocks[:, axis, axis], self._block, self._mass)
        return self.energy(places)

    def _slip(self, places: Array) -> Array:
        return np.asarray(places[self._nodes, :2] - self._rest[self._nodes])


def rim_edges(mesh: SheetMesh) -> tuple[Ints, Ints, Ints]:
    """Return for each element edge on the rim its element (k,), nodes (k, 2 or 3), and their places in the element."""
    local = np.array([[0, 1, 3], [1, 2, 4], [2, 0, 5]])[:, : mesh.order + 1]
    nodes = mesh.elements[:, local]
    _, number = sides(mesh.elements[:, :3], len(mesh.nodes))
    held = np.zeros(len(mesh.nodes), bool)
    held[mesh.rim] = True
    mine = held[nodes].all(axis=2) & (np.bincount(number.ravel())[number] == 1)
    element, edge = np.nonzero(mine)
    return element, nodes[element, edge], local[edge]


def _edge_mass(places: Array) -> Array:
    """Return the integrals (k, a, a) [mm] of products of shape functions along edges through ``places`` (k, a, 2)."""
    t = _AT
    if places.shape[1] == 2:
        shapes, slopes = np.stack([1 - t, t]), np.stack([-np.ones(3), np.ones(3)])
    else:
        shapes = np.stack([(1 - t) * (1 - 2 * t), t * (2 * t - 1), 4 * t * (1 - t)])
        slopes = np.stack([4 * t - 3, 4 * t - 1, 4 - 8 * t])
    length = np.linalg.norm(np.einsum("aq,kax->kqx", slopes, places), axis=2)
    return np.einsum("q,kq,aq,bq->kab", _WEIGHT, length, shapes, shapes)
