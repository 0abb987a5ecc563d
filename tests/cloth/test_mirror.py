"""A sheet on a mold that is its own mirror image rests as its own, though ridges lie in the plane between."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
from cloth_molds import block, punch

from hyperfab.cloth import Sheet, answers, drape, follow, mold_of, tabulate
from hyperfab.cloth.balance import Balance
from hyperfab.cloth.dynamic import swing
from hyperfab.cloth.mold import FREE
from hyperfab.cloth.start import lowered, settled
from hyperfab.surface import Surface

SOFT = tabulate(lambda lam: (0.4 * (lam - lam**-2), 0.4 * (1 + 2 * lam**-3)), 4.0)


def cone(sections: int, begin: float, half_angle: float, cut: float = 0.0) -> tuple[Surface, float]:
    """A cone 60 mm in radius and its height, in single precision; its first ridge ``begin`` facets off the x axis.

    Cut flat at the top where its radius is ``cut`` of the foot's; the quadrilaterals below are halved one way round.
    """
    angle, k = 2.0 * np.pi * (np.arange(sections) + begin) / sections, np.arange(sections)
    ring = 60.0 * np.column_stack([np.cos(angle), np.sin(angle), 0.0 * angle])
    height, on = 60.0 / np.tan(np.radians(half_angle)), (k + 1) % sections
    if cut > 0.0:
        height *= 1.0 - cut
        rim = cut * ring + [0.0, 0.0, height]
        points = np.vstack([ring, rim, [[0.0, 0.0, height], [0.0, 0.0, 0.0]]]).astype(np.float32).astype(float)
        low, high, top, foot = k, k + sections, 0 * k + 2 * sections, 0 * k + 2 * sections + 1
        sides = [
            (low, on, on + sections),
            (low, on + sections, high),
            (high, on + sections, top),
            (on, low, foot),
        ]
        return Surface(points, np.vstack([np.column_stack(one) for one in sides])), height
    top, foot = 0 * k + sections, 0 * k + sections + 1
    points = np.vstack([ring, [[0.0, 0.0, height], [0.0, 0.0, 0.0]]]).astype(np.float32).astype(float)
    return Surface(points, np.vstack([np.column_stack([k, on, top]), np.column_stack([on, k, foot])])), height


def unevenness(x):
    return max(np.abs(image - x).max() for image in (x[::-1] * [-1.0, 1.0, 1.0], x[:, ::-1] * [1.0, -1.0, 1.0]))


@pytest.mark.parametrize("begin", [0.0, 0.5])  # ridges in the planes between the halves, or facets
@pytest.mark.parametrize(
    ("sections", "half_angle"),  # ridges turn by 2 to 26 degrees
    [(8, 60.0), (16, 20.0), (16, 45.0), (16, 60.0), (24, 45.0), (64, 20.0), (64, 45.0), (128, 60.0)],
)
def test_a_sheet_on_a_cone_is_its_own_mirror_image(sections, half_angle, begin):
    surface, height = cone(sections, begin, half_angle)
    mold = mold_of(surface, (0.0, 0.0, 0.75 * min(height, 60.0) - height))
    for n in (31, 40, 61):
        sheet = Sheet(n, n, (200.0, 200.0), 1.0, SOFT, SOFT)
        found = drape(sheet, mold, 1e-6)
        assert found.converged, found.status
        assert answers(sheet, mold, found).cut.node <= 1e-9
        assert unevenness(found.state.x) < (1e-6 * sheet.spacing[0] if n % 2 else 1e-3), n


@pytest.mark.parametrize("mold", [punch(32), block()])
def test_nodes_on_edges_of_a_flat_top_stay_where_they_are(mold):
    """Its triangles meet in edges that do not turn: a node on one is on no edge, let alone on the rim beyond."""
    top = mold_of(mold)
    for n in (40, 80):
        sheet = Sheet(n, n, (220.0, 220.0), 1.0, SOFT, SOFT)
        flat = settled(sheet.flat(), top, sheet)
        balance = Balance(sheet, top, 1e-6)
        balance.even(flat)
        assert balance.mirrors == (0, 1)
        assert (flat.contact != FREE).sum() > 10
        np.testing.assert_allclose(flat.x, sheet.flat(), rtol=0.0, atol=1e-9)


def test_a_sheet_rubs_on_a_block():
    sheet = Sheet(30, 30, (220.0, 220.0), 1.0, SOFT, SOFT)
    *_, rest = follow(sheet, mold_of(block()), np.array([10.0, 20.0]), 0.3)
    assert rest.found.converged, rest.found.status
    assert unevenness(rest.found.state.x) < 1e-3


#: Sharp ridges and rims: two ways around an edge or corner alike lead nodes and springs in the plane to either side.
QUICK = [
    (8, 45.0, 0.0, 0.0, 31),
    (8, 20.0, 0.0, 0.0, 40),
    (12, 20.0, 0.0, 0.5, 40),
    (8, 45.0, 0.4, 0.0, 31),
    (12, 20.0, 0.4, 0.0, 31),
    (16, 45.0, 0.4, 0.0, 31),
    (32, 20.0, 0.4, 0.0, 31),
    (8, 60.0, 0.4, 0.0, 40),
]
ALL = list(product((8, 12, 16, 32), (20.0, 45.0, 60.0), (0.0, 0.4), (0.0, 0.5), (31, 40, 61)))


@pytest.mark.parametrize(
    ("sections", "half_angle", "cut", "begin", "n"),
    QUICK + [pytest.param(*one, marks=pytest.mark.slow) for one in ALL if one not in QUICK],
)
def test_so_it_is_on_sharp_ridges_and_rims(sections, half_angle, cut, begin, n):
    surface, height = cone(sections, begin, half_angle, cut)
    mold = mold_of(surface, (0.0, 0.0, 0.75 * min(height, 60.0) - height))
    sheet = Sheet(n, n, (200.0, 200.0), 1.0, SOFT, SOFT)
    found = drape(sheet, mold, 1e-6)
    assert found.converged, found.status
    fields = answers(sheet, mold, found)
    assert fields.cut.node <= 1e-9
    assert fields.imbalance < 1e-3 * fields.press_force
    assert unevenness(found.state.x) < (1e-6 * sheet.spacing[0] if n % 2 else 1e-3)


@pytest.mark.parametrize(
    ("sections", "cut", "n"),
    [
        (8, 0.0, 21),
        (16, 0.0, 21),
        (8, 0.4, 21),
        *(
            pytest.param(*one, marks=pytest.mark.slow)
            for one in ((8, 0.0, 41), (16, 0.0, 41), (16, 0.4, 41), (64, 0.0, 41))
        ),
    ],
)
def test_so_it_is_by_dynamic_relaxation(sections, cut, n):
    surface, height = cone(sections, 0.0, 45.0, cut)
    mold = mold_of(surface, (0.0, 0.0, 0.75 * height - height))
    sheet = Sheet(n, n, (200.0, 200.0), 1.0, SOFT, SOFT)
    found = swing(sheet, mold, lowered(sheet, mold), 1e-6)
    assert found.converged, found.status
    assert unevenness(found.state.x) < 1e-6 * sheet.spacing[0]


@pytest.mark.slow  # it swings 6 000 steps first
def test_a_sheet_that_swings_and_finds_no_even_rest_may_lean():
    surface, height = cone(8, 0.0, 20.0, 0.4)
    mold = mold_of(surface, (0.0, 0.0, 0.75 * min(height, 60.0) - height))
    sheet = Sheet(21, 21, (200.0, 200.0), 1.0, SOFT, SOFT)
    found = swing(sheet, mold, lowered(sheet, mold), 1e-6)
    assert found.converged, found.status


def test_what_is_not_even_stays_so_and_its_mirror_image_rests_as_its_own():
    surface, height = cone(17, 0.3, 45.0)
    turned = Surface(surface.vertices * [-1.0, 1.0, 1.0], surface.faces[:, ::-1])
    sheet = Sheet(41, 41, (200.0, 200.0), 1.0, SOFT, SOFT)
    one, two = (
        drape(sheet, mold_of(mold, (side * 3.0, 0.0, 45.0 - height)), 1e-8)
        for mold, side in ((surface, 1.0), (turned, -1.0))
    )
    assert one.converged
    assert two.converged
    assert unevenness(one.state.x) > 1.0
    assert one.energy == pytest.approx(two.energy, rel=1e-5)
