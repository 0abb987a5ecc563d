"""Laws that hold at any equilibrium of the net on a mold."""

from __future__ import annotations

import numpy as np
import pytest
from cloth_molds import ball, height_block

from hyperfab.cloth import HeldNodeInside, Sheet, answers, drape, mold_of, tabulate
from hyperfab.cloth.net import FIXED, Y, Z
from hyperfab.cloth.newton import equilibrium
from hyperfab.cloth.start import lowered, refined, settled

SOFT = tabulate(lambda lam: (0.4 * (lam - lam**-2), 0.4 * (1 + 2 * lam**-3)), 4.0)
STIFF = tabulate(lambda lam: (1.0 * (lam - lam**-2), 1.0 * (1 + 2 * lam**-3)), 4.0)
BALL = ball(5)


def model_sheet(n: int, warp=SOFT, weft=SOFT) -> Sheet:
    return Sheet(n, n, (200.0, 200.0), 1.0, warp, weft)


@pytest.fixture(scope="module")
def mold():
    return mold_of(BALL, (0.0, 0.0, 20.0))


@pytest.fixture(scope="module")
def found(mold):
    return drape(model_sheet(81), mold)


def test_no_node_feels_a_force_it_can_follow_and_none_is_inside(mold, found):
    assert found.converged
    assert found.residual_relative <= 1e-6
    fields = answers(model_sheet(81), mold, found)
    assert fields.cut.node <= 1e-9
    distance = BALL.nearest(found.state.x.reshape(-1, 3) - [0, 0, 20.0]).distance
    assert distance.min() >= -1e-9
    assert np.abs(distance[(found.state.contact != 0).ravel()]).max() <= 1e-9
    assert (
        fields.contact_force[found.state.contact != 0] * (found.state.x - [0, 0, 20.0])[found.state.contact != 0]
    ).sum(1).min() >= 0


def test_clamps_and_mold_balance(mold):
    sheet = model_sheet(61)
    exact = drape(sheet, mold, 1e-11)
    assert exact.converged
    assert answers(sheet, mold, exact).imbalance <= 1e-9


def test_the_energy_grows_by_the_press_force_times_the_way(mold):
    sheet, h = model_sheet(61), 1e-3
    rest = drape(sheet, mold, 1e-10)
    energies = []
    for way in (-h, h):  # from the rest position moved with the mold, so that no node changes its facet
        moved = mold_of(BALL, (0.0, 0.0, 20.0 + way))
        x = rest.state.x + np.where(rest.state.contact != 0, way, 0.0)[:, :, None] * [0.0, 0.0, 1.0]
        energies.append(equilibrium(sheet, moved, settled(x, moved, sheet, np.full((61, 61), 1e-6)), 1e-10).energy)
    force = answers(sheet, mold, rest).press_force
    assert (energies[1] - energies[0]) / (2 * h) == pytest.approx(force, rel=1e-6)


def test_three_starts_end_in_the_same_energy(mold, found):
    sheet = model_sheet(81)
    direct = equilibrium(sheet, mold, lowered(sheet, mold))
    i, j = np.mgrid[:81, :81] / 80.0
    tent = sheet.flat()
    tent[:, :, 2] = 95.0 * np.minimum(1.0, 6 * np.minimum(np.minimum(i, 1 - i), np.minimum(j, 1 - j)))
    tent[1:-1, 1:-1] += 0.4 * np.sin(37.0 * np.arange(79 * 79 * 3)).reshape(79, 79, 3)
    high = equilibrium(sheet, mold, settled(tent, mold, sheet))
    assert direct.converged
    assert high.converged
    assert direct.energy == pytest.approx(found.energy, rel=1e-8)
    assert high.energy == pytest.approx(found.energy, rel=1e-8)


def test_the_energy_never_rises_while_the_contact_set_stays(found):
    for before, after in zip(found.history, found.history[1:], strict=False):
        if after.nodes == before.nodes:
            assert after.energy <= before.energy * (1 + 1e-13)


