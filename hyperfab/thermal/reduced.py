"""A heated mold in a few unknowns: the finite elements on a rational Krylov basis, many settings at a time.

The basis holds what the mold answers to each heater, film and joint at a few time scales (Grimme (1997), Krylov
projection methods for model reduction), and a uniform temperature for each part. Film coefficients, conductivities,
capacities, powers, joints and the effects below stay free: they are numbers in front of small matrices.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from hyperfab.arrays import Array
from hyperfab.thermal.contact import Contact
from hyperfab.thermal.convection import Convection
from hyperfab.thermal.facet_operator import FacetOperator
from hyperfab.thermal.grading import graded
from hyperfab.thermal.heater import Heater
from hyperfab.thermal.lumping import lumped
from hyperfab.thermal.medium import Medium, ThermalMaterial
from hyperfab.thermal.model import HeatModel
from hyperfab.thermal.radiation import Radiation
from hyperfab.thermal.reduced_steps import Faces, Numbers, Parts, march
from hyperfab.thermal.settings import POINTS, Film, Patch, Settings, patch
from hyperfab.thermal.step import GAMMA
from hyperfab.thermal.tables import Table

#: Directions whose share of the capacity norm is smaller add nothing.
_DROP = 1e-7
#: Conductance of a bad joint [W/m^2/K].
_LOOSE = 500.0
#: Time scales of the basis, as shares of the experiment: one over these.
SCALES = (300.0, 30.0, 3.0)
#: Film coefficient that holds a face at a temperature [W/m^2/K].
HOLDS = 1e6


@dataclass
class ReducedMold:
    """Small matrices of a mold on a basis of r vectors, and its probes (p, r).

    ``mass``, ``stiffness`` and ``means`` are of each part, ``materials`` says which material a part is of;
    ``changes`` (2, parts, k, 2) are temperatures and the factors of specific heat and of conductivity there.
    """

    mass: Array
    stiffness: Array
    means: Array
    materials: NDArray[np.int64]
    changes: Array
    films: Sequence[Film]
    radiators: Sequence[Film]
    held: Sequence[Film]
    bench: Patch
    surroundings: Table
    heaters: Sequence[tuple[Array, Table]]
    joints: Sequence[tuple[Array, Table]]
    opened: Sequence[Patch]
    probes: Array
    parts: Array
    mean: Array
    start: Array
    warmer: Array
    reference_degC: float
    corners: Sequence[float] = field(default_factory=tuple)
    conductances: Sequence[float] = ()

    def run(self, times: Array, settings: Settings, steps: int = 100) -> Array:
        """Return the probes' temperatures (b, times, p) [degC] at ``times`` [s], the first the start.

        Alexander's SDIRK2 on about ``steps`` steps that meet every corner of the powers, and short ones where a power
        begins or jumps; between their ends the curve is the parabola through both values with the slope at the end.
        """
        grid = self.grid(float(times[0]), float(times[-1]), steps)
        stages = np.stack([grid[:-1] + GAMMA * np.diff(grid), grid[1:]], axis=1)
        under = Film(self.bench.rows, self.bench.weights, Table.constant(0.0), self.surroundings)
        faces = [*self.films, *self.radiators, *self.held, under]
        holds = np.array([*(False for _ in (*self.films, *self.radiators)), *(True for _ in self.held), False])
        rows = np.ascontiguousarray(np.concatenate([face.rows for face in faces]))
        weights = np.concatenate([face.weights for face in faces])
        owner = np.repeat(np.arange(len(faces)), [len(face.weights) for face in faces])
        air = np.stack([face.ambient(stages) for face in faces], axis=2)
        knots = np.concatenate([face.film.x for face in faces])
        values = np.concatenate([face.film.y for face in faces])
        first = np.concatenate([[0], np.cumsum([len(face.film.x) for face in faces])])
        sources = np.array([shape for shape, _ in self.heaters]).reshape(-1, len(self.start))
        jumps = np.array([jump for jump, _ in self.joints]).reshape(-1, *self.mass[0].shape)
        powers, closed = (
            np.array([table(stages) for _, table in each]).reshape(-1, *stages.shape).transpose(1, 2, 0).copy()
            for each in (self.heaters, self.joints)
        )
        emits = np.array([face.emissivity for face in faces])
        found = np.empty((len(settings.film), len(times), len(self.probes)))
        count, below = len(self.films), owner == len(faces) - 1
        for i in range(len(found)):
            joined = np.zeros_like(self.mass[0])
            slopes = settings.of(i, "joint_from_middle", "joint_along_x", "joint_along_y")
            for resistance, opened in zip(settings.opened[i], self.opened, strict=True):
                joined = joined + opened.jump(float(resistance), slopes)
            emissivity, bench = settings.of(i, "emissivity", "bench")
            extra = np.where(holds, HOLDS, 0.0)
            extra[-1] = bench
            grey = emits.copy()
            grey[:count] += emissivity
            areas = weights.copy()
            areas[below] *= self.bench.uneven(settings.of(i, "bench_from_middle", "bench_along_x", "bench_along_y"))
            numbers = Numbers(*map(float, settings.of(i, *Numbers._fields)))
            drift = settings.air_K(i, stages)
            parts = Parts(
                settings.capacity[i, self.materials][:, None, None] * self.mass,
                settings.conductivity[i, self.materials][:, None, None] * self.stiffness,
                self.means,
                self.changes,
                joined,
                settings.joint[i],
                jumps,
                closed,
                self.mean,
            )
            around = Faces(
                rows,
                areas,
                owner,
                np.concatenate([settings.film[i], np.zeros(len(faces) - count)]),
                extra,
                grey,
                air + np.where(holds, 0.0, drift[:, :, None]),
                knots,
                values,
                first,
            )
            states, rates = march(
                grid,
                self.start + settings.start_K[i] @ self.warmer,
                parts,
                around,
                sources,
                powers * settings.power[i],
                numbers._replace(reference=self.reference_degC),
            )
            found[i] = self._read(times, grid, states, rates)
        return found

    @property
    def kinds(self) -> int:
        """How many materials there are."""
        return int(np.max(self.materials)) + 1

    def grid(self, begin: float, end: float, steps: int = 100) -> Array:
        """Return the times [s] that a run steps at."""
        faces = [*self.films, *self.radiators, *self.held]
        signals = [table for _, table in (*self.heaters, *self.joints)] + [face.ambient for face in faces]
        return graded(begin, end, self.corners, signals, steps)

    def _read(self, times: Array, grid: Array, states: Array, slopes: Array) -> Array:
        step = np.clip(np.searchsorted(grid, times, side="left") - 1, 0, len(grid) - 2)
        length = (grid[step + 1] - grid[step])[:, None]
        back = ((times - grid[step + 1]) / length[:, 0])[:, None]
        end, slope = states[step + 1], slopes[step + 1] * length
        bend = states[step] - end + slope
        return np.asarray((end + slope * back + bend * back**2) @ self.probes.T)


def reduce(
    model: HeatModel,
    probes: Array,
    start: Array,
    duration: float,
    bench: FacetOperator | None,
    opened: Sequence[Contact] = (),
    corners: Sequence[float] = (),
    groups: Sequence[Sequence[int]] = (),
    held: Sequence[Convection] = (),
    scales: Sequence[float] = SCALES,
) -> ReducedMold:
    """Return the reduced mold of a model whose joints that conduct perfectly are the contacts ``opened`` of it.

    ``probes`` (p, n), ``start`` (n,) [degC], ``duration`` [s] of the experiment, ``bench`` the faces without a film;
    ``groups`` of parts begin at temperatures of their own, all other parts at another;
    ``held`` are the conditions that stand for faces at a given temperature; one over ``scales`` are the
    time scales of the basis, as shares of the duration.
    """
    films = [c for c in model.conditions if isinstance(c, Convection) and c not in held]
    radiators = [c for c in model.conditions if isinstance(c, Radiation)]
    joints = [c for c in model.conditions if isinstance(c, Contact) and c not in opened]
    basis = _basis(model, start, duration, [*films, *radiators, *held], [*joints, *opened], bench, scales)
    mass, stiffness, means = _by_part(model, basis)
    names = list(dict.fromkeys(material.name for material in model.materials))

    def apart(joint: Contact) -> Array:
        return joint.near.at_points_of(basis) - joint.far.at_points_of(basis)

    def jump(joint: Contact) -> Array:
        rows = apart(joint)
        return np.asarray(rows.T @ (joint.near.weights.ravel()[:, None] * rows))

    def points(facets: FacetOperator) -> Array:
        return facets.at_points_of(model.mesh.points)

    weight = model.pattern.matrix(model.medium.capacity(start)) @ np.ones(model.size)
    coefficients: Array = np.asarray(np.linalg.lstsq(basis, start, rcond=None)[0], dtype=np.float64)
    began = _groups(model, groups)
    warmer: Array = np.asarray(np.linalg.lstsq(basis, began.T, rcond=None)[0].T, dtype=np.float64)
    empty = Patch(np.zeros((0, basis.shape[1])), np.zeros(0), np.zeros((0, 3)))
    cooled: list[Convection | Radiation] = [*films, *radiators]
    ambient = cooled[0].ambient if cooled else Table.constant(float(np.mean(start)))
    return ReducedMold(
        mass=mass,
        stiffness=stiffness,
        means=means,
        materials=np.array([names.index(material.name) for material in model.materials]),
        changes=_changes(model),
        films=[_face(c.facets, basis, c.film, c.ambient) for c in films],
        radiators=[_face(c.facets, basis, Table.constant(0.0), c.ambient, c.emissivity) for c in radiators],
        held=[_face(c.facets, basis, Table.constant(0.0), c.ambient) for c in held],
        bench=empty if bench is None else patch(bench.at_points_of(basis), bench.weights.ravel(), points(bench)),
        surroundings=ambient,
        heaters=[(basis.T @ c.shape, c.power) for c in model.conditions if isinstance(c, Heater)],
        joints=[(jump(c), c.closed) for c in joints],
        opened=[patch(apart(c), c.near.weights.ravel(), points(c.near)) for c in opened],
        probes=probes @ basis,
        parts=_part_means(model, basis),
        mean=weight @ basis / weight.sum(),
        start=coefficients,
        warmer=warmer,
        reference_degC=float(np.mean(start)),
        corners=tuple(corners),
        conductances=tuple(c.conductance for c in joints),
    )


def _groups(model: HeatModel, groups: Sequence[Sequence[int]]) -> Array:
    """Return which nodes belong to the parts of no group, and to those of each (1 + groups, n); a node counts once."""
    found = np.zeros((1 + len(groups), model.size))
    found[0] = 1.0
    for number, parts in enumerate(groups, start=1):
        nodes = np.unique(model.mesh.elements[np.isin(model.mesh.parts, parts)])
        found[:, nodes] = 0.0
        found[number, nodes] = 1.0
    return found


def _part_means(model: HeatModel, basis: Array) -> Array:
    rows = []
    for part in range(len(model.materials)):
        nodes = np.unique(model.mesh.elements[model.mesh.parts == part])
        rows.append(basis[nodes].mean(axis=0))
    return np.stack(rows)


def _face(facets: FacetOperator, basis: Array, film: Table, ambient: Table, emissivity: float = 0.0) -> Film:
    """Return a face by a few points: neighbours in temperature count as one, with their areas together."""
    rows = facets.at_points_of(basis)
    weights = facets.weights.ravel()
    if len(weights) > POINTS:
        rows, weights = lumped(rows, weights, POINTS)
    return Film(rows, weights, film, ambient, emissivity)


def _by_part(model: HeatModel, basis: Array) -> tuple[Array, Array, Array]:
    """Return capacity and conduction matrices of each part on the basis, and its mean of each basis vector."""
    mass, stiffness, means = [], [], []
    nothing, zero = Table.constant(0.0), np.zeros(model.size)
    for part in range(len(model.materials)):
        chosen = [
            ThermalMaterial(
                material.name,
                material.density,
                Table.constant(material.conductivity.at(50.0)) if number == part else nothing,
                Table.constant(material.specific_heat.at(50.0)) if number == part else nothing,
            )
            for number, material in enumerate(model.materials)
        ]
        medium = Medium(model.mesh, chosen, model.pattern, model.loose)
        capacity = model.pattern.matrix(medium.capacity(zero))
        mass.append(basis.T @ (capacity @ basis))
        stiffness.append(basis.T @ (model.pattern.matrix(medium.conduction(zero)) @ basis))
        weight = capacity @ np.ones(model.size)
        means.append(weight @ basis / weight.sum())
    return np.stack(mass), np.stack(stiffness), np.stack(means)


def _loosened(model: HeatModel) -> HeatModel:
    """Return the model with joints that conduct badly: the basis has to hold their jumps too."""
    loose = [
        Contact(c.name, c.near, c.far, min(c.conductance, _LOOSE), c.closed) if isinstance(c, Contact) else c
        for c in model.conditions
    ]
    return HeatModel(model.mesh, model.materials, loose, model.prescribed)


def _changes(model: HeatModel) -> Array:
    """Return the materials' tables as factors on what they are at 50 degC, one place where nothing changes."""
    tables = [[m.specific_heat for m in model.materials], [m.conductivity for m in model.materials]]
    if all(table.is_constant for kind in tables for table in kind):
        return np.ones((2, len(model.materials), 1, 2))
    at = np.unique(np.concatenate([table.x for kind in tables for table in kind]))
    return np.array([[np.column_stack([at, table(at) / table.at(50.0)]) for table in kind] for kind in tables])


