"""The relaxed energy of a law of any symmetry: least over all wrinkles, and its derivatives."""

from __future__ import annotations

import numpy as np
import pytest

from hyperfab.materials import bind
from hyperfab.materials.orthotropic import Orthotropic
from hyperfab.materials.orthotropic.energy import Answer
from hyperfab.membrane.orthotropic import orthotropic_sheet
from hyperfab.membrane.relaxed import RelaxedSheet, Unrelaxed
from hyperfab.membrane.tension_field import SLACK, TAUT, WRINKLED, IsotropicSheet

KNIT = Orthotropic.of(
    {
        "C10_MPa": 0.02, "C20_MPa": 0.003, "k1_warp_MPa": 0.2, "k1_weft_MPa": 0.1, "k1_bias_MPa": 0.15, "G_MPa": 0.03,
        "nu": 0.3, "k2_warp": 0.5, "k2_weft": 0.2, "k2_bias": 0.7, "bias_deg": 35.0,
    }
)  # fmt: skip


def _strains(count: int = 150) -> np.ndarray:
    F = np.eye(2) + np.random.default_rng(1).normal(0.0, 0.3, (count, 2, 2))
    C = np.einsum("nki,nkj->nij", F, F)
    C = np.stack([C[:, 0, 0], C[:, 1, 1], C[:, 0, 1]], axis=1)
    return C[C[:, 0] * C[:, 1] - C[:, 2] ** 2 > 0.05]


def test_an_isotropic_law_is_relaxed_as_its_closed_form_says():
    strain = _strains()
    closed = IsotropicSheet(bind("yeoh-2", {"C10_MPa": 0.1, "C20_MPa": 0.02}))
    own = RelaxedSheet(Orthotropic.of({"C10_MPa": 0.1, "C20_MPa": 0.02}))
    one, two = closed(strain), own(strain)
    assert set(two.state) == {TAUT, WRINKLED, SLACK}
    assert (one.state == two.state).all()
    np.testing.assert_allclose(two.energy, one.energy, atol=1e-13)
    np.testing.assert_allclose(two.stress, one.stress, atol=1e-11 * np.abs(one.stress).max())
    np.testing.assert_allclose(two.stiffness, one.stiffness, atol=1e-9 * np.abs(one.stiffness).max())
    np.testing.assert_allclose(own.principal(strain).cauchy, closed.principal(strain).cauchy, atol=1e-11)
    assert (np.sign(own.margin(strain)) == np.sign(closed.margin(strain))).all()


def test_wrinkles_take_the_least_energy_of_all():
    """Against every wrinkle of a fine grid of directions and depths."""
    strain = _strains()
    found = RelaxedSheet(KNIT)(strain)
    depth, angle = np.meshgrid(np.linspace(0.0, 1.5, 301), np.pi * np.arange(240) / 240)
    dyads = np.stack([np.cos(angle) ** 2, np.sin(angle) ** 2, np.cos(angle) * np.sin(angle)], axis=-1)
    wrinkles = (depth[..., None] * dyads).reshape(-1, 3)
    for number in np.flatnonzero(found.state == WRINKLED)[:25]:
        least = KNIT.answer(strain[number] + wrinkles).energy.min()
        assert found.energy[number] <= least * (1.0 + 1e-9)
        # The grid misses the least by its spacing squared.
        assert found.energy[number] == pytest.approx(least, rel=5e-3, abs=1e-5)


def test_a_law_that_falls_without_end_has_no_answer_where_it_does():
    """Two laws that are stable in uniaxial tension alone: pulled, their mixture would widen for ever."""
    weft = bind("mooney-rivlin-2", {"C10_MPa": 0.6345708, "C01_MPa": -0.6155526})
    sheet = orthotropic_sheet(bind("mooney-rivlin-2", {"C10_MPa": 0.68, "C01_MPa": 0.63}), weft)
    far = np.array([[1672.6, 1704.0, 1586.6], [101.4, 164.4, 128.7]])
    found = sheet(np.vstack([far, [[1.02, 0.99, 0.0]]]))
    assert np.isnan(found.energy[:2]).all()
    assert np.isnan(found.stress[:2]).all()
    assert 0.0 < found.energy[2] < 1e-3


class Asked:
    """A law that counts the strains it is asked at."""

    def __init__(self, law: Unrelaxed = KNIT) -> None:
        self.law, self.strains = law, 0

    def answer(self, strain: np.ndarray) -> Answer:
        self.strains += len(strain)
        return self.law.answer(strain)

    def thickness_stretch(self, strain: np.ndarray) -> np.ndarray:
        return self.law.thickness_stretch(strain)


def test_a_law_without_a_least_energy_is_not_sought_through_for_it():
    """Powers as they are drawn where the tests do not tell them; a sheet of them took two minutes, for nothing."""
    names = ("mu1_MPa", "alpha1", "mu2_MPa", "alpha2")
    warp = bind("ogden-2", dict(zip(names, (0.3234, 2.339, 3.611e-05, -444.45), strict=True)))
    weft = bind("ogden-2", dict(zip(names, (0.08281, 1.7727, -0.0053415, -30.0), strict=True)))
    sheet = orthotropic_sheet(warp, weft)
    assert isinstance(sheet, RelaxedSheet)
    law = Asked(sheet.law)
    found = RelaxedSheet(law)(np.array([[1.02908376, 1.00012855, 0.01380103]] * 100))
    assert law.strains < 100 * 50
    assert np.isnan(found.energy).all()