def test_equal_laws_give_the_symmetry_of_the_square_and_swapped_laws_the_transpose():
    # The ball's facets mirror in x and y but do not turn; several rest positions within a facet exist.
    smooth = mold_of(ball(6), (0.0, 0.0, 20.0))
    one = drape(model_sheet(41, SOFT, STIFF), smooth, 1e-8)
    two = drape(model_sheet(41, STIFF, SOFT), smooth, 1e-8)
    z, zt = one.state.x[:, :, 2], two.state.x[:, :, 2].T
    assert np.abs(z - zt).max() < 0.05
    assert one.energy == pytest.approx(two.energy, rel=1e-4)
    same = drape(model_sheet(41), smooth, 1e-8).state.x[:, :, 2]
    for mirrored in (same[::-1], same[:, ::-1], same.T):
        assert np.abs(same - mirrored).max() < 0.05


def test_the_energy_converges_to_second_order():
    fine = mold_of(ball(6), (0.0, 0.0, 20.0))
    e = [drape(model_sheet(n), fine).energy for n in (26, 51, 101)]
    assert (e[1] - e[0]) / (e[2] - e[1]) == pytest.approx(4.0, abs=0.8)


def test_at_depth_zero_nothing_is_stretched():
    sheet = model_sheet(21)
    touching = mold_of(BALL, (0.0, 0.0, -60.0))
    found = drape(sheet, touching)
    assert found.converged
    assert found.energy < 1e-20
    assert abs(answers(sheet, touching, found).press_force) < 1e-12


def test_a_clamp_inside_the_mold_is_refused_with_its_place():
    sheet = Sheet(21, 21, (80.0, 80.0), 1.0, SOFT, SOFT)
    with pytest.raises(HeldNodeInside, match="mm inside the mold"):
        drape(sheet, mold_of(BALL, (0.0, 0.0, 20.0)))


def test_a_sliding_edge_inside_the_mold_is_refused_too():
    """It is held at its height, where the mold is: it could only be set onto the mold by leaving that."""
    sheet = Sheet(21, 21, (200.0, 30.0), 1.0, SOFT, SOFT, edges=(FIXED, FIXED, Y | Z, Y | Z))
    with pytest.raises(HeldNodeInside, match="mm inside the mold"):
        drape(sheet, mold_of(BALL, (0.0, 0.0, 20.0)))


@pytest.mark.parametrize(
    ("depth", "options"),
    [(39.9, {"prestretch": (0.97, 0.99)}), (40.1, {"edges": (FIXED, FIXED, 0, 0)})],
)
def test_a_hill_whose_facets_meet_in_valleys_is_met_to_the_last_digit(depth, options):
    """A skew hill is convex, its quads cut along one diagonal are not: nodes rest in valleys between two facets."""

    def hill(u, v):
        return 50.0 * np.exp(-(((u - 8.0) / 48.0) ** 2) - ((v + 0.3 * u) / 42.0) ** 2)

    surface = height_block(hill, (75.0, 65.0), (150, 130), -20.0)
    weft = tabulate(lambda lam: (0.24 * (lam - lam**-2), 0.24 * (1 + 2 * lam**-3)), 4.0)
    sheet = Sheet(31, 27, (200.0, 170.0), 0.8, SOFT, weft, **options)
    found = drape(sheet, mold_of(surface, (0.0, 0.0, depth - surface.vertices[:, 2].max())), 1e-9)
    assert found.converged, found.status


def test_a_large_sheet_is_placed_by_the_same_compiled_kernel_as_a_small_one(mold, monkeypatch):
    # From 512 nodes a side numpy keeps the order of what it computes with: another order is another kernel.
    orders = []

    def noted(*arguments):
        orders.append([one.flags.c_contiguous for one in arguments if isinstance(one, np.ndarray)])
        return -1, 0.0

    for n in (40, 600):
        coarse = lowered(model_sheet(n // 2), mold)
        with monkeypatch.context() as patched:
            patched.setattr("hyperfab.cloth.start.place", noted)
            refined(coarse, model_sheet(n), mold)
    assert orders
    assert all(all(one) for one in orders)
