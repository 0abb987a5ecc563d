"""Friction on the mold and under the blank holder against closed forms, and the energy it takes."""

from __future__ import annotations

import numpy as np
import pytest
from cloth_molds import ball, long_cylinder
from scipy.optimize import brentq

from hyperfab.cloth import Sheet, answers, drape, follow, mold_of, raised, tabulate
from hyperfab.cloth.net import FIXED, X, Y, Z
from hyperfab.cloth.path import clamped
from hyperfab.surface import Surface

RUBBER = tabulate(lambda lam: (0.4 * (lam - lam**-2), 0.4 * (1 + 2 * lam**-3)), 4.0)
REACH, RADIUS, HEIGHT = 100.0, 60.0, 20.0  # clamps at +-REACH, centre of the cylinder at HEIGHT at the end
STRETCHES = np.linspace(1.0, 4.0, 20001)
TENSIONS = RUBBER(STRETCHES)[1]


def wrap(reach: float = REACH) -> tuple[float, float]:
    """Angle from the apex to where a string from ``reach`` meets the cylinder, and its free length."""
    d = np.hypot(reach, HEIGHT)
    return np.pi / 2 - np.arctan2(-HEIGHT, reach) - np.arccos(RADIUS / d), np.sqrt(d**2 - RADIUS**2)


def capstan(mu: float) -> float:
    """Tension per section of the free part where the string slips everywhere: T = T_free exp(-mu angle)."""
    angle, free = wrap()
    at = np.linspace(0.0, angle, 4001)

    def missing(tension: float) -> float:
        along = RADIUS / np.interp(tension * np.exp(-mu * (angle - at)), TENSIONS, STRETCHES)
        return free / np.interp(tension, TENSIONS, STRETCHES) + np.trapezoid(along, at) - REACH

    return float(brentq(missing, 1e-6, 0.9 * TENSIONS[-1]))


def pushed(n: int, mu: float, steps: int = 10, sections: int = 11520, **sheet):
    """The string at the end of the way, and the mold there."""
    sheet = {"edges": (FIXED, FIXED, Y, Y), **sheet}
    strip = Sheet(n, 3, (2 * REACH, 10.0), 1.0, RUBBER, RUBBER, **sheet)
    mold = mold_of(long_cylinder(RADIUS, sections), (0.0, 0.0, -RADIUS))
    *_, rest = follow(strip, mold, np.linspace(0.0, HEIGHT + RADIUS, steps + 1)[1:], mu)
    assert rest.found.converged
    return rest, answers(strip, raised(mold, rest.height), rest.found)


def capstan_errors(n: int, mu: float) -> tuple[float, float]:
    """Relative errors of the free part's tension and of the one at the apex."""
    rest, fields = pushed(n, mu)
    stress = RUBBER(fields.stretch_warp)[1][:, 1]
    middle = n // 2
    along = rest.found.state.x[middle + 1, 1] - rest.found.state.x[middle, 1]
    exact = capstan(mu)
    beside = np.arctan2(-along[2], along[0])  # how far from the apex the middle of that spring is
    return stress[0] / exact - 1, stress[middle] / (exact * np.exp(-mu * (wrap()[0] - beside))) - 1


@pytest.mark.slow
def test_a_string_slipping_over_a_cylinder_loses_tension_as_the_capstan_law_says_to_second_order():
    coarse, fine = capstan_errors(51, 0.3), capstan_errors(201, 0.3)
    assert abs(fine[0]) < 5e-5
    assert abs(fine[1]) < 5e-5
    assert np.log(coarse[0] / fine[0]) / np.log(4) == pytest.approx(2.0, abs=0.2)


@pytest.mark.parametrize("mu", [pytest.param(0.01, marks=pytest.mark.slow), 1.0])
def test_the_capstan_law_holds_from_little_to_much_friction(mu):
    assert np.abs(capstan_errors(101, mu)).max() < 3e-4


@pytest.mark.slow
def test_the_press_does_the_work_that_is_stored_and_rubbed_away():
    balances = []
    for steps in (10, 20):
        rest, _ = pushed(51, 0.3, steps, 2880)
        balances.append((rest.work - rest.rubbed) / rest.found.energy - 1)
        assert rest.rubbed > 0.02 * rest.found.energy
    assert balances[1] < 2e-3
    assert balances[0] / balances[1] == pytest.approx(4.0, abs=0.6)  # second order in the step


