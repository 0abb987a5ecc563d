"""What is read off a sheet in equilibrium: stretches and stresses at the nodes, wrinkles, where things are largest."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from hyperfab.arrays import Array, Ints
from hyperfab.membrane.contact import Frictionless
from hyperfab.membrane.equilibrium import Press, State
from hyperfab.membrane.mesh import shape_functions
from hyperfab.membrane.punch import Facets
from hyperfab.membrane.recovery import recovered_strain
from hyperfab.membrane.sheet import Sheet
from hyperfab.membrane.tension_field import TAUT, Principal


@dataclass(frozen=True)
class Fields:
    """Smooth fields at the nodes (n,): principal stretches (n, 2), Cauchy stresses (n, 2) [MPa], thickness [mm].

    ``nominal`` (n,) is the larger principal nominal stress [MPa].
    """

    stretch: Array
    cauchy: Array
    thickness: Array
    nominal: Array


def fields(sheet: Sheet, places: Array) -> Fields:
    """Return smooth fields at the nodes; close to the limit of a law, those of the most stressed point nearby."""
    found = sheet.law.principal(recovered_strain(sheet.mesh, places))
    beyond = np.flatnonzero(~np.isfinite(found.cauchy).all(axis=1))
    if len(beyond):
        found = _worst_around(sheet, places, beyond, found)
    return Fields(found.stretch, found.cauchy, sheet.thickness * found.thickness, found.nominal)


def _worst_around(sheet: Sheet, places: Array, nodes: Ints, smooth: Principal) -> Principal:
    """Return ``smooth`` with the values of the quadrature point of the largest stress around each of some nodes.

    Smoothing may carry a strain over the limit of a law that none of the points at which the sheet is in equilibrium
    has reached.
    """
    points = sheet.principal(places)
    size = len(points.stretch) // len(sheet.mesh.elements)
    worst = []
    for node in nodes:
        near = np.flatnonzero((sheet.mesh.elements == node).any(axis=1))
        mine = (near[:, None] * size + np.arange(size)).ravel()
        worst.append(mine[np.argmax(points.cauchy[mine].max(axis=1))])
    columns = {}
    for name in ("stretch", "cauchy", "thickness", "nominal"):
        columns[name] = np.array(getattr(smooth, name))
        columns[name][nodes] = getattr(points, name)[worst]
    return replace(smooth, **columns)


def mounted_energy(press: Press) -> float:
    """Return the energy [N mm] of the mounted sheet before the punch touches it; a clamp that gives has given."""
    sheet = press.sheet
    if sheet.clamp is None or sheet.prestretch <= 1.0:
        return sheet.energy(sheet.flat)
    below = -sheet.reach
    nothing = np.zeros(len(sheet.flat), bool)
    return replace(press, tangential=Frictionless()).equilibrium(below, sheet.flat, nothing).energy


#: Points of an element, in area coordinates, at which it may cut into an edge of the punch.
_BETWEEN = np.array(
    [[2, 2, 0], [3, 1, 0], [1, 3, 0], [0, 2, 2], [0, 3, 1], [0, 1, 3], [2, 0, 2], [1, 0, 3], [3, 0, 1], [4 / 3] * 3]
) / 4.0  # fmt: skip


def cut(press: Press, state: State) -> float:
    """Return how deep [mm] elements cut into a punch beside its sharp edges, between their nodes; 0 without any."""
    if not isinstance(press.punch, Facets) or not press.punch.sharp.any():
        return 0.0
    mesh = press.sheet.mesh
    between = np.einsum("qa,mai->mqi", shape_functions(mesh.order, _BETWEEN), state.places[mesh.elements])
    near = press.punch.near(between.reshape(-1, 3), state.depth)
    assert near.facet is not None
    return float(np.maximum(-near.gap[press.punch.sharp[near.facet]], 0.0).max(initial=0.0))


def wrinkled_fraction(sheet: Sheet, places: Array) -> float:
    """Return the part of the undeformed area that is wrinkled or slack."""
    weights = sheet.mesh.weights.ravel()
    loose = sheet.response(places).state != TAUT
    return float(weights[loose].sum() / weights.sum()) if loose.any() else 0.0


def difference(new: State, old: State, smooth: bool) -> float:
    """Return by which share the force of two meshes differs: on a ``smooth`` punch at least by that of the energy.

    Forces of two meshes may be alike by chance; hardly ever is the energy then, whose slope by the depth they are.
    """
    force = abs(new.force - old.force) / max(abs(new.force), 1e-300)
    energy = abs(new.energy - old.energy) / max(abs(new.energy), 1e-300)
    return max(force, energy) if smooth else force
