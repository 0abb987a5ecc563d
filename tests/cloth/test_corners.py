"""Which springs the corners of a mold bend: those whose straight way leads through it, and no other."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import trimesh
from cloth_molds import under

from hyperfab.cloth import Sheet, follow, load_steps, mold_of, tabulate
from hyperfab.cloth.bends import farthest, find_bends
from hyperfab.cloth.law import spring_law
from hyperfab.cloth.newton import equilibrium
from hyperfab.cloth.start import settled
from hyperfab.materials import bind
from hyperfab.surface import Surface

SOFT = tabulate(lambda lam: (0.4 * (lam - lam**-2), 0.4 * (1 + 2 * lam**-3)), 4.0)
WARP = spring_law(bind("yeoh-3", {"C10_MPa": 0.06012, "C20_MPa": 0.02198, "C30_MPa": 0.016784}))
WEFT = spring_law(bind("yeoh-3", {"C10_MPa": 0.04495, "C20_MPa": 0.01284, "C30_MPa": 0.008692}))
TORSO = Path(__file__).parents[2] / "molds" / "torso.stl"


def star(rng: np.random.Generator, rays: int) -> Surface:
    """A tip at the origin over a closed polygon below it, drawn such that some edges at the tip turn inward."""
    angle = 2.0 * np.pi * (np.arange(rays) + rng.uniform(-0.3, 0.3, rays)) / rays
    far, fall = rng.uniform(20.0, 40.0, rays), rng.uniform(0.0, 1.4, rays)
    ring = np.column_stack([far * np.cos(angle), far * np.sin(angle), -far * fall])
    k = np.arange(rays)
    on, foot = (k + 1) % rays, 0 * k + rays + 1
    points = np.vstack([ring, [[0.0, 0.0, 0.0], [0.0, 0.0, -200.0]]])
    return Surface(points, np.vstack([np.column_stack([k, on, 0 * k + rays]), np.column_stack([on, k, foot])]))


def chords(surface: Surface, rng: np.random.Generator, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Ends, outside the mold, of straight ways of 5 mm past its tip."""
    middle, way = rng.uniform(-1.5, 1.5, (count, 3)), rng.normal(size=(count, 3))
    way *= 2.5 / np.linalg.norm(way, axis=1)[:, None]
    ends = np.stack([middle - way, middle + way], 1)
    outside = (surface.nearest(ends.reshape(-1, 3)).distance > 0.0).reshape(-1, 2).all(1)
    return ends[outside, 0], ends[outside, 1]


def met(surface: Surface, start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """(k,) lengths in mm of straight ways inside a closed mold: all crossings with its facets, one by one in pairs."""
    way = end - start
    tri = surface.vertices[surface.faces]
    a, u, v = tri[:, 0], tri[:, 1] - tri[:, 0], tri[:, 2] - tri[:, 0]
    out = np.zeros(len(start))
    for k in range(len(start)):
        lhs = np.stack([np.broadcast_to(-way[k], u.shape), u, v], 2)
        t, b, c = np.linalg.solve(lhs, (start[k] - a)[:, :, None])[..., 0].T
        hit = np.sort(t[(t > 0.0) & (t < 1.0) & (b >= 0.0) & (c >= 0.0) & (b + c <= 1.0)])
        assert len(hit) % 2 == 0
        out[k] = (hit[1::2] - hit[::2]).sum() * np.linalg.norm(way[k])
    return out


def bent(surface: Surface, start: np.ndarray, end: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Which of the straight ways are laid over an edge, each as a spring of its own, and how long each is then."""
    mold, count = mold_of(surface), len(start)
    alone = np.zeros((2, count, 2), np.bool_)
    alone[:, :, 1] = True
    springs, ways = np.empty((count, 4), np.int64), np.empty((count, 13))
    nodes = np.stack([start, end])
    found = find_bends(nodes, np.zeros((2, count)), mold, alone, farthest(mold.creases), springs, ways, 0, 2, 0)
    over, length = np.zeros(count, np.bool_), np.linalg.norm(end - start, axis=1)
    over[springs[:found, 1]], length[springs[:found, 1]] = True, ways[:found, 12]
    return over, length


@pytest.mark.parametrize("rays", [5, 6, 8])
def test_a_way_that_passes_a_corner_outside_the_mold_is_left_straight(rays):
    rng = np.random.default_rng(rays)
    entering = passing = laid = 0
    drawn = [star(rng, rays) for _ in range(40)]
    hollow = [surface for surface in drawn if (surface.edge_turn < -0.1).any()]
    assert len(hollow) >= 5
    for surface in hollow:
        start, end = chords(surface, rng, 200)
        inside = met(surface, start, end)
        over, length = bent(surface, start, end)
        assert not over[inside == 0.0].any()
        assert (length[over] >= np.linalg.norm(end - start, axis=1)[over] * (1.0 - 1e-12)).all()
        entering, passing = entering + (inside > 0.1).sum(), passing + (inside == 0.0).sum()
        laid += (over & (inside > 0.1)).sum()
    assert passing > 500
    assert laid > 0.8 * entering  # the others enter where an edge turns by too little to bend a spring, or inward


@pytest.mark.parametrize(("size", "n"), [(60.0, 25), (300.0, 81), (300.0, 161), (1000.0, 101)])
def test_a_sheet_that_a_corner_just_touches_is_at_rest_as_it_is(size, n):
    rng = np.random.default_rng(n)
    for _ in range(6):
        surface = star(rng, 8)
        # The tip lies amid a cell, at the height of the sheet but for rounding.
        beside = rng.uniform(0.2, 0.8, 2) * size / (n - 1)
        mold = mold_of(surface, (beside[0], beside[1], -1e-14 * size))
        sheet = Sheet(n, n, (size, size), 0.5, SOFT, SOFT)
        found = equilibrium(sheet, mold, settled(sheet.flat(), mold, sheet), 1e-6, largest=0)
        assert found.converged, found.status
        assert len(found.bent) == 0


@pytest.mark.slow
@pytest.mark.parametrize("mu", [0.1, 0.3])
@pytest.mark.parametrize("steps", [10, 20])
def test_a_sheet_that_rubs_on_a_torso_of_an_stl_comes_to_rest(mu, steps):
    mesh = trimesh.load(TORSO)
    surface = Surface(mesh.vertices, mesh.faces)
    sheet = Sheet(81, 65, (300.0, 240.0), 0.5, WARP, WEFT)
    *_, rest = follow(sheet, mold_of(surface, under(surface, 0.0)), load_steps([50.0], steps), mu)
    assert rest.found.converged, rest.found.status
    assert rest.found.residual_relative <= 1e-6
