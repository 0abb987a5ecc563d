"""Spring laws: exact derivatives of one another, tabulated to 1e-9, measured curves as they stand."""

from __future__ import annotations

import numpy as np
import pytest

from hyperfab.cloth import piecewise_linear, tabulate
from hyperfab.cloth.law import spring_law
from hyperfab.materials import bind
from hyperfab.materials.orthotropic import Orthotropic
from hyperfab.materials.orthotropic.specimen import Along


def test_a_table_follows_its_law_to_1e_9_of_the_largest_stress():
    def neo_hooke(lam):
        return lam - lam**-2, 1 + 2 * lam**-3

    law = tabulate(neo_hooke, 4.0)
    at = np.linspace(1, 4, 10_001)
    w, p, a = law(at)
    assert np.abs(p - neo_hooke(at)[0]).max() < 1e-9 * p.max()
    assert np.abs(w - (at**2 / 2 + 1 / at - 1.5)).max() < 1e-9
    assert np.allclose(a[1:], neo_hooke(at)[1][1:], atol=1e-6)


@pytest.mark.parametrize(
    "law",
    [spring_law(bind("yeoh-3", {"C10_MPa": 0.06, "C20_MPa": -0.02, "C30_MPa": 0.017})),
     piecewise_linear([1.0, 1.1, 1.4, 2.0], [0.0, 0.1, 0.7, 0.9])],
    ids=["table", "measured"],
)  # fmt: skip
def test_stress_and_slope_are_the_derivatives_of_the_energy(law):
    at = np.linspace(1.001, 2.5, 400)
    at = at[np.abs(at[:, None] - law.knots).min(1) > 1e-5]
    h = 1e-6
    w_plus, p_plus, _ = law(at + h)
    w_minus, p_minus, _ = law(at - h)
    _, p, a = law(at)
    assert np.allclose((w_plus - w_minus) / (2 * h), p, atol=1e-8)
    assert np.allclose((p_plus - p_minus) / (2 * h), a, atol=1e-7)


def test_a_spring_carries_no_compression_and_goes_on_straight_beyond_its_table():
    law = piecewise_linear([1.0, 2.0], [0.0, 3.0])
    assert [float(v[0]) for v in law(0.5)] == [0.0, 0.0, 0.0]
    assert float(law(4.0)[1][0]) == pytest.approx(9.0)


def test_a_law_that_locks_is_cut_before_its_limit():
    law = spring_law(bind("gent", {"mu_MPa": 0.3, "Im": 1.0}))
    assert 1.5 < law.largest_stretch < 2.0
    assert np.isfinite(law(3.0)[1]).all()


def test_a_law_that_softens_says_where_and_goes_on_level():
    assert spring_law(bind("neo-hookean", {"C10_MPa": 0.2})).softens is None
    law = spring_law(bind("yeoh-2", {"C10_MPa": 0.2, "C20_MPa": -0.1}))
    assert 1.3 < law.softens < 1.8
    p = law(np.linspace(1.0, 3.0, 100))[1]
    assert (np.diff(p) >= 0.0).all()
    assert p[-1] == pytest.approx(p.max())


def test_measured_stretches_must_rise():
    with pytest.raises(ValueError, match="rise"):
        piecewise_linear([1.0, 1.2, 1.1], [0.0, 1.0, 2.0])


def test_a_kink_costs_the_pieces_beside_it_alone():
    """Threads that come to bear at a stretch of their own: all 512 pieces were halved for it."""

    def law(lam):
        late = np.maximum(lam - 1.3007, 0.0)
        return lam - lam**-2 + late**2, 1.0 + 2.0 * lam**-3 + 2.0 * late

    table = tabulate(law, 4.0)
    lam = np.linspace(1.0, 4.0, 9973)
    assert np.abs(table(lam)[1] - law(lam)[0]).max() < 1e-9 * law(4.0)[0]
    assert len(table.knots) < 550


def test_a_law_that_locks_is_not_asked_of_what_lies_far_beyond():
    asked = []

    class Locks:
        def uniaxial(self, stretch):
            asked.append(np.max(stretch))
            return bind("gent", {"mu_MPa": 0.2, "Im": 0.5}).uniaxial(stretch)

    with np.errstate(all="ignore"):
        assert spring_law(Locks()).largest_stretch < 1.6
    assert max(asked) < 2.0


@pytest.mark.parametrize("ground", [4e-19, 1.8e-3])
def test_threads_are_part_of_the_stiffness_from_where_tension_begins(ground):
    """Fits of J-shaped strips leave the ground little or none at rest: the sheet was refused for want of stiffness,
    or its warp was taken to lock where it was a thousand times as stiff as the ground, at 1.05."""
    sheet = {"C10_MPa": ground, "C30_MPa": 0.002, "k1_warp_MPa": 0.6, "k2_warp": 2.3, "k1_weft_MPa": 0.1, "G_MPa": 0.1}
    pulled = Along(Orthotropic.of(sheet), 0.0)
    law = spring_law(pulled)
    assert law.largest_stretch > 1.5
    stretch = np.array([1.0005, 1.1, 1.5])
    np.testing.assert_allclose(law(stretch)[1], pulled.uniaxial(stretch).P, rtol=1e-6)
    assert law(1.0 + 1e-9)[2][0] == pytest.approx(4.0 * 0.6, rel=6e-3)
