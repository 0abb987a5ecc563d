"""The conducting, heat-storing volume: its stored heat, its conduction, and their derivatives by temperature.

What does not depend on temperature is assembled once. Parts whose constants do are integrated anew, on the metric
of their elements that was kept, into the same pattern.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from hyperfab.arrays import Array, Ints
from hyperfab.numerics.product import product
from hyperfab.thermal import elements
from hyperfab.thermal.assembly import Pattern
from hyperfab.thermal.mesh import HeatMesh
from hyperfab.thermal.tables import Table


@dataclass(frozen=True)
class ThermalMaterial:
    """``density`` [kg/m^3], ``conductivity`` [W/m/K] and ``specific_heat`` [J/kg/K] against temperature [degC]."""

    name: str
    density: float
    conductivity: Table
    specific_heat: Table


#: Elements integrated at a time: keeps the temporary arrays below some 100 MB.
CHUNK = 8192


class Medium:
    """The parts of ``mesh`` with one material each (``materials[i]`` is part i's); ``pattern`` holds all matrices.

    ``loose`` (k,) [J/K] is the heat capacity of each loose node of the mesh.
    """

    def __init__(self, mesh: HeatMesh, materials: Sequence[ThermalMaterial], pattern: Pattern, loose: Array) -> None:
        self.mesh = mesh
        self.materials = tuple(materials)
        self.pattern = pattern
        varying_k = np.array([not m.conductivity.is_constant for m in materials])[mesh.parts]
        varying_c = np.array([not m.specific_heat.is_constant for m in materials])[mesh.parts]
        self._conducting = np.zeros(pattern.entries)
        self._storing = np.zeros(pattern.entries)
        conductivity = np.array([m.conductivity.y[0] for m in materials])[mesh.parts]
        capacity = np.array([m.density * m.specific_heat.y[0] for m in materials])[mesh.parts]
        conductivity[varying_k] = 0.0
        capacity[varying_c] = 0.0
        self._volume = np.zeros(len(mesh.elements))
        for chunk in self._chunks(np.arange(len(mesh.elements))):
            nodes = mesh.elements[chunk]
            found = elements.metric(mesh.points[nodes])
            self._volume[chunk] = found.volume.sum(axis=1)
            k = elements.stiffness(found, conductivity[chunk][:, None])
            pattern.scatter(nodes, k, self._conducting)
            pattern.scatter(nodes, elements.mass(found, capacity[chunk][:, None]), self._storing)
        pattern.scatter(mesh.solid + np.arange(len(loose))[:, None], loose[:, None, None], self._storing)
        self._metrics: dict[tuple[int, int], elements.Metric] = {}
        self._k_last: tuple[Array, Array] | None = None
        self._k_elements = np.flatnonzero(varying_k)
        self._c_elements = np.flatnonzero(varying_c)

    @property
    def linear(self) -> bool:
        """Whether no material depends on temperature."""
        return not self.conduction_varies and len(self._c_elements) == 0

    @property
    def conduction_varies(self) -> bool:
        """Whether a part's conductivity depends on temperature."""
        return len(self._k_elements) > 0

    @property
    def masses(self) -> Array:
        """Mass of each part [kg]."""
        volume = np.bincount(self.mesh.parts, self._volume, len(self.materials))
        return volume * np.array([material.density for material in self.materials])

    def volume_load(self, part: int) -> Array:
        """Return nodal loads (n,) of a unit heat source spread evenly over a part; they sum to 1."""
        chosen = np.flatnonzero(self.mesh.parts == part)
        total = np.zeros(len(self.mesh.points))
        for chunk in self._chunks(chosen):
            nodes = self.mesh.elements[chunk]
            found = elements.metric(self.mesh.points[nodes])
            unit = elements.load(found, np.ones_like(found.volume))
            total += np.bincount(nodes.ravel(), unit.ravel(), len(total))
        return total / total.sum()

    def joined(self, by_part: Array) -> Array:
        """Return one nodal field (n,) of temperatures by part (n, parts) [degC].

        Nodes that parts share lie between these, such that the body holds the heat of its parts: with either's
        temperature it would hold more or less by a part of a layer of elements.
        """
        mesh = self.mesh
        belongs = np.zeros(by_part.shape, dtype=bool)
        capacity = np.empty(by_part.shape)
        for part, material in enumerate(self.materials):
            mine = np.unique(mesh.elements[mesh.parts == part])
            belongs[mine, part] = True
            specific_heat = material.specific_heat.at(float(by_part[mine, part].mean()))
            capacity[:, part] = self.volume_load(part)[: len(by_part)] * self.masses[part] * specific_heat
        found = np.empty(len(by_part))
        for together in np.unique(belongs, axis=0):
            nodes = np.flatnonzero((belongs == together).all(axis=1))
            weights = np.maximum(capacity[nodes].sum(axis=0), 0.0) * together
            if not weights.any():  # along an edge: shape functions of corners integrate to less than nothing
                weights += together
            # Where a part is not, it may have no temperature.
            theirs = np.where(together, by_part[nodes], 0.0)
            found[nodes] = theirs @ (weights / weights.sum())
        return found

    def conduction(self, temperature: Array) -> Array:
        """Return the data of the conduction matrix [W/K] at nodal temperatures; not to be changed."""
        if not self.conduction_varies:
            return self._conducting
        if self._k_last is None or not np.array_equal(self._k_last[0], temperature):
            data = self._conducting.copy()
            for part, nodes, found, at in self._points(self._k_elements, temperature):
                block = elements.stiffness(found, self.materials[part].conductivity(at))
                self.pattern.scatter(nodes, block, data)
            self._k_last = (temperature.copy(), data)
        return self._k_last[1]

    def capacity(self, temperature: Array) -> Array:
        """Return the data of the capacity matrix [J/K], d(stored heat)/dT, at nodal temperatures."""
        if len(self._c_elements) == 0:
            return self._storing
        data = self._storing.copy()
        for part, nodes, found, at in self._points(self._c_elements, temperature):
            material = self.materials[part]
            block = elements.mass(found, material.density * material.specific_heat(at))
            self.pattern.scatter(nodes, block, data)
        return data

    def stored(self, temperature: Array) -> Array:
        """Return the nodal heat content (n,) [J], counted from 0 degC; its sum is the heat in the body."""
        heat = product(self.pattern.matrix(self._storing), temperature)
        for part, nodes, found, at in self._points(self._c_elements, temperature):
            material = self.materials[part]
            density = material.density * material.specific_heat.integral(at)
            heat += np.bincount(nodes.ravel(), elements.load(found, density).ravel(), len(heat))
        return heat

    def gradient(self, temperature: Array) -> Array:
        """Return the temperature gradient at the middle of each element (m, 3) [K/m]."""
        _, gradients = elements.TETRAHEDRON.tabulate(np.full((1, 3), 0.25))
        result = np.empty((len(self.mesh.elements), 3))
        for chunk in self._chunks(np.arange(len(self.mesh.elements))):
            nodes = self.mesh.elements[chunk]
            jacobian = np.einsum("mid,ik->mdk", self.mesh.points[nodes], gradients[0])
            reference = np.einsum("mi,ik->mk", temperature[nodes], gradients[0])
            result[chunk] = np.einsum("mk,mkd->md", reference, np.linalg.inv(jacobian))
        return result

    def flux(self, temperature: Array) -> Array:
        """Return the heat flux vector at the middle of each element (m, 3) [W/m^2]."""
        values, _ = elements.TETRAHEDRON.tabulate(np.full((1, 3), 0.25))
        at = temperature[self.mesh.elements] @ values[0]
        k = np.empty(len(at))
        for part, material in enumerate(self.materials):
            mine = self.mesh.parts == part
            k[mine] = material.conductivity(at[mine])
        return -k[:, None] * self.gradient(temperature)

    def _points(self, chosen: Ints, temperature: Array) -> Iterator[tuple[int, Ints, elements.Metric, Array]]:
        """Yield part, nodes, metric and temperatures at quadrature points, some elements at a time.

        The metrics are kept: they are the larger part of the work.
        """
        values, _ = elements.TETRAHEDRON.tables
        for part in np.unique(self.mesh.parts[chosen]).tolist():
            for chunk in self._chunks(chosen[self.mesh.parts[chosen] == part]):
                nodes = self.mesh.elements[chunk]
                key = (int(chunk[0]), len(chunk))
                if key not in self._metrics:
                    self._metrics[key] = elements.metric(self.mesh.points[nodes])
                yield part, nodes, self._metrics[key], temperature[nodes] @ values.T

    @staticmethod
    def _chunks(chosen: Ints) -> list[Ints]:
        return [chosen[start : start + CHUNK] for start in range(0, len(chosen), CHUNK)]
