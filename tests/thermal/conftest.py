"""Block meshes without a mesher, and models on them."""

from __future__ import annotations

import numpy as np
import pytest

from hyperfab.thermal.condition import Convection, Heater, Prescribed, Radiation
from hyperfab.thermal.faces import Faces
from hyperfab.thermal.facet_operator import FacetOperator
from hyperfab.thermal.geometry import Body, Box, Geometry
from hyperfab.thermal.medium import ThermalMaterial
from hyperfab.thermal.mesh import EDGES, HeatMesh, build_mesh
from hyperfab.thermal.model import HeatModel
from hyperfab.thermal.tables import Table


def block_mesh(size, cells, parts=None, shift=None) -> HeatMesh:
    """A box [m] cut into cells of six tetrahedra; ``parts`` gives the part of an element by its centre."""
    import skfem

    axes = [np.linspace(0.0, s, n + 1) for s, n in zip(size, cells, strict=True)]
    grid = skfem.MeshTet.init_tensor(*axes)
    vertices, tetrahedra = grid.p.T, grid.t.T.astype(np.int64)
    ends = np.sort(tetrahedra[:, EDGES].reshape(-1, 2), axis=1)
    edges, number = np.unique(ends, axis=0, return_inverse=True)
    points = np.concatenate([vertices, vertices[edges].mean(axis=1)])
    elements = np.concatenate([tetrahedra, len(vertices) + number.reshape(-1, 6)], axis=1)
    centre = vertices[tetrahedra].mean(axis=1)
    belongs = np.zeros(len(elements), dtype=np.int64) if parts is None else parts(centre)
    return build_mesh(points, elements, belongs)


class Block:
    """A box-shaped body with conditions on its faces, all SI and degC."""

    def __init__(self, size, cells, k=1.0, rho=1.0, cp=1.0):
        self.size = size
        self.mesh = block_mesh(size, cells)
        self.geometry = Geometry((Body("block", (Box((0.0, 0.0, 0.0), tuple(1e3 * s for s in size)),)),))
        self.faces = Faces(self.mesh, self.geometry)
        as_table = lambda v: v if isinstance(v, Table) else Table.constant(v)  # noqa: E731
        self.material = ThermalMaterial("block", rho, as_table(k), as_table(cp))
        self.conditions, self.prescribed = [], []

    def face(self, way) -> FacetOperator:
        return FacetOperator(self.mesh.points, self.mesh.facet_nodes(self.faces.named(f"block.{way}").mask))

    def flux(self, way, density):
        face = self.face(way)
        power = Table.constant(density * face.area)
        self.conditions.append(Heater(f"heater {way}", face.load(1.0) / face.area, power))
        return self

    def film(self, way, h, ambient=0.0):
        film = h if isinstance(h, Table) else Table.constant(h)
        self.conditions.append(Convection(f"film {way}", self.face(way), film, Table.constant(ambient)))
        return self

    def radiate(self, way, emissivity, ambient):
        self.conditions.append(Radiation(f"sky {way}", self.face(way), emissivity, Table.constant(ambient)))
        return self

    def hold(self, way, value):
        nodes = np.unique(self.face(way).nodes)
        table = value if isinstance(value, Table) else Table.constant(value)
        self.prescribed.append(Prescribed(f"held {way}", nodes, table))
        return self

    def model(self) -> HeatModel:
        return HeatModel(self.mesh, [self.material], self.conditions, self.prescribed)

    def node(self, *place) -> int:
        return int(np.argmin(np.linalg.norm(self.mesh.points - np.array(place), axis=1)))


@pytest.fixture
def block():
    return Block
