"""The net against closed-form answers: string over a cylinder, flat biaxial stretch, a pressed flat net, a wedge."""

from __future__ import annotations

import numpy as np
import pytest
from cloth_molds import ball, long_cylinder

from hyperfab.cloth import Sheet, answers, drape, mold_of, piecewise_linear, tabulate
from hyperfab.cloth.net import FIXED, Y

RUBBER = tabulate(lambda lam: (0.4 * (lam - lam**-2), 0.4 * (1 + 2 * lam**-3)), 4.0)
LINEAR = piecewise_linear([1.0, 2.0], [0.0, 1.0])


def string_over_cylinder(n: int) -> tuple[float, float, float]:
    """Relative errors of tension and energy, and the tension's spread, on n nodes."""
    a, radius, height = 100.0, 60.0, 20.0
    reach = np.hypot(a, height)
    wrap = np.arctan2(-height, a) + np.arccos(radius / reach)
    exact = (2 * np.sqrt(reach**2 - radius**2) + radius * (np.pi - 2 * wrap)) / (2 * a)
    sheet = Sheet(n, 3, (2 * a, 10.0), 1.0, RUBBER, RUBBER, edges=(FIXED, FIXED, Y, Y))
    mold = mold_of(long_cylinder(radius, 2880), (0.0, 0.0, height))
    found = drape(sheet, mold, 1e-9)
    assert found.converged
    fields = answers(sheet, mold, found)
    energy, tension, _ = (float(v[0]) for v in RUBBER(exact))
    stress = RUBBER(fields.stretch_warp)[1]
    return stress.mean() / tension - 1, found.energy / (energy * 2 * a * 10.0) - 1, np.ptp(stress) / tension


def test_a_string_over_a_cylinder_has_the_exact_tension_to_second_order():
    coarse, fine = string_over_cylinder(51), string_over_cylinder(201)
    assert abs(fine[0]) < 4e-5
    assert abs(fine[2]) < 2e-4
    for error in (0, 1):
        order = np.log(coarse[error] / fine[error]) / np.log(4)
        assert order == pytest.approx(2.0, abs=0.1)


def test_a_flat_sheet_stretched_both_ways_has_uniform_tension_and_the_exact_energy():
    below = mold_of(ball(1), (0.0, 0.0, -200.0))
    sheet = Sheet(21, 31, (80.0, 60.0), 0.5, RUBBER, LINEAR, prestretch=(1.2, 1.1))
    found = drape(sheet, below)
    fields = answers(sheet, below, found)
    assert found.converged
    assert np.allclose(fields.stress_warp, RUBBER(1.2)[1], rtol=1e-12)
    assert np.allclose(fields.stress_weft, 0.1, rtol=1e-12)
    # Energy: that of both threads a volume, times the volume the sheet has before it is mounted.
    volume = 80.0 / 1.2 * 60.0 / 1.1 * 0.5
    assert found.energy == pytest.approx((float(RUBBER(1.2)[0][0]) + 0.5 * 0.1**2) * volume, rel=1e-12)
    # Force: nominal stress times the section before mounting, the width being larger by the stretch across.
    forces = fields.reaction[0].sum(0)
    assert forces[0] == pytest.approx(-float(RUBBER(1.2)[1][0]) * 60.0 / 1.1 * 0.5, rel=1e-12)
    assert fields.cell_thickness == pytest.approx(np.full((20, 30), 0.5 / 1.32), rel=1e-12)


def test_a_strip_pulls_alike_however_wide_it_was_mounted():
    """A strip 50 mm wide before it is mounted, held to 50, 55 and 75 mm: the pull along it is one."""
    below = mold_of(ball(1), (0.0, 0.0, -200.0))
    for across in (1.0, 1.1, 1.5):
        sheet = Sheet(9, 7, (80.0, 50.0 * across), 0.5, RUBBER, LINEAR, prestretch=(1.3, across))
        pull = answers(sheet, below, drape(sheet, below)).reaction[-1, :, 0].sum()
        assert pull == pytest.approx(0.4 * (1.3 - 1.3**-2) * 50.0 * 0.5, rel=1e-8)


def test_a_small_load_sags_a_tense_square_net_as_membrane_theory_says():
    errors = []
    for n in (11, 21, 41):
        below = mold_of(ball(1), (0.0, 0.0, -200.0))
        sheet = Sheet(n, n, (100.0, 100.0), 1.0, LINEAR, LINEAR, prestretch=(1.25, 1.25), mass=1.0)
        found = drape(sheet, below, 1e-9)
        # Mounted 1.25 times as large both ways, the sheet weighs and pulls less a mounted area and width.
        load, tension = 1.0 * 9.80665e-9 / 1.25**2, 0.25 / 1.25
        errors.append(-found.state.x[:, :, 2].min() / (0.0736713 * load * 100.0**2 / tension) - 1)
    assert abs(errors[-1]) < 1e-3
    assert np.log2(errors[-2] / errors[-1]) == pytest.approx(2.0, abs=0.15)


def test_the_pressure_on_a_smooth_dome_is_tension_times_curvature():
    n = 161
    mold = mold_of(ball(6), (0.0, 0.0, 20.0))
    sheet = Sheet(n, n, (200.0, 200.0), 1.0, RUBBER, RUBBER)
    found = drape(sheet, mold)
    fields = answers(sheet, mold, found)
    middle = np.s_[n // 2 - 8 : n // 2 + 9, n // 2 - 8 : n // 2 + 9]
    normal = np.linalg.norm(fields.contact_force[middle], axis=2).sum()
    cells = fields.stretch_warp[middle].mean() * fields.stretch_weft[middle].mean() * (17 * 200 / 160) ** 2
    # Tension per current width: nominal stress times thickness over the stretch across.
    tension = fields.stress_warp[middle].mean() / fields.stretch_weft[middle].mean()
    assert normal / cells == pytest.approx(2 * tension / 60.0, rel=0.02)
