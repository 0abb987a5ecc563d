"""Where a plane goes over into a blend, the smooth surface behind the facets is the plane and the blend."""

import numpy as np
import pytest

from hyperfab.pressing.curved import curving
from hyperfab.pressing.dense import dense
from hyperfab.pressing.gap import molding_front, nearest_gap, normal_gap
from hyperfab.pressing.mold import mold
from hyperfab.samples import cup
from hyperfab.surface import Surface

UP = np.array([0.0, 0.0, 1.0])
DEG, RADIUS = 35.0, 15.0
TURN = np.radians(DEG)


def rise(away):
    """A blend of RADIUS from a plane (away < 0) into a slope of DEG, which goes on."""
    over = RADIUS * np.sin(TURN)
    blend = RADIUS - np.sqrt(RADIUS**2 - np.clip(away, 0.0, over) ** 2)
    return blend + np.maximum(away - over, 0.0) * np.tan(TURN)


def lowest(surface):
    """Height of the lowest place of the smooth surface behind some facets."""
    steps = 12
    share = [(i, j, steps - i - j) for i in range(steps + 1) for j in range(steps + 1 - i)]
    weights, face = np.array(share) / steps, np.arange(len(surface.faces))
    places = np.einsum("kc,fcx->fkx", weights, surface.vertices[surface.faces]).reshape(-1, 3)
    return (places + curving(surface).off(np.repeat(face, len(weights)), places))[:, 2].min()


def off(surface, points, cut):
    """How far points are from the smooth surface behind some facets, or their parts."""
    fine, drawn = dense(surface, UP, surface) if cut else (surface, None)
    assert cut == (drawn is not None)
    return np.abs(nearest_gap(points, mold(fine.vertices, fine.faces, 1, drawn=drawn)).nearest).max()


def trough(strips):
    """A slope, a blend in some strips, a plane: from end to end, as CAD writes them, each corner on a border."""
    turn = np.linspace(0.0, TURN, strips + 1)
    x = np.concatenate([[-40.0], RADIUS * np.sin(turn), [40.0]])
    a, b = 2 * np.arange(len(x) - 1), 2 * np.arange(1, len(x))
    faces = np.concatenate([np.stack([a, b, b + 1], axis=1), np.stack([a, b + 1, a + 1], axis=1)])
    return Surface(np.stack([np.repeat(x, 2), np.tile([-60.0, 60.0], len(x)), np.repeat(rise(x), 2)], axis=1), faces)


