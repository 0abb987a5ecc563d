"""The sphere test: a sphere pushed into a clamped sheet, followed in depth and computed on meshes fitted to contact.

The whole path is followed on a rough mesh, which finds out how deep it goes. Each depth is then computed on a mesh
that is fine at the edge of contact, from the rough solution: without friction the equilibrium at a depth does not
hang on how it was reached.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from math import ceil, log

import numpy as np

from hyperfab.arrays import Array
from hyperfab.membrane.contact import Frictionless, Tangential
from hyperfab.membrane.contact_edge import ContactEdge, ContactFront, contact_edge
from hyperfab.membrane.equilibrium import NoEquilibriumError, Press, State
from hyperfab.membrane.measures import Fields, difference, fields
from hyperfab.membrane.mesh import SheetMesh, halved, interpolate, sheet_mesh
from hyperfab.membrane.meshing import SizeField, Triangles, graded, triangulate
from hyperfab.membrane.outline import Outline
from hyperfab.membrane.path import Followed, Path, Watch, cold_start, follow, next_footing, taut_at
from hyperfab.membrane.punch import Facets, Sphere
from hyperfab.membrane.sheet import Sheet
from hyperfab.membrane.tension_field import SheetLaw
from hyperfab.membrane.work import doubtful
from hyperfab.numerics.threads import side_by_side, threads

#: How fast elements grow with distance [mm/mm].
_GROWTH = 0.25
#: Edges on the sphere, relative to its radius; edges at the contact edge, relative to the mesh size.
_ON_SPHERE, _AT_EDGE = 1 / 8, 1 / 4
#: Around the tip or along the rim of a punch, where next to no area touches, edges are no shorter than this, relative
#: to the mesh size and to the length of the rim.
_FINEST, _FINEST_OF_SPAN = 1 / 80, 1 / 60
#: Part of the punch's width that the rough mesh takes for touched.
_TOUCHED = 0.8
#: Edges of the rough mesh away from the sphere, at least, relative to half the size of the sheet.
_ROUGH = 0.08
#: Edges at the pole of the sphere where there is friction, relative to the mesh size.
_AT_POLE = 1 / 12
#: From one level of refinement to the next: fineness at the edge of contact, and elsewhere.
_FINER_EDGE, _FINER = 1.6, 1.25
#: A change of the force from one mesh to the next overestimates the error left by at least this on P2 elements; on
#: P1, whose error falls by the square of _FINER away from the edge of contact, it underestimates it.
_CAUTION = {1: 0.25, 2: 3.0}
#: Level and growth of a mesh that is coarser everywhere, and not at the edge of contact alone, by which the first force
#: is judged too: two meshes that are alike around a small sphere err alike there.
_COARSER_LEVEL, _COARSER_GROWTH = -1.5, 0.5
_MOST_LEVELS = 8
#: Iterations allowed on facets: nodes slide over edges before they settle.
_ON_FACETS = 30
#: On facets refinement ends where it leaves more than this part of the estimated error.
_STALLED = 0.7
#: Meshes of nested starts differ by at most this in their size.
_FASTEST = 2.6
_MOST_UNKNOWNS = 200_000
#: The work of the punch is sought to this part of itself, with at most so many depths beyond those asked for.
_WORK_TOLERANCE, _MOST_MORE_DEPTHS = 3e-5, 12
#: The same on facets, whose edges leave a noise in the force.
_WORK_TOLERANCE_ON_FACETS, _MOST_MORE_DEPTHS_ON_FACETS = 1e-3, 4
#: So many of them are computed side by side.
_AT_ONCE = 2


@dataclass(frozen=True)
class SphereTest:
    """What is pressed: the sheet's ``outline``, ``law`` and ``thickness`` [mm], the sphere's ``radius`` [mm].

    ``prestretch``: the rim is held at this times its undeformed place; ``mesh_size`` [mm] away from the contact;
    ``order`` 1 or 2 of the elements; ``seed`` chooses among equally good meshes, ``jitter`` disturbs them;
    ``friction`` between sheet and sphere; ``facets`` are pressed in place of the sphere, whose ``radius`` then only
    says how fine the elements are; ``rim_slip`` [mm per N/mm]: how far the clamp gives, ``frame`` [mm/N]: how far the
    machine does that reads the depth, 0 not at all.
    """

    outline: Outline
    law: SheetLaw
    thickness: float
    radius: float
    prestretch: float = 1.0
    mesh_size: float = 8.0
    order: int = 2
    seed: int = 0
    jitter: float = 0.0
    friction: Tangential = field(default_factory=Frictionless)
    rim_slip: float = 0.0
    frame: float = 0.0
    facets: Facets | None = None


@dataclass(frozen=True)
class Solved:
    """An equilibrium with the press it belongs to, and the estimated relative error of its force."""

    press: Press
    state: State
    error: float | None = None

    @property
    def read(self) -> float:
        """The depth [mm] as the machine reads it, which yields with the force."""
        return self.state.depth + self.press.frame * self.state.force

    @cached_property
    def fields(self) -> Fields:
        """Smooth fields at the nodes."""
        return fields(self.press.sheet, self.state.places)


@dataclass
class Outcome:
    """A test's path, and its equilibria on fitted meshes in order of depth.

    ``trace``: depths and forces for the work of the punch, more than are in ``solved`` where the curve needs it;
    ``extrapolated``: the last force for load steps of length zero, where it hangs on them.
    """

    rough: Press
    path: Path
    solved: list[Solved] = field(default_factory=list)
    trace: list[tuple[float, float]] = field(default_factory=list)
    extrapolated: float | None = None


def press_on(test: SphereTest, mesh: SheetMesh) -> Press:
    """Return the sheet of a test on ``mesh`` and its sphere."""
    sheet = Sheet(mesh, test.law, test.thickness, test.prestretch, test.rim_slip)
    if test.facets is None:
        return Press(sheet, Sphere(test.radius), test.friction, frame=test.frame)
    return Press(sheet, test.facets, test.friction, max_iterations=_ON_FACETS, frame=test.frame)


def rough_path(test: SphereTest, depths: Sequence[float], watch: Watch = lambda state: None) -> tuple[Press, Path]:
    """Follow the test through ``depths`` [mm] on a mesh that is uniform where the sphere may touch."""
    coarse = max(test.mesh_size, _ROUGH * test.outline.reach)
    inner = min(coarse, test.radius * _ON_SPHERE)
    beyond_punch = _beyond(test, depths[-1])

    def size(points: Array) -> Array:
        beyond = beyond_punch(points)
        return np.asarray(np.minimum(coarse, inner + _GROWTH * beyond))

    press = press_on(test, _mesh(test, _triangles(test, size)))
    return press, follow(press, depths, watch)


def _beyond(test: SphereTest, depth: float) -> SizeField:
    """Return how far [mm] points (n, 2) lie outside of where the punch may touch: most of a circle or of a box."""
    if test.facets is None:
        span = _TOUCHED * test.radius
        return lambda points: np.maximum(np.hypot(points[:, 0], points[:, 1]) - span, 0.0)
    above = test.facets.above(depth)[:, :2]
    middle, half = 0.5 * (above.min(axis=0) + above.max(axis=0)), 0.5 * np.ptp(above, axis=0)
    return lambda points: np.linalg.norm(np.maximum(np.abs(points - middle) - _TOUCHED * half, 0.0), axis=1)


def fitted_mesh(test: SphereTest, edges: Sequence[ContactEdge | ContactFront]) -> SheetMesh:
    """Mesh the sheet finely along ``edges`` of contact."""
    return _mesh(test, _fitted_triangles(test, edges, 0.0))


def _fitted_triangles(test: SphereTest, edges: Sequence[ContactEdge | ContactFront], level: float) -> Triangles:
    coarse = test.mesh_size / _FINER**level
    growth = _GROWTH if level >= 0.0 else _COARSER_GROWTH
    on_sphere = min(coarse, test.radius * _ON_SPHERE / _FINER**level)
    sizes: list[SizeField] = []
    for edge in edges:
        points = edge.points()
        least = max(_FINEST * test.mesh_size, _FINEST_OF_SPAN * float(np.ptp(points, axis=0).max()))
        fine = min(test.mesh_size * _AT_EDGE, max(0.3 * edge.mean, least)) / _FINER_EDGE**level
        sizes.append(graded(points, fine, coarse, growth))

    # Friction points towards the pole from all sides: the stretch has a cusp there.
    pole = graded(np.zeros((1, 2)), _AT_POLE * coarse, coarse, growth)

    def size(points: Array) -> Array:
        wanted = pole(points) if test.friction.remembers else np.full(len(points), coarse)
        for edge, at_edge in zip(edges, sizes, strict=True):
            inner = on_sphere + growth * edge.beyond(points)
            wanted = np.minimum(wanted, np.minimum(at_edge(points), inner))
        return wanted

    return _triangles(test, size)


def solve_on(test: SphereTest, mesh: SheetMesh, near: Solved) -> Solved:
    """Return the equilibrium on ``mesh`` at the depth of ``near``, an equilibrium on another mesh.

    Raises NoEquilibriumError.
    """
    press = press_on(test, mesh)
    depth = near.state.depth
    places = interpolate(near.press.sheet.mesh, near.state.places, mesh.nodes)
    free = press.sheet.pattern.free
    places[~free] = press.sheet.flat[~free]
    edge = contact_edge(near.press, near.state)
    touching = edge.encloses(mesh.nodes) if edge else np.zeros(len(mesh.nodes), bool)
    try:
        state = press.nearby(depth, places, touching, near.state.residual)
    except NoEquilibriumError:
        state = cold_start(press, depth)
    press.sheet.pattern.release()
    return Solved(press, state)


def run(
    tests: Sequence[SphereTest],
    depths: Sequence[float],
    tolerance: float,
    watch: Watch = lambda state: None,
    followed: Followed = lambda paths: None,
) -> list[Outcome]:
    """Press several sheets that differ in their law alone, on the same meshes, to compare them point by point.

    ``tolerance`` is on the estimated relative error of the force at the last depth that all of them reach.
    ``watch`` sees every equilibrium found; ``followed`` the rough paths (forces within some thousandths).
    """
    # Facets remember where nodes were last: one after the other.
    beside = 1 if any(test.facets for test in tests) else threads()
    paths = [partial(rough_path, test, depths, watch) for test in tests]
    roughs = side_by_side(paths) if beside > 1 else [path() for path in paths]
    followed([path for _, path in roughs])
    outcomes = [Outcome(*rough) for rough in roughs]
    last = min(outcome.path.states[-1].depth if outcome.path.states else 0.0 for outcome in outcomes)
    for outcome in outcomes:
        _visit(outcome, last)
    pairs = list(zip(tests, outcomes, strict=True))
    wanted = {state.depth for outcome in outcomes for state in outcome.path.states}

    def at(depth: float, asked: float | None, level: float) -> tuple[list[Outcome], list[Solved], float]:
        taking = [(test, outcome) for test, outcome in pairs if _at(outcome, depth)]
        roughs = [Solved(outcome.rough, state) for _, outcome in taking if (state := _at(outcome, depth))]
        found, level = _fitted([test for test, _ in taking], roughs, asked, level)
        return [outcome for _, outcome in taking], found, level

    level = 0.0
    first = [partial(at, last, tolerance)] if last in wanted else []
    rest = [partial(at, depth, None) for depth in sorted(wanted - {last})]
    for some in [first, *(rest[k : k + beside] for k in range(0, len(rest), beside))]:
        for taking, solved, reached in side_by_side([partial(call, level) for call in some]):
            level = reached
            for outcome, one in zip(taking, solved, strict=True):
                outcome.solved.append(one)
                watch(one.state)
    for outcome in outcomes:
        outcome.solved.sort(key=lambda solved: solved.state.depth)
    for test, outcome in zip(tests, outcomes, strict=True):
        _trace(test, outcome, watch)
    return outcomes


def _trace(test: SphereTest, outcome: Outcome, watch: Watch) -> None:
    """Fill in the curve of force against depth, with equilibria in between where its integral is in doubt."""
    outcome.trace = [(solved.state.depth, solved.state.force) for solved in outcome.solved]
    limit, footings = outcome.path.limit, list(outcome.path.footings)
    tolerance, left, at_once = _WORK_TOLERANCE, _MOST_MORE_DEPTHS, _AT_ONCE
    if test.facets is not None:
        tolerance, left, at_once = _WORK_TOLERANCE_ON_FACETS, _MOST_MORE_DEPTHS_ON_FACETS, 1
    taut = taut_at(outcome.rough, outcome.trace)
    while left > 0 and not outcome.path.jumps:
        turning = limit.turning_point if limit else None
        depths = doubtful(outcome.trace, tolerance, turning, min(at_once, left), taut)
        near: list[State] = []
        for depth in depths:
            below = [footing for footing in footings if footing.state.depth < depth]
            try:
                footing = next_footing(outcome.rough, below[-1] if below else None, depth)
            except NoEquilibriumError:
                left = 0
                break
            footings = sorted([*footings, footing], key=lambda one: one.state.depth)
            near.append(footing.state)
        work = [partial(_fitted, [test], [Solved(outcome.rough, state)], None, 0.0) for state in near]
        for [solved], _level in side_by_side(work):
            watch(solved.state)
            outcome.trace = sorted([*outcome.trace, (solved.state.depth, solved.state.force)])
        left = left - len(near) if near else 0


def _at(outcome: Outcome, depth: float) -> State | None:
    return next((state for state in outcome.path.states if state.depth == depth), None)


def _visit(outcome: Outcome, depth: float) -> None:
    """Add the state at ``depth`` to a path that passes it."""
    below = [state for state in outcome.path.states if state.depth < depth]
    if _at(outcome, depth) or not outcome.path.states or depth > outcome.path.states[-1].depth:
        return
    if below:
        state = outcome.rough.equilibrium(depth, below[-1].places, below[-1].touching)
    else:
        state = cold_start(outcome.rough, depth)
    outcome.path.states = sorted([*outcome.path.states, state], key=lambda state: state.depth)


def _fitted(
    tests: Sequence[SphereTest], near: Sequence[Solved], tolerance: float | None, level: float
) -> tuple[list[Solved], float]:
    """Solve all tests at one depth on one fitted mesh, refined until their forces settle within ``tolerance``.

    Where the fitted mesh has no equilibrium (at a turning point) the solutions ``near`` stand.
    """
    stages, before = _stages(tests[0]), np.inf
    # Where a punch is rounder than its width says, the rough mesh may miss as much as the first fitted one does.
    told = tests[0].facets is None or len(stages) > 1
    # On facets the force comes to its limit by leaps, not by the order of the elements.
    caution = _CAUTION[tests[0].order] if tests[0].facets is None else min(_CAUTION[tests[0].order], 1.0)
    # A force that gives way to the depth errs with how soft the sheet is: meshes of their own may err alike there, and
    # the next one is the same with its sides halved.
    gives = tolerance is not None and tests[0].facets is None and any(_gives_way(solved) for solved in near)
    told = told and not (gives and len(stages) == 1)
    triangles: Triangles | None = None
    while True:
        edges = [edge for solved in near if (edge := contact_edge(solved.press, solved.state))]
        if not edges:
            return list(near), level
        if len(stages) == 1 and triangles is not None:
            triangles = halved(tests[0].outline, triangles)
        else:
            triangles = _fitted_triangles(replace(tests[0], mesh_size=stages[0]), edges, level)
        mesh = _mesh(tests[0], triangles)
        try:
            found = [solve_on(test, mesh, solved) for test, solved in zip(tests, near, strict=True)]
        except NoEquilibriumError:
            return list(near), level
        if len(stages) > 1:
            near, stages = found, stages[1:]
            continue
        if not gives:
            triangles = None
        changes = [
            difference(new.state, old.state, tests[0].facets is None) for new, old in zip(found, near, strict=True)
        ]
        if tolerance is not None and level == 0.0 and tests[0].facets is None and not gives:
            coarser = _coarser(tests, found, edges)
            # Where that one has no equilibrium, the next level's tells.
            told = told and coarser is not None
            also = [difference(new.state, old.state, True) for new, old in zip(found, coarser or near, strict=True)]
            changes = [max(pair) for pair in zip(changes, also, strict=True)]
        errors = [change / caution for change in changes]
        found = [replace(solved, error=error) for solved, error in zip(found, errors, strict=True)]
        done = tolerance is None or (told and max(errors) <= tolerance)
        # Nodes that slide off a sharp rim, or coarse facets, leave a noise that finer meshes do not lower at once.
        done |= tests[0].facets is not None and max(errors) > _STALLED * before
        before = max(errors) if told else np.inf
        if done or level >= _MOST_LEVELS or mesh.unknowns > _MOST_UNKNOWNS:
            return found, level
        # Where the next mesh has no equilibrium these stand, without an error that is not to be trusted.
        near = found if told else [replace(solved, error=None) for solved in found]
        level, told = level if gives else level + 1.0, True


def _coarser(
    tests: Sequence[SphereTest], found: Sequence[Solved], edges: Sequence[ContactEdge | ContactFront]
) -> list[Solved] | None:
    """Solve all tests on a mesh that is coarser everywhere; None where it has no equilibrium."""
    mesh = _mesh(tests[0], _fitted_triangles(tests[0], edges, _COARSER_LEVEL))
    try:
        return [solve_on(test, mesh, solved) for test, solved in zip(tests, found, strict=True)]
    except NoEquilibriumError:
        return None


def _gives_way(solved: Solved) -> bool:
    """Say whether the force grows by less than the depth does, both by their share."""
    press, state = solved.press, solved.state
    if state.force == 0.0:
        return False
    tangent = press.tangent(state)
    # In balance the punch pushes as the rim pulls.
    slope = -press.sheet.mesh.copies * float((tangent.lift * tangent.per_depth).sum())
    press.sheet.pattern.release()
    return slope * state.depth < state.force


def _stages(test: SphereTest) -> list[float]:
    """Return mesh sizes [mm] from one that the rough solution can start to the test's own, the last twice as fine.

    The set of touching nodes moves by about a ring of elements an iteration: a start on a much finer mesh is slow.
    """
    rough = max(test.mesh_size, _ROUGH * test.outline.reach)
    if rough <= _FASTEST * test.mesh_size:
        return [test.mesh_size]
    before = 2.0 * test.mesh_size
    count = max(1, ceil(log(rough / before) / log(_FASTEST)))
    sizes = [rough * (before / rough) ** (stage / count) for stage in range(1, count + 1)]
    return [*sizes, test.mesh_size]


def _mesh(test: SphereTest, triangles: Triangles) -> SheetMesh:
    return sheet_mesh(test.outline, triangles, test.order)


def _triangles(test: SphereTest, size: SizeField) -> Triangles:
    return triangulate(test.outline, size, seed=test.seed, jitter=test.jitter)
