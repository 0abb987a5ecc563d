"""Molds as they come: concave, with many triangles, several bodies; the sheet lies outside all of them."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from cloth_molds import ball, long_cylinder
from scipy.spatial import ConvexHull

from hyperfab.cloth import Sheet, answers, drape, follow, mold_of, raised, tabulate
from hyperfab.cloth.net import FIXED
from hyperfab.surface import Surface

SOFT = tabulate(lambda lam: (0.4 * (lam - lam**-2), 0.4 * (1 + 2 * lam**-3)), 4.0)


def torso(step: float = 3.0) -> Surface:
    """Height field of a back with two domes and a valley between them, closed below."""
    x = np.arange(-90, 90 + step / 2, step)
    u, v = np.meshgrid(x, x, indexing="ij")
    z = 25 * np.exp(-((u / 80) ** 2) - (v / 70) ** 2)
    for side in (-38.0, 38.0):
        z += 38 * np.exp(-(((u - side) / 24) ** 2) - (v / 26) ** 2)
    n = len(x)
    number = np.arange(n * n).reshape(n, n)
    a, b, c, d = (number[s].ravel() for s in (np.s_[:-1, :-1], np.s_[1:, :-1], np.s_[1:, 1:], np.s_[:-1, 1:]))
    faces = np.vstack([np.column_stack([a, b, c]), np.column_stack([a, c, d])])
    return Surface(np.column_stack([u.ravel(), v.ravel(), z.ravel()]), faces)


def at_rest(sheet: Sheet, surface: Surface, shift: tuple[float, float, float]):
    mold = mold_of(surface, shift)
    found = drape(sheet, mold)
    fields = answers(sheet, mold, found)
    assert found.converged, found.status
    assert fields.cut.node <= 1e-9
    assert fields.imbalance < 1e-5
    return found, fields


@pytest.mark.parametrize("n", [61, 90])
def test_a_sheet_spans_the_valley_of_a_concave_mold(n):
    surface = torso()
    top = surface.vertices[:, 2].max()
    found, fields = at_rest(Sheet(n, n, (220.0, 220.0), 1.0, SOFT, SOFT), surface, (0.0, 0.0, 50.0 - top))
    height = found.state.x[:, n // 2, 2]
    assert height[n // 2] > -top + 50.0 + surface.vertices[np.abs(surface.vertices[:, :2]).sum(1).argmin(), 2]
    assert found.state.contact[:, n // 2 - 2 : n // 2 + 3].any()
    assert fields.press_force > 0


def test_two_molds_side_by_side_carry_the_sheet_together():
    one = trimesh.creation.icosphere(subdivisions=4, radius=30.0)
    two = one.copy()
    one.apply_translation([-40, 0, 0])
    two.apply_translation([40, 0, 8])
    both = trimesh.util.concatenate([one, two])
    found, _ = at_rest(Sheet(61, 61, (200.0, 200.0), 1.0, SOFT, SOFT), Surface(both.vertices, both.faces), (0, 0, 10.0))
    touching = found.state.x[found.state.contact != 0]
    assert (touching[:, 0] < 0).any()
    assert (touching[:, 0] > 0).any()


def test_a_mold_of_300_000_triangles_is_no_harder():
    coarse, _ = at_rest(Sheet(51, 51, (200.0, 200.0), 1.0, SOFT, SOFT), ball(5), (0.0, 0.0, 20.0))
    fine, _ = at_rest(Sheet(51, 51, (200.0, 200.0), 1.0, SOFT, SOFT), ball(7), (0.0, 0.0, 20.0))
    assert fine.energy == pytest.approx(coarse.energy, rel=1e-3)


@pytest.mark.parametrize("sections", [12, 64, 180, 4096])
def test_a_node_that_meets_the_tip_of_a_cone_rests_on_it(sections):
    cone = trimesh.creation.cone(radius=50.0, height=60.0, sections=sections)
    surface = Surface(cone.vertices, cone.faces)
    sheet = Sheet(61, 61, (200.0, 200.0), 1.0, SOFT, SOFT)
    mold = mold_of(surface, (0.0, 0.0, -20.0))
    found = drape(sheet, mold)
    assert found.converged, found.status
    assert found.state.x[30, 30] == pytest.approx([0.0, 0.0, 40.0], abs=1e-9)
    # But for the facets on which its neighbours lie, one beside the other, the net is its own mirror image.
    x = found.state.x
    for mirrored, sign in ((x[::-1], [-1.0, 1.0, 1.0]), (x[:, ::-1], [1.0, -1.0, 1.0])):
        assert np.abs(mirrored * sign - x).max() < 0.5


@pytest.mark.parametrize("mu", [0.1, 0.3])
def test_a_sheet_that_rubs_on_a_concave_mold_comes_to_rest_and_its_work_balances(mu):
    surface = torso()
    mold = mold_of(surface, (0.0, 0.0, -surface.vertices[:, 2].max()))
    sheet = Sheet(41, 41, (220.0, 220.0), 1.0, SOFT, SOFT)
    *_, rest = follow(sheet, mold, np.linspace(0.0, 50.0, 21)[1:], mu)
    assert rest.found.converged, rest.found.status
    fields = answers(sheet, raised(mold, rest.height), rest.found)
    assert fields.cut.node <= 1e-9
    assert fields.imbalance < 1e-5
    free = drape(sheet, raised(mold, rest.height))
    assert fields.press_force > answers(sheet, raised(mold, rest.height), free).press_force
    # What the press does is stored or rubbed away, to the trapezoidal rule's error of 20 steps.
    assert rest.rubbed > 0.0
    assert rest.work == pytest.approx(rest.found.energy - rest.unstressed + rest.rubbed, rel=0.01)


def elliptic_cylinder(a: float, b: float, sections: int) -> Surface:
    round_one = long_cylinder(1.0, sections)
    return Surface(round_one.vertices * [a, 1.0, b], round_one.faces)


@pytest.mark.slow
def test_a_string_over_an_ellipse_has_the_exact_stretch_and_rubs_in_the_usual_steps():
    """The string is the upper hull of both clamps and the ellipse; a broad top is met by many nodes at once."""
    a, b, depth, n = 80.0, 40.0, 10.0, 201
    angle = np.linspace(0.0, np.pi, 20001)
    points = np.column_stack([a * np.cos(angle), b * np.sin(angle) + depth - b])
    points = np.vstack([points[points[:, 1] > 0.0], [[100.0, 0.0], [-100.0, 0.0]]])
    exact = (ConvexHull(points).area - 200.0) / 200.0  # of a plane figure, area is its girth
    mold = mold_of(elliptic_cylinder(a, b, 5760), (0.0, 0.0, -b))
    sheet = Sheet(n, 3, (200.0, 10.0), 1.0, SOFT, SOFT, edges=(FIXED, FIXED, 0, 0))
    at = raised(mold, depth)
    free = drape(sheet, at)
    assert answers(sheet, at, free).stretch_warp.mean() - 1.0 == pytest.approx(exact - 1.0, rel=2e-3)
    *_, rest = follow(sheet, mold, np.linspace(0.0, depth, 21)[1:], 0.2)
    assert rest.found.converged, rest.found.status
    # Nodes slide outward: a tension that falls towards the top by exp(-mu angle) at most.
    tension = SOFT(answers(sheet, at, rest.found).stretch_warp[:, 1])[1]
    way = np.diff(rest.found.state.x[:, 1], axis=0)
    turn = np.arctan2(way[0, 2], way[0, 0])  # from the clamp to the top
    assert tension.min() / tension.max() >= np.exp(-0.2 * turn) * (1.0 - 1e-3)
    assert tension.min() < (1.0 - 1e-3) * tension.max()


def test_the_force_on_a_round_cone_does_not_hang_on_how_it_is_cut_into_facets():
    """A node that slid off the tip would take 4 % of the force with it."""
    sheet, forces = Sheet(61, 61, (200.0, 200.0), 1.0, SOFT, SOFT), []
    for sections, begin in ((180, 0.0), (180, 0.5), (720, 0.0), (721, 0.3), (1024, 0.5)):
        cone = trimesh.creation.cone(radius=60.0, height=60.0, sections=sections)
        cone.apply_transform(trimesh.transformations.rotation_matrix(begin * 2 * np.pi / sections, [0, 0, 1]))
        mold = mold_of(Surface(cone.vertices, cone.faces), (0.0, 0.0, -15.0))
        found = drape(sheet, mold)
        assert found.converged, found.status
        assert found.state.x[30, 30] == pytest.approx([0.0, 0.0, 45.0], abs=1e-9)
        forces.append(answers(sheet, mold, found).press_force)
    assert np.ptp(forces) < 1e-4 * max(forces)


@pytest.mark.parametrize("deep", [pytest.param(12.0, marks=pytest.mark.slow), 29.0])
def test_a_sheet_over_a_hollow_mold_hangs_on_its_rim_as_on_the_top_of_a_solid_one(deep):
    """The wall is as thick as the spacing; every coarser grid has nodes on both sides of it and none on it."""

    def turned(*profile: tuple[float, float]) -> Surface:
        mesh = trimesh.creation.revolve(np.array(profile[::-1]), sections=48)
        return Surface(mesh.vertices, mesh.faces)

    outside = (40.0, 0.0), (40.0, -30.0), (0.0, -30.0)
    molds = turned((0.0, 0.0), *outside), turned((0.0, -deep), (35.0, -deep), (35.0, 0.0), *outside)
    sheet, on = Sheet(41, 41, (160.0, 160.0), 1.0, SOFT, SOFT), (0.0, 0.0, 30.0)
    (solid, one), (hollow, two) = (at_rest(sheet, mold, on) for mold in molds)
    assert hollow.energy == pytest.approx(solid.energy, rel=1e-9)
    assert two.press_force == pytest.approx(one.press_force, rel=1e-6)