def dome(sides, height):
    """Rings of some ``sides`` up to a foot at 30 mm, and from there a square, cut to its four corners."""
    turn, rings = (np.arange(sides) + 0.5) * 2.0 * np.pi / sides, np.linspace(30.0, 0.0, sides // 4 + 1)[:-1]
    points = [np.stack([r * np.cos(turn), r * np.sin(turn), np.full(sides, height(r))], axis=1) for r in rings]
    top, k, after = sides * len(rings), np.arange(sides), (np.arange(sides) + 1) % sides
    faces = [np.stack([k + at, after + at, k + at + sides], axis=1) for at in sides * np.arange(len(rings) - 1)]
    faces += [
        np.stack([after + at, after + at + sides, k + at + sides], axis=1) for at in sides * np.arange(len(rings) - 1)
    ]
    faces.append(np.stack([k + top - sides, after + top - sides, np.full(sides, top)], axis=1))
    corner = top + 1 + np.arange(sides) * 4 // sides
    faces.append(np.stack([k, corner, after], axis=1))
    last = corner != corner[after]
    faces.append(np.stack([after, corner, corner[after]], axis=1)[last])
    square = 50.0 * np.array([[1.0, 1.0, 0.0], [-1.0, 1.0, 0.0], [-1.0, -1.0, 0.0], [1.0, -1.0, 0.0]])
    return Surface(np.concatenate([*points, [[0.0, 0.0, height(0.0)]], square]), np.concatenate(faces))


@pytest.mark.parametrize("cut", [False, True])
@pytest.mark.parametrize("strips", [2, 3, 8])
def test_a_plane_beside_strips_of_a_blend_is_a_plane(strips, cut) -> None:
    x = np.linspace(-38.0, 38.0, 500)
    points = np.stack([x, 55.0 * np.sin(x), rise(x)], axis=1)
    assert (
        off(trough(strips), points, cut) < 2e-3
    )  # with normals of both sides 0.91, 0.63, 0.25, of parts 0.11, 0.05, 0.013
    assert lowest(trough(strips)) > -1e-9


@pytest.mark.parametrize("cut", [False, True])
@pytest.mark.parametrize(("sides", "most"), [(24, 0.11), (48, 0.02), (96, 0.004)])
def test_a_plane_around_a_dome_is_a_plane(sides, most, cut) -> None:
    """No vertex of it lies within."""

    def height(r):
        return 20.0 * (1.0 - (r / 30.0) ** 2) ** 2

    surface = dome(sides, height)
    random = np.random.default_rng(0)
    x, y = random.uniform(-45.0, 45.0, (2, 4000))
    away = np.hypot(x, y)
    plane = away > 30.1
    points = np.stack([x, y, np.where(plane, 0.0, height(np.minimum(away, 30.0)))], axis=1)
    assert (
        off(surface, points[plane], cut) < 1e-9
    )  # with normals of both sides: 1.7, 1.0, 0.57, of parts 0.13, 0.09, 0.05
    assert off(surface, points, cut) < most
    assert lowest(surface) > -1e-9


@pytest.mark.parametrize("seed", [0, 1, 4])
def test_strips_of_a_wave_are_no_planes_however_wide(seed) -> None:
    """Some are many times as wide as those beside them."""

    def height(x):
        return 4.0 * np.sin(x / 12.0)

    random = np.random.default_rng(seed)
    x = np.sort(np.concatenate([[-60.0], random.uniform(-60.0, 60.0, 22), [60.0]]))
    assert (x[2:] - x[1:-1]).max() > 3.0 * (x[2:] - x[1:-1]).min()
    a, b = 2 * np.arange(len(x) - 1), 2 * np.arange(1, len(x))
    faces = np.concatenate([np.stack([a, b, b + 1], axis=1), np.stack([a, b + 1, a + 1], axis=1)])
    points = np.stack([np.repeat(x, 2), np.tile([-60.0, 60.0], len(x)), np.repeat(height(x), 2)], axis=1)
    places = np.linspace(x[2], x[-3], 500)
    on = np.stack([places, 55.0 * np.sin(places), height(places)], axis=1)
    assert off(Surface(points, faces), on, False) < 0.25  # the wide ones taken for planes: 0.40, 1.85, 1.31


@pytest.mark.parametrize(("cells", "rms"), [(12, 0.2), (24, 0.035), (88, 1.1e-3)])
def test_the_cup_does_not_dip_below_its_flange(cells, rms) -> None:
    """Its foot runs across the facets."""
    solid = cup.female_cup(cells, cells + 1)
    female = mold(solid.vertices, solid.faces, -1)
    front = Surface(solid.vertices, solid.faces[female.looking])
    # Of what the first corners rise by, 0.03 to 0.8 mm: normals of both sides 0.76, 0.31, 0.033 mm.
    assert lowest(front) > 6.0 - 5e-3
    u, v = np.random.default_rng(1).uniform(-1.05, 1.05, (2, 4000))
    points, normals = cup.male_point(u, v)
    away = nearest_gap(points + cup.normal_gap(u, v)[:, None] * normals, female).nearest
    assert np.sqrt(np.mean(away**2)) < rms  # then 0.27, 0.049, 1.7e-3


@pytest.mark.parametrize(("cells", "worst", "rms"), [((48, 49), 0.016, 3e-3), ((92, 84), 0.016, 1.3e-3)])
def test_the_gap_along_the_normal_at_the_foot_of_the_cup(cells, worst, rms) -> None:
    """Normals at the first corners off the flange are those of the blend."""
    one, two = cup.male_cup(*cells), cup.female_cup(*cells[::-1])
    female = mold(two.vertices, two.faces, -1)
    front = molding_front(mold(one.vertices, one.faces, 1), female)
    x, y, z = front.vertices.T
    u, v = (x - cup.K_LEAN * z) / cup.A_MM, y / cup.B_MM
    gap = normal_gap(front.vertices, front.normals, female) - cup.normal_gap(u, v)
    gap = gap[(np.abs(u) < 1.1) & (np.abs(v) < 1.1)]
    assert np.abs(gap).max() < worst  # with normals of both sides: 0.022, 0.021
    assert np.sqrt(np.mean(gap**2)) < rms  # 3.4e-3, 1.7e-3


@pytest.mark.parametrize("cells", [6, 12])
def test_parts_of_facets_stand_for_what_these_do(cells) -> None:
    """A sphere's patch with borders, where normals are of one side: cutting its facets leaves it what it is."""
    turn = np.radians(np.linspace(-40.0, 40.0, cells + 1))
    across, along = np.meshgrid(turn, turn, indexing="ij")
    places = np.stack([np.sin(across) * np.cos(along), np.sin(along), np.cos(across) * np.cos(along)], axis=-1)
    solid = cup.closed_below(80.0 * places, -10.0)
    surface = Surface(solid.vertices, solid.faces)
    fine, drawn = dense(surface, UP, surface)
    assert drawn is not None
    random = np.radians(np.random.default_rng(0).uniform(-39.0, 39.0, (2, 2000)))
    points = 79.0 * np.stack(
        [np.sin(random[0]) * np.cos(random[1]), np.sin(random[1]), np.cos(random[0]) * np.cos(random[1])], axis=1
    )
    whole, parts = (
        nearest_gap(points, mold(one.vertices, one.faces, 1, drawn=of)).nearest
        for one, of in ((surface, None), (fine, drawn))
    )
    assert parts == pytest.approx(whole, abs=5e-3)  # with edges beside creases straight: 0.58, 0.16