def _basis(
    model: HeatModel,
    start: Array,
    duration: float,
    faces: Sequence[Convection | Radiation],
    joints: Sequence[Contact],
    bench: FacetOperator | None,
    scales: Sequence[float],
) -> Array:
    across = [c.shape for c in model.conditions if isinstance(c, Heater)]
    across += [joint.near.load(1.0) - joint.far.load(1.0) for joint in joints]
    loads = [*across, *(face.facets.load(1.0) for face in faces)]
    if bench is not None:
        loads.append(bench.load(1.0))
    parts = [
        (np.bincount(model.mesh.elements[model.mesh.parts == part].ravel(), minlength=model.size) > 0).astype(float)
        for part in range(len(model.materials))
    ]
    found = [np.ones(model.size), start, *parts]
    capacity = model.pattern.matrix(model.medium.capacity(start))
    loose = [(_loosened(model), across)] if joints else []
    for one, driven in [(model, loads), *loose]:
        for share in scales:
            scale = duration / share
            matrix = one.step_matrix(0.0, scale, start)
            found += [one.solve(matrix, scale * load, 1e-8) for load in driven]
    kept: list[Array] = []
    for vector in found:
        size = np.sqrt(float(vector @ (capacity @ vector)))
        if size == 0.0:
            continue
        rest = vector / size
        for _ in range(2):
            for other in kept:
                rest = rest - other * float(other @ (capacity @ rest))
        left = np.sqrt(max(float(rest @ (capacity @ rest)), 0.0))
        if left > _DROP:
            kept.append(rest / left)
    return np.stack(kept, axis=1)
