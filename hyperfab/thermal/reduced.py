"""A heated mold in a few unknowns: the finite elements on a rational Krylov basis, many settings at a time.

The basis holds what the mold answers to each heater, film and joint at a few time scales (Grimme (1997), Krylov
projection methods for model reduction), and a uniform temperature for each part. Film coefficients, conductivities,
capacities, powers, joints and the effects below stay free: they are numbers in front of small matrices.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from hyperfab.arrays import Array, Ints
from hyperfab.thermal.condition import Contact, Convection, Heater, Radiation
from hyperfab.thermal.course import Course
from hyperfab.thermal.facet_operator import FacetOperator
from hyperfab.thermal.grading import graded
from hyperfab.thermal.lumping import lumped
from hyperfab.thermal.model import HeatModel
from hyperfab.thermal.reduced_steps import Faces, Numbers, Parts, Trail, march
from hyperfab.thermal.run_basis import SOLVE, beside_uniform
from hyperfab.thermal.settings import Film, Patch, Settings, patch, points_for
from hyperfab.thermal.step import GAMMA
from hyperfab.thermal.tables import Table
from hyperfab.thermal.zones import by_zone, changes, on_basis, warmed

#: Directions that differ by less add nothing, of fields of a kelvin.
_DROP = 1e-7
#: Fields that differ from a uniform one by less, as a share, are uniform.
_UNIFORM = 1e-9
#: Conductance of a bad joint [W/m^2/K].
_LOOSE = 500.0
#: Time scales of the basis, as shares of the experiment: one over these.
SCALES = (300.0, 30.0, 3.0)
#: Film coefficient that holds a face at a temperature [W/m^2/K].
HOLDS = 1e6


@dataclass
class ReducedMold:
    """Small matrices of a mold on a ``basis`` (n, r), and its probes (p, r).

    ``mass``, ``stiffness`` and ``means`` are of each zone of a part, ``materials`` says which material it is of;
    ``changes`` (2, zones, k, 2) are temperatures and the factors of specific heat and of conductivity there.
    """

    mass: Array
    stiffness: Array
    means: Array
    materials: Ints
    changes: Array
    films: Sequence[Film]
    radiators: Sequence[Film]
    held: Sequence[Film]
    bench: Patch
    surroundings: Table
    heaters: Sequence[tuple[Array, Table]]
    joints: Sequence[tuple[Array, Table]]
    opened: Sequence[Patch]
    basis: Array
    probes: Array
    parts: Array
    mean: Array
    start: Array
    warmer: Array
    reference_degC: float
    corners: Sequence[float]
    conductances: Sequence[float]
    absent: int

    def plain(self, count: int = 1) -> Settings:
        """Return the settings of so many runs in which all is as the document says."""

        def each(values: Array) -> Array:
            return np.repeat(values[None, :], count, axis=0)

        present = np.arange(len(self.films)) < len(self.films) - self.absent
        return Settings(
            film=each(present.astype(float)),
            conductivity=each(np.ones(self.kinds)),
            capacity=each(np.ones(self.kinds)),
            power=each(np.ones(len(self.heaters))),
            joint=each(np.array(self.conductances)),
            opened=each(np.zeros(len(self.opened))),
            start_K=each(np.zeros(len(self.warmer))),
            ambient_K=each(np.zeros(len(self.faces))),
        )

    def run(self, times: Array, settings: Settings, steps: int = 100, *, beside: bool = False) -> Array:
        """Return the probes' temperatures (b, times, p) [degC] at ``times`` [s], the first the start.

        On about ``steps`` steps that meet every corner of the powers, and short ones where a power begins or jumps.
        ``beside``: as in ``courses``.
        """
        grid = self.grid(float(times[0]), float(times[-1]), steps)
        return np.array([course.of(self.probes).at(times) for course in self.courses(grid, settings, beside=beside)])

    def courses(self, grid: Array, settings: Settings, *, beside: bool = False) -> Iterator[Course]:
        """Yield each run by Alexander's SDIRK2 on the steps of ``grid`` [s].

        ``beside``: all but the first are so near it that its factored matrices serve, to first order in what they are
        off by: what the run changes by with a constant is a difference of two such runs.
        """
        size = len(self.start)
        trail = Trail.room((len(grid) - 1) if beside and len(settings.film) > 1 else 0, size)
        stages = np.stack([grid[:-1] + GAMMA * np.diff(grid), grid[1:]], axis=1)
        faces = self.faces
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
        count, below = len(self.films), owner == len(faces) - 1
        for i in range(len(settings.film)):
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
            joint, leaps, tight = settings.joint[i], jumps, closed
            if np.any(settings.of(i, "joint_closes", "joint_tightens")):
                # As a joint of the document is that closes over time.
                share = np.ascontiguousarray(settings.closes(i, stages)[..., None])
                joint, leaps = np.append(joint, 1.0), np.concatenate([jumps, joined[None]])
                tight, joined = np.concatenate([closed, share], axis=2), np.zeros_like(joined)
            changing = settings.of(i, "capacity_per_K", "capacity_per_K2", "conductivity_per_K")
            mold, of = (self, self.materials) if np.any(changing) or self.changes.shape[2] > 1 else self._of_kinds
            parts = Parts(
                settings.capacity[i, of][:, None, None] * mold.mass,
                settings.conductivity[i, of][:, None, None] * mold.stiffness,
                mold.means,
                mold.changes,
                joined,
                joint,
                leaps,
                tight,
                self.mean,
            )
            around = Faces(
                rows,
                areas,
                owner,
                np.concatenate([settings.film[i], np.zeros(len(faces) - count)]),
                extra,
                grey,
                air + np.where(holds, 0.0, drift),
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
                trail,
            )
            trail = trail._replace(known=beside)
            yield Course(grid, states, rates)

    @property
    def faces(self) -> list[Film]:
        """All faces: those with a film, those that radiate, those that are held, and the one on the bench."""
        under = Film(self.bench.rows, self.bench.weights, Table.constant(0.0), self.surroundings)
        return [*self.films, *self.radiators, *self.held, under]

    def stored(self, coordinates: Array) -> Array:
        """Return the heat in each zone (zones,) [J], counted from 0 degC, of materials that do not change."""
        return np.asarray(self.mass[:, 0] @ coordinates / self.basis[0, 0])  # the first of the basis is uniform

    @cached_property
    def _of_kinds(self) -> tuple[ReducedMold, Ints]:
        """The mold with all zones of a material as one, and which each is of: where none changes they go together."""
        of = np.arange(self.kinds)
        mass, stiffness = (
            np.stack([matrix[self.materials == kind].sum(axis=0) for kind in of])
            for matrix in (self.mass, self.stiffness)
        )
        # Whole arrays, as the build has compiled the steps for: of a slice they would be compiled anew.
        means, changes = self.means[: len(of)], self.changes[:, : len(of)].copy()
        return replace(self, mass=mass, stiffness=stiffness, means=means, changes=changes), of

    @property
    def kinds(self) -> int:
        """How many materials there are."""
        return int(np.max(self.materials)) + 1

    def grid(self, begin: float, end: float, steps: int = 100) -> Array:
        """Return the times [s] that a run steps at."""
        key = begin, end, steps
        if key not in self._grids:
            signals = [table for _, table in (*self.heaters, *self.joints)] + [face.ambient for face in self.faces[:-1]]
            self._grids[key] = graded(begin, end, self.corners, signals, steps)
        return self._grids[key]

    @cached_property
    def _grids(self) -> dict[tuple[float, float, int], Array]:
        """The times of runs that were asked for: a fit asks for the same a thousand times."""
        return {}


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
    absent: Sequence[Convection] = (),
    states: Sequence[Array] = (),
    conducting: Sequence[float] = (1.0,),
    zones: int = 1,
) -> ReducedMold:
    """Return the reduced mold of a model whose joints that conduct perfectly are the contacts ``opened`` of it.

    ``probes`` (p, n), ``start`` (n,) [degC], ``duration`` [s] of the experiment, ``bench`` the faces without a film;
    ``groups`` of parts begin at temperatures of their own, all other parts at another;
    ``held`` are the conditions that stand for faces at a given temperature; one over ``scales`` are the
    time scales of the basis, as shares of the duration. Films that are ``absent`` but where settings scale them come
    after the others; ``states`` (n,) are temperatures that the basis is to hold,
    and the answers to what leaves and what flows at the last of them. ``conducting`` are factors on all conductivities
    that the basis is to answer at. Materials that change go by the mean of each of as many ``zones`` of a part.
    """
    films = [c for c in model.conditions if isinstance(c, Convection) and c not in held]
    radiators = [c for c in model.conditions if isinstance(c, Radiation)]
    joints = [c for c in model.conditions if isinstance(c, Contact) and c not in opened]
    within, began = _indicators(model), _groups(model, groups)
    names = list(dict.fromkeys(material.name for material in model.materials))
    materials = np.repeat([names.index(material.name) for material in model.materials], zones)
    heaters = [c for c in model.conditions if isinstance(c, Heater)]
    powers = [c.shape * float(np.max(np.abs(c.power.y))) for c in heaters]
    warm = warmed(model, powers if zones > 1 else [], duration / scales[-1])
    media = by_zone(model, zones, warm)
    across = [c.shape for c in heaters]
    across += [joint.near.load(1.0) - joint.far.load(1.0) for joint in (*joints, *opened)]
    cooled: list[Convection | Radiation] = [*films, *radiators]
    loads = [*across, *(face.facets.load(1.0) for face in (*cooled, *held))]
    if bench is not None:
        loads.append(bench.load(1.0))
    for last in states[-1:]:
        loads += [one.flow(duration, last) for one in (*cooled, *absent)]
        loads += [one.flow(duration, last) for one in joints]
        flows = np.array([one.conducting @ (last - last.mean()) for one in media])
        loads += [flows[materials == kind].sum(axis=0) for kind in range(len(names))]
    vectors = [start, *states, *within, *began]
    across = across if joints or opened else []
    basis = _basis(model, vectors, loads, across, [duration / share for share in scales], conducting)
    mass, stiffness, means = on_basis(media, basis)

    def apart(joint: Contact) -> Array:
        return joint.near.at_points_of(basis) - joint.far.at_points_of(basis)

    def jump(joint: Contact) -> Array:
        rows = apart(joint)
        return np.asarray(rows.T @ (joint.near.weights.ravel()[:, None] * rows))

    def points(facets: FacetOperator) -> Array:
        return facets.at_points_of(model.mesh.points)

    weights = model.pattern.matrix(model.medium.capacity(start)) @ basis  # of vectors that are orthonormal with it
    whole = weights.sum(axis=0)
    empty = Patch(np.zeros((0, basis.shape[1])), np.zeros(0), np.zeros((0, 3)))
    ambient = cooled[0].ambient if cooled else Table.constant(float(np.mean(start)))
    return ReducedMold(
        mass=mass,
        stiffness=stiffness,
        means=means,
        materials=materials,
        changes=changes(model, zones),
        films=[_face(c.facets, basis, c.film, c.ambient) for c in (*films, *absent)],
        radiators=[_face(c.facets, basis, Table.constant(0.0), c.ambient, c.emissivity) for c in radiators],
        held=[_face(c.facets, basis, Table.constant(0.0), c.ambient) for c in held],
        bench=empty if bench is None else patch(bench.at_points_of(basis), bench.weights.ravel(), points(bench)),
        surroundings=ambient,
        heaters=[(basis.T @ c.shape, c.power) for c in heaters],
        joints=[(jump(c), c.closed) for c in joints],
        opened=[patch(apart(c), c.near.weights.ravel(), points(c.near), whole=True) for c in opened],
        basis=basis,
        probes=probes @ basis,
        parts=np.stack([one @ basis / one.sum() for one in within]),
        mean=whole / (whole @ whole),
        start=start @ weights,
        warmer=began @ weights,
        reference_degC=float(np.mean(start)),
        corners=tuple(corners),
        conductances=tuple(c.conductance for c in joints),
        absent=len(absent),
    )


def _groups(model: HeatModel, groups: Sequence[Sequence[int]]) -> Array:
    """Return by how much the start of each node follows that of the parts of no group, and of each (1 + groups, n)."""
    parts = np.arange(len(model.materials))
    own = [model.medium.joined(np.tile(np.isin(parts, group) * 1.0, (model.size, 1))) for group in groups]
    return np.array([1.0 - np.sum(own, axis=0, initial=0.0) + np.zeros(model.size), *own])


def _indicators(model: HeatModel) -> list[Array]:
    """Return which nodes belong to each part (n,)."""
    mesh = model.mesh
    nodes = (mesh.elements[mesh.parts == part].ravel() for part in range(len(model.materials)))
    return [(np.bincount(one, minlength=model.size) > 0).astype(float) for one in nodes]


def _face(facets: FacetOperator, basis: Array, film: Table, ambient: Table, emissivity: float = 0.0) -> Film:
    """Return a face by a few points: neighbours in temperature count as one, with their areas together."""
    rows = facets.at_points_of(basis)
    weights = facets.weights.ravel()
    count = points_for(rows)
    if len(weights) > count:
        rows, weights = lumped(rows, weights, count)
    return Film(rows, weights, film, ambient, emissivity)


def _conducting(model: HeatModel, factor: float) -> HeatModel:
    """Return the model with all conductivities times a factor."""
    if factor == 1.0:
        return model
    materials = [
        replace(one, conductivity=Table(one.conductivity.x, factor * one.conductivity.y)) for one in model.materials
    ]
    return replace(model, materials=materials)


def _loosened(model: HeatModel) -> HeatModel:
    """Return the model with joints that conduct badly: the basis has to hold their jumps too."""
    loose = [
        Contact(c.name, c.near, c.far, min(c.conductance, _LOOSE), c.closed) if isinstance(c, Contact) else c
        for c in model.conditions
    ]
    return HeatModel(model.mesh, model.materials, loose, model.prescribed)


def _basis(
    model: HeatModel,
    vectors: Sequence[Array],
    loads: Sequence[Array],
    across: Sequence[Array],
    scales: Sequence[float],
    conducting: Sequence[float],
) -> Array:
    """Return what spans the vectors and the answers to ``loads`` [W] within the time scales [s], orthonormal in the
    heat capacity, the first uniform; to those ``across`` joints too where these conduct badly; and all of these where
    the parts are ``conducting`` as many times as well.
    """
    found, start = list(vectors), vectors[0]
    capacity = model.pattern.matrix(model.medium.capacity(start))
    asked = []
    for factor in conducting:
        own = _conducting(model, factor)
        asked += [(own, loads), *([(_loosened(own), across)] if across else [])]
    for one, driven in asked:
        for scale in scales:
            matrix = one.step_matrix(0.0, scale, start)
            found += [one.solve(matrix, load, SOLVE) for load in driven]
    uniform = np.full(model.size, 1.0 / np.sqrt(float(capacity.sum())))
    held = capacity @ uniform
    columns = []
    for vector in found:
        rest = vector - float(held @ vector) * uniform
        size = model.capacity_norm(rest)
        if size > _UNIFORM * model.capacity_norm(vector):
            columns.append(rest / size)
    return np.column_stack([uniform, beside_uniform(columns, capacity, _DROP, model.size)])
