"""The path of equilibria as the punch goes in: load steps that adapt, and the depth beyond which there is none."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from hyperfab.arrays import Array, Flags
from hyperfab.membrane.contact import Frictionless
from hyperfab.membrane.ellipticity import Weakest, lost, weakest
from hyperfab.membrane.equilibrium import NoEquilibriumError, Press, State
from hyperfab.membrane.punch import Punch, Sphere
from hyperfab.membrane.sheet import Sheet
from hyperfab.numerics.blocks import BlockPattern
from hyperfab.numerics.linear import SingularMatrixError

#: A load step is halved at most down to this part of the whole depth.
_SMALLEST_STEP = 2e-5
#: Steps that may fail on a path, and more for each depth that was reached: the rest would come no faster.
_MOST_FAILURES, _MORE_FAILURES = 40, 4
#: Pivots this far below zero, relative to the median, count as negative.
_PIVOT_NOISE = 1e-9

#: What a step's rise of energy may lack or exceed of the work of the forces at its ends: a part of force times depth.
_ODD_WORK = 0.05
#: The larger stretch changes by no more than this factor within an element of a sheet that has snapped.
_MOST_CHANGE = 3.0
#: How far beyond the last equilibrium one may be sought that no path leads to, over the sheet's reach.
_LEAP = 0.75
#: The least part of the first depth at which a path is begun, and where the constants let stretch gather in bands.
_BEGUN, _BEGUN_IN_BANDS = 0.02, 0.1
#: Part of the expected way to a turning point that is tried at once.
_SHY = 0.8
#: Rounds of the active-set method for a first guess of the shape.
_MOST_ROUNDS = 40
#: Up to this stretch of the way over the sphere a sheet that was mounted slack is begun from how it hangs, not from a
#: film: where it bears next to nothing, that film is far from it.
_BARELY = 1.02
#: Points no farther from the punch than this [mm] touch it.
_ON_PUNCH = 1e-9
#: A depth is halved between two so often: to rounding.
_HALVINGS = 60

Watch = Callable[[State], None]


class LostEllipticityError(NoEquilibriumError):
    """A shape at which the sheet may gather its stretch in ever narrower bands; ``where`` it may first."""

    def __init__(self, where: Weakest) -> None:
        super().__init__(
            f"at stretches {where.stretches[0]:.3f} and {where.stretches[1]:.3f} the constants let the stretch gather "
            "in bands without width (ellipticity is lost)"
        )
        self.where = where


@dataclass(frozen=True)
class Limit:
    """Why a path ended: the last depth reached [mm], the turning point where one was found, and words.

    ``bands``: where the sheet is no longer elliptic just beyond, where this ended the path.
    """

    depth: float
    reason: str
    turning_point: float | None = None
    bands: Weakest | None = None


@dataclass
class Path:
    """States at the depths asked for, as far as they were reached, and where and why the path ended early.

    ``footings``: all equilibria on the way, also those at depths that were not asked for; ``jumps``: depths [mm]
    between which the path broke off, and equilibria of another shape were found beyond; ``failures``: steps
    that failed.
    """

    states: list[State] = field(default_factory=list)
    limit: Limit | None = None
    iterations: int = 0
    failures: int = 0
    jumps: list[tuple[float, float]] = field(default_factory=list)
    footings: list[Footing] = field(default_factory=list)


#: Is told of the paths of all sheets on their first meshes.
Followed = Callable[[list[Path]], None]


@dataclass(frozen=True)
class Footing:
    """An equilibrium and how fast its places move with depth."""

    state: State
    speed: float


def follow(press: Press, depths: Sequence[float], watch: Watch = lambda state: None) -> Path:
    """Follow the equilibria through increasing ``depths`` [mm]; ``watch`` sees every accepted state.

    Steps that fail are halved; a path that cannot go on ends with a Limit.
    """
    path = Path()
    footings = path.footings
    for depth in depths:
        while not footings or footings[-1].state.depth < depth:
            try:
                _advance(press, footings, depth, _SMALLEST_STEP * depths[-1], path, watch)
            except NoEquilibriumError as error:
                limit = _limit(footings, depth, error)
                stays = press.tangential.remembers or limit.bands is not None or limit.depth == 0.0
                leap = min(depth, limit.depth + _LEAP * press.sheet.reach)
                beyond = None if stays else _jumped(press, leap, footings[-1].state)
                if beyond is not None:
                    path.jumps.append((limit.depth, leap))
                    footings.append(beyond)
                    path.iterations += beyond.state.iterations
                    watch(beyond.state)
                    continue
                path.limit = limit
                if footings and (not path.states or footings[-1].state.depth > path.states[-1].depth):
                    path.states.append(footings[-1].state)
                return path
        path.states.append(footings[-1].state)
    return path


def cold_start(press: Press, depth: float) -> State:
    """Return the equilibrium at ``depth`` from nothing but a film stretched over the punch, or hung over it.

    Raises NoEquilibriumError.
    """
    hung = hung_over(press.sheet, press.punch, depth)
    places, touching = film_over(press.sheet, press.punch, depth) if hung is None else hung
    free = replace(press, tangential=Frictionless())
    try:
        # Parts of a sheet that was mounted slack hang.
        state = free.equilibrium(depth, places, touching, cold=True, careful=press.sheet.prestretch < 1.0)
    except NoEquilibriumError:
        with np.errstate(all="ignore"):
            bands = lost(press.sheet.law, press.sheet.strain(places)).any()
        if bands:  # where those of a film already may gather, careful steps wander without end
            raise LostEllipticityError(weakest(press.sheet, places)) from None
        state = free.equilibrium(depth, places, touching, cold=True, careful=True)
    if not press.tangential.remembers or state.force == 0.0:
        return state
    if press.sheet.prestretch < 1.0:
        # What hangs slack over the punch does not rub: it does from where it lies when it first bears.
        return replace(state, memory=replace(state.memory, sticking=state.touching))
    return press.equilibrium(depth, state.places, state.touching)


def _advance(press: Press, footings: list[Footing], target: float, smallest: float, path: Path, watch: Watch) -> None:
    """Reach ``target`` from the last footing, by halved steps where need be."""
    step = target - footings[-1].state.depth if footings else min(target, _LEAP * press.sheet.reach)
    failed = False
    while not footings or footings[-1].state.depth < target:
        here = footings[-1].state.depth if footings else 0.0
        depth = target if target - here <= 1.01 * step else here + step
        try:
            found = next_footing(press, footings[-1] if footings else None, depth)
        except NoEquilibriumError as error:
            failed = True
            path.failures += 1
            if path.failures > _MOST_FAILURES + _MORE_FAILURES * len(path.states):
                raise NoEquilibriumError(f"too many steps failed, the last one because: {error}") from error
            ahead = _turning_ahead(footings)
            step = 0.5 * step if ahead is None else min(0.5 * step, _SHY * ahead)
            barely = _BEGUN_IN_BANDS if isinstance(error, LostEllipticityError) else _BEGUN
            if step < smallest or (not footings and step < barely * target):
                raise
            continue
        footings.append(found)
        path.iterations += found.state.iterations
        watch(found.state)
        # On the way to a turning point the next step is taken from how the sheet speeds up.
        ahead = _turning_ahead(footings) if failed else None
        step = 2.0 * step if ahead is None else min(2.0 * step, _SHY * ahead)
        if step < smallest:
            raise NoEquilibriumError("the steps became too small")


def _jumped(press: Press, depth: float, last: State) -> Footing | None:
    """Return a stable equilibrium at ``depth`` that no path led to, None where a cold start finds none.

    A sheet that snaps loses energy: one that holds more than the punch can have done since ``last`` is none, nor is
    one whose stretch changes so much within an element that a finer mesh would find another.
    """
    try:
        beyond = next_footing(press, None, depth)
    except NoEquilibriumError:
        return None
    stretch = press.sheet.principal(beyond.state.places).stretch.max(axis=1)
    in_element = stretch.reshape(len(press.sheet.mesh.elements), -1)
    resolved = (in_element.max(axis=1) <= _MOST_CHANGE * in_element.min(axis=1)).all()
    return beyond if resolved and _odd_work(last, beyond.state) <= _ODD_WORK else None


def _odd_work(below: State, above: State) -> float:
    """Return by how much the energy rises beyond the work [N mm] of the larger force of two equilibria without
    friction, or less (negative) than that of the smaller one, over force times depth: on one path by next to nothing.
    """
    least, most = sorted([below.force, above.force])
    if most <= 0.0:  # slack: what energy there is, is left of the iteration
        return 0.0
    rise, way = above.energy - below.energy, above.depth - below.depth
    return (max(rise - most * way, 0.0) + min(rise - least * way, 0.0)) / (most * above.depth)


def next_footing(press: Press, below: Footing | None, depth: float) -> Footing:
    """Return the equilibrium at ``depth`` on the path from the one ``below``, from a cold start where there is none.

    Raises NoEquilibriumError, also where the equilibrium is unstable or the sheet there no longer elliptic.
    """
    first = below is None or below.state.force == 0.0
    if below is None or first:
        state = cold_start(press, depth)
    else:
        last = below.state
        state = press.nearby(depth, last.places, last.touching, last.residual, last.memory)
    # A long step may land on another shape than the one that the path leads to.
    if below and not press.tangential.remembers and abs(_odd_work(below.state, state)) > _ODD_WORK:
        raise NoEquilibriumError("the path does not lead to the shape found")
    if state.force == 0.0:
        return Footing(state, 1.0)
    try:
        tangent = press.tangent(state)
    except SingularMatrixError as error:
        raise NoEquilibriumError("the stiffness is singular") from error
    if press.tangential.symmetric and tangent.factor.negative_pivots(_PIVOT_NOISE):
        raise NoEquilibriumError("the equilibrium is unstable")
    weak = weakest(press.sheet, state.places)
    if weak.lost:
        raise LostEllipticityError(weak)
    # Where a sheet that hung first bears, what is next to slack goes anywhere: nodes then land straight down.
    if not (first and press.sheet.prestretch < 1.0):
        drift = tangent.per_depth - np.array([0.0, 0.0, 1.0])
        state = replace(state, memory=replace(state.memory, drift=drift))
    return Footing(state, float(np.sqrt((tangent.per_depth**2).mean())))


def _turning_ahead(footings: list[Footing]) -> float | None:
    """Return how far ahead [mm] a turning point is expected from the last two footings, None where they slow down."""
    if len(footings) < 2:
        return None
    (s1, v1), (s2, v2) = ((footing.state.depth, footing.speed) for footing in footings[-2:])
    if not (v2 > v1 > 0.0 and s2 > s1):
        return None
    return (s2 - s1) * v1**2 / (v2**2 - v1**2)


def _limit(footings: list[Footing], target: float, error: NoEquilibriumError) -> Limit:
    """Say why the path ended. At a turning point the speed grows as one over the root of the depth that is left."""
    if not footings:
        bands = error.where if isinstance(error, LostEllipticityError) else None
        return Limit(0.0, f"no equilibrium was found from a cold start up to {target:.4g} mm: {error}", bands=bands)
    reached = footings[-1].state.depth
    if isinstance(error, LostEllipticityError):
        x, y = error.where.at
        words = (
            f"no equilibrium beyond {reached:.2f} mm that a finer mesh would find again: at stretches "
            f"{error.where.stretches[0]:.3f} and {error.where.stretches[1]:.3f}, ({x:.1f}, {y:.1f}) mm from the "
            "middle, the constants let the stretch gather in bands without width (ellipticity is lost)"
        )
        return Limit(reached, words, bands=error.where)
    ahead = _turning_ahead(footings)
    if ahead is not None and ahead < 0.02 * reached:
        turning = reached + ahead
        words = f"no equilibrium beyond {turning:.2f} mm: the path turns back there (turning point)"
        return Limit(reached, words, turning)
    return Limit(reached, f"no equilibrium was found beyond {reached:.2f} mm: {error}")


def taut_at(press: Press, trace: Sequence[tuple[float, float]]) -> float | None:
    """Return the depth [mm] from which on a sheet that was mounted slack bears: the way from the punch's highest point
    to the nearest of the rim is then as long as the sheet is there.

    ``trace`` are depths and forces. None of a sheet that bears at once or not yet, and where that is not known: of
    facets, and of a sheet of which another point than its middle may come to lie highest.
    """
    sheet, punch = press.sheet, press.punch
    if not trace or not isinstance(punch, Sphere) or sheet.prestretch >= 1.0 or sheet.mesh.copies == 1:
        return None
    length, low, high = sheet.reach / sheet.prestretch, 0.0, trace[-1][0]
    if punch.way(sheet.reach, high) <= length:
        return None
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if punch.way(sheet.reach, middle) <= length else (low, middle)
    return high


def hung_over(sheet: Sheet, punch: Punch, depth: float) -> tuple[Array, Flags] | None:
    """Return places (n, 3) and touching nodes (n,) of a sheet that was mounted slack and bears nothing yet, or barely:
    over the punch, and stretched no more than that takes. None where it bears more, and where no such shape is known.

    Out to the nearest of the rim each line from the middle is drawn in alike, to the way over the sphere; beyond, the
    sheet lies as it was mounted. Around the middle it is drawn in by more, for the way bends.
    """
    if not isinstance(punch, Sphere) or sheet.prestretch >= 1.0:
        return None
    length = sheet.reach / sheet.prestretch
    if punch.way(sheet.reach, depth) > _BARELY * length:
        return None
    nodes, elements = sheet.mesh.nodes, sheet.mesh.elements
    radius = np.linalg.norm(nodes, axis=1)
    # Rounding moves no node of the rim.
    inside = radius < (1.0 - 1e-9) * length
    profile = punch.along(radius[inside] / length, sheet.reach, depth)
    places = sheet.flat
    places[inside, :2] = nodes[inside] * (profile[:, 0] / np.maximum(radius[inside], 1e-300))[:, None]
    places[inside, 2] = profile[:, 1]
    if sheet.mesh.order == 2:
        # Over the fold in between a bent side would be stretched.
        sides = elements[:, [[0, 1, 3], [1, 2, 4], [2, 0, 5]]].reshape(-1, 3)
        one, two, middle = sides[np.ptp(inside[sides].astype(int), axis=1) > 0].T
        places[middle] = 0.5 * (places[one] + places[two])
    return places, inside & (punch.near(places, depth).gap <= _ON_PUNCH)


def film_over(sheet: Sheet, punch: Punch, depth: float) -> tuple[Array, Flags]:
    """Return places (n, 3) and touching nodes (n,) of a film of uniform tension stretched over the punch.

    The height w solves the Laplace equation with w >= punch: a linear obstacle problem, by the active-set method.
    """
    mesh = sheet.mesh
    places = sheet.flat
    floor = punch.height(places[:, :2], depth)
    free = np.ones((len(mesh.nodes), 1), bool)
    free[mesh.rim] = False
    pattern = BlockPattern(mesh.elements, len(mesh.nodes), free, mesh.nodes)
    local = np.einsum("mqai,mqbi,mq->mab", mesh.gradients, mesh.gradients, mesh.weights)
    blocks = np.zeros((pattern.blocks, 1, 1))
    np.add.at(blocks[:, 0, 0], pattern.block_of.ravel(), local.ravel())
    stiff = 1e8 * float(blocks[pattern.diagonal].max())
    touching = (floor > 0) & free[:, 0]
    height = np.zeros(len(mesh.nodes))
    for _ in range(_MOST_ROUNDS):
        held = blocks.copy()
        held[pattern.diagonal[touching]] += stiff
        right = np.where(touching, stiff * np.where(touching, floor, 0.0), 0.0)[:, None]
        height = pattern.extend(pattern.solver.factorise(pattern.matrix(held)).solve(pattern.restrict(right)))[:, 0]
        pressed = touching & (np.where(touching, floor, 0.0) > height)
        chosen = (pressed | (~touching & (height < floor))) & free[:, 0]
        if (chosen == touching).all():
            break
        touching = chosen
    places[:, 2] = height
    return places, touching