@pytest.mark.parametrize("size", [1e-2, 1e-4, 1e-6, 1e-8])
def test_a_sheet_that_is_nearly_at_rest_is_relaxed_as_any_other(size: float) -> None:
    """Its stress goes with its strain, as far as the law bends; a minimum that rounding hid was sought all round."""
    strain = np.random.default_rng(2).normal(0.0, 1.0, (300, 3))
    law = Asked()
    found = RelaxedSheet(law)(np.array([1.0, 1.0, 0.0]) + size * strain)
    assert set(found.state) == {TAUT, WRINKLED, SLACK}
    assert law.strains < 10 * len(strain)
    nearer = RelaxedSheet(KNIT)(np.array([1.0, 1.0, 0.0]) + 0.1 * size * strain)
    off = np.abs(10.0 * nearer.stress - found.stress).max() / np.abs(found.stress).max()
    # To first order in the strain, and to the rounding of 1 + strain.
    assert off < 1.0 * size + 1e-14 / size


def test_no_direction_is_pressed_and_stress_and_stiffness_are_derivatives():
    strain = _strains()
    law = RelaxedSheet(KNIT)
    found = law(strain)
    S = found.stress
    least = 0.5 * (S[:, 0] + S[:, 1]) - np.hypot(0.5 * (S[:, 0] - S[:, 1]), S[:, 2])
    assert least.min() > -1e-10 * np.abs(S).max()
    columns = ((0, 3, 4), (3, 1, 5), (4, 5, 2))
    # Where threads are stretched so far that a step of 1e-6 is no small one, differences say nothing.
    mild = np.abs(found.stiffness).max(axis=1) < 1e3
    for k, twice in enumerate((2.0, 2.0, 1.0)):
        step = np.zeros(3)
        step[k] = 1e-6
        up, down = law(strain + step), law(strain - step)
        same = mild & (up.state == down.state) & (up.state == found.state)
        size = np.abs(found.stiffness[same]).max()
        slope = twice * (up.energy - down.energy)[same] / 2e-6
        np.testing.assert_allclose(slope, S[same, k], atol=1e-7 * size)
        bend = twice * (up.stress - down.stress)[same] / 2e-6
        np.testing.assert_allclose(bend, found.stiffness[same][:, columns[k]], atol=1e-6 * size)


def test_the_nominal_stress_is_that_of_the_larger_pull_on_the_section_before():
    """P = F S by its singular values; of an isotropic law the same from its principal axes, wrinkled and slack too."""
    random = np.random.default_rng(7)
    F = np.eye(2) + 0.3 * random.uniform(-1.0, 1.0, (40, 2, 2))
    C = np.einsum("nki,nkj->nij", F, F)
    strain = np.stack([C[:, 0, 0], C[:, 1, 1], C[:, 0, 1]], axis=1)
    material = bind("yeoh-3", {"C10_MPa": 0.1, "C20_MPa": 0.02, "C30_MPa": 0.004})
    own = IsotropicSheet(material)
    state = own(strain).state
    assert set(state) == {0, 1, 2}
    S = own(strain).stress[:, [[0, 2], [2, 1]]]
    expected = np.linalg.svd(F @ S, compute_uv=False)[:, 0]
    ground = RelaxedSheet(Orthotropic.of(material.parameters))
    np.testing.assert_allclose(own.principal(strain).nominal, expected, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(ground.principal(strain).nominal, expected, rtol=1e-6, atol=1e-9)


def test_a_sheet_at_rest_is_not_searched_for_wrinkles(monkeypatch):
    # Rounding leaves strains of 1e-16 either way: no wrinkle is in them, and looking for one took most of a run.
    strain = np.array([1.0, 1.0, 0.0]) + np.random.default_rng(3).uniform(-1e-15, 1e-15, (500, 3))
    monkeypatch.setattr(RelaxedSheet, "_wrinkle", None)
    found = RelaxedSheet(KNIT)(strain)
    assert WRINKLED not in found.state
    assert np.abs(found.stress).max() < 1e-14
    assert np.abs(found.energy).max() < 1e-16


def test_wrinkles_of_a_stiff_warp_are_found_from_the_first_guess():
    """The kink where threads take up the load turns the wrinkles far; a shortened step must still go downhill."""
    warp, weft = (bind("yeoh-2", {"C10_MPa": c, "C20_MPa": 0.1 * c}) for c in (1.0, 0.1))
    sheet = orthotropic_sheet(warp, weft)
    C = np.array([[0.99872, 0.9672, 0.09183], [0.99924, 0.99399, 0.01633], [0.99375, 1.00007, 0.05055]])
    own = sheet.law.answer(C)
    along = 0.5 * np.arctan2(2.0 * own.stress[:, 2], own.stress[:, 0] - own.stress[:, 1])
    _, _, closed = sheet._minimum(C, along + 0.5 * np.pi, own)
    assert closed.all()
    width, angle = np.meshgrid(np.linspace(0.0, 0.15, 151), np.linspace(0.0, np.pi, 181))
    c, s = np.cos(angle.ravel()), np.sin(angle.ravel())
    for strain, energy in zip(C, own.energy, strict=True):
        tried = strain + width.ravel()[:, None] * np.stack([c * c, s * s, c * s], axis=1)
        assert energy <= np.nanmin(sheet.law.answer(tried).energy) < 1.01 * energy