@pytest.mark.slow
def test_an_edge_under_a_blank_holder_is_drawn_in_until_its_pull_is_the_holders_force():
    def stretch(reach: float) -> float:
        angle, free = wrap(reach)
        return float((free + RADIUS * angle) / REACH)

    def pull(reach: float) -> float:
        return float(RUBBER(stretch(reach))[1][0] * np.cos(wrap(reach)[0]))

    for force in (0.1, 0.18):
        reach = brentq(lambda r, f=force: pull(r) - f, RADIUS + 5.0, REACH)
        rest, fields = pushed(101, 0.0, 10, 2880, edges=(Z, Z, Y, Y), holder=(force, force, 0.0, 0.0))
        x = rest.found.state.x[:, 1, 0]
        assert 0.5 * (x[-1] - x[0]) == pytest.approx(reach, abs=0.02)
        assert np.allclose(fields.stretch_warp, stretch(reach), rtol=2e-4)
        assert fields.imbalance < 1e-5
        assert rest.drawn == pytest.approx(10.0 * force * (2 * REACH - x[-1] + x[0]), rel=1e-3)
        assert rest.work - rest.drawn == pytest.approx(rest.found.energy, rel=0.02)
    clamped = Sheet(101, 3, (2 * REACH, 10.0), 1.0, RUBBER, RUBBER, edges=(FIXED, FIXED, Y, Y))
    mold = mold_of(long_cylinder(RADIUS, 2880), (0.0, 0.0, HEIGHT))
    rest, _ = pushed(101, 0.0, 10, 2880, edges=(Z, Z, Y, Y), holder=(0.3, 0.3, 0.0, 0.0))
    assert rest.drawn == 0.0
    assert rest.found.energy == pytest.approx(drape(clamped, mold).energy, rel=1e-8)


def test_friction_on_a_ball_costs_force_and_no_node_goes_in():
    mold = mold_of(ball(6), (0.0, 0.0, -60.0))
    sheet = Sheet(31, 31, (200.0, 200.0), 1.0, RUBBER, RUBBER)
    force = {}
    for mu in (0.0, 0.3):
        *_, rest = follow(sheet, mold, np.linspace(0.0, 80.0, 11)[1:], mu)
        fields = answers(sheet, raised(mold, 80.0), rest.found)
        force[mu] = fields.press_force
        assert rest.found.converged
        assert fields.cut.node <= 1e-9
        assert fields.imbalance < 1e-4
        touching = rest.found.state.contact != 0
        normal = (rest.found.state.x - [0.0, 0.0, 20.0])[touching] / 60.0
        pushed_by = fields.contact_force[touching]
        across = (pushed_by * normal).sum(1)
        along = np.linalg.norm(pushed_by - across[:, None] * normal, axis=1)
        assert (along <= (mu + 0.06) * across + 1e-6).all()  # 0.06: the tilt of the facets
    assert force[0.3] > 1.05 * force[0.0]
    # Nodes may rest in one facet or the next: where facets are twice as long, forces differ by 3e-4.
    straight = drape(sheet, raised(mold, 80.0))
    assert force[0.0] == pytest.approx(answers(sheet, raised(mold, 80.0), straight).press_force, rel=1e-4)


def hill(cells: int) -> Surface:
    """A hill without any symmetry in facets some of which meet in valleys, its top at 0."""
    u, v = (np.linspace(-h, h, k) for h, k in ((75.0, cells + 1), (65.0, cells + 1)))
    x, y = np.meshgrid(u, v, indexing="ij")
    z = 50.0 * np.exp(-(((x - 8.0) / 48.0) ** 2) - ((y + 0.3 * x) / 42.0) ** 2)
    k = np.arange((cells + 1) ** 2).reshape(cells + 1, cells + 1)
    a, b, c, d = k[:-1, :-1].ravel(), k[1:, :-1].ravel(), k[1:, 1:].ravel(), k[:-1, 1:].ravel()
    corners = np.stack([x, y, z - z.max()], axis=-1).reshape(-1, 3)
    return Surface(corners, np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)]))


@pytest.mark.parametrize("mu", [0.05, 0.25, 0.9])
@pytest.mark.parametrize("steps", [10, 20])
def test_a_sheet_rubs_its_way_down_a_hill_whose_facets_meet_in_valleys(mu, steps):
    # Rubbing, a node may be pushed into a valley from both sides where the springs alone lead it through; and where the
    # normal force answers strongly to the place, whole steps overshoot.
    mold = mold_of(hill(80))
    sheet = Sheet(31, 27, (200.0, 170.0), 0.8, RUBBER, RUBBER)
    *_, rest = follow(sheet, mold, np.linspace(0.0, 45.0, steps + 1)[1:], mu)
    assert rest.height == pytest.approx(45.0)
    assert rest.found.converged
    # What the press does is stored or rubbed away: the trapezoid over a step is good to second order.
    assert rest.work - rest.rubbed == pytest.approx(rest.found.energy, rel=0.03)


def test_a_net_comes_to_rest_in_the_valleys_of_a_hill_within_the_steps_of_newton():
    found = drape(Sheet(31, 27, (200.0, 170.0), 0.8, RUBBER, RUBBER), raised(mold_of(hill(80)), 45.0))
    assert found.converged
    assert len(found.history) < 60


def test_the_edges_under_a_blank_holder_are_clamped_and_no_others():
    for held in range(4):
        edges, holder = [Z, Y, X, FIXED], [0.0] * 4
        holder[held] = 0.1
        sheet = clamped(Sheet(5, 5, (10.0, 10.0), 1.0, RUBBER, RUBBER, edges=tuple(edges), holder=tuple(holder)))
        edges[held] = FIXED
        assert sheet.edges == tuple(edges)
        assert sheet.holder == (0.0, 0.0, 0.0, 0.0)
