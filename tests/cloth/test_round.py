"""A round sheet: exact states on skewed cells, derivatives, a turned fabric, published loads, every mold, markers."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from cloth_checks import derivatives_hold
from cloth_molds import ball, block, punch, saddle, under

from hyperfab.arrays import Array
from hyperfab.cloth import Answers, Equilibrium, Mold, Sheet, answers, drape, mold_of, raised
from hyperfab.cloth.law import spring_law
from hyperfab.cloth.membrane import MembraneLaw
from hyperfab.cloth.path import follow, load_steps
from hyperfab.cloth.round import rounded, squared
from hyperfab.loop.drape import at_markers
from hyperfab.materials import bind
from hyperfab.materials.orthotropic import Orthotropic
from hyperfab.membrane.relaxed import RelaxedSheet
from hyperfab.membrane.tension_field import IsotropicSheet

RUBBER = bind("neo-hookean", {"C10_MPa": 0.2})
YEOH = bind("yeoh-3", {"C10_MPa": 0.18, "C20_MPa": -0.004, "C30_MPa": 0.0008})
THREADS = spring_law(RUBBER)
FABRIC = RelaxedSheet(
    Orthotropic.of(
        {"C10_MPa": 0.15, "C20_MPa": 0.01, "k1_warp_MPa": 0.4, "k2_warp": 0.3, "k1_weft_MPa": 0.1, "k1_bias_MPa": 0.1,
         "bias_deg": 30.0, "G_MPa": 0.03}
    )
)  # fmt: skip
FAR = mold_of(ball(1), (0.0, 0.0, -500.0))


def disc(n: int, m: int, law: MembraneLaw, size: tuple[float, float] = (200.0, 200.0), **options: Any) -> Sheet:
    return Sheet(n, m, size, 1.0, THREADS, THREADS, membrane=law, round=True, **options)


def rests(sheet: Sheet, mold: Mold, tolerance: float = 1e-6) -> tuple[Equilibrium, Answers]:
    found = drape(sheet, mold, tolerance)
    said = answers(sheet, mold, found)
    assert found.converged, found.status
    assert found.residual_relative <= tolerance
    assert said.cut.node < 1e-9
    return found, said


@dataclass(frozen=True)
class Turned:
    """A law whose fabric lies turned by ``angle``: strains turned back to it, its answer turned forth."""

    law: MembraneLaw
    angle: float

    @property
    def _turn(self) -> Array:
        c, s = np.cos(self.angle), np.sin(self.angle)
        return np.array([[c * c, s * s, 2 * c * s], [s * s, c * c, -2 * c * s], [-c * s, c * s, c * c - s * s]])

    def __call__(self, strain: Array) -> Any:
        turn = self._turn
        back = np.array([[1, 1, 0.5], [1, 1, 0.5], [2, 2, 1]]) * turn  # of strains, their shear counted twice
        found = self.law(strain @ turn.T)
        d11, d22, d33, d12, d13, d23 = found.stiffness.T
        full = np.array([[d11, d12, d13], [d12, d22, d23], [d13, d23, d33]])
        of = np.einsum("pa,pqk,qb->kab", back, full, back)
        pick = np.array([[0, 0], [1, 1], [2, 2], [0, 1], [0, 2], [1, 2]])
        return SimpleNamespace(
            energy=found.energy,
            stress=found.stress @ back,
            stiffness=of[:, pick[:, 0], pick[:, 1]],
            state=found.state,
        )

    def principal(self, strain: Array) -> Any:
        return self.law.principal(strain @ self._turn.T)

    def margin(self, strain: Array) -> Array:
        return self.law.margin(strain @ self._turn.T)


def test_the_mapping_and_its_inverse_undo_each_other_and_lay_the_rim_on_the_circle():
    u, v = np.meshgrid(np.linspace(-1, 1, 21), np.linspace(-1, 1, 17), indexing="ij")
    x, y = rounded(u, v)
    assert np.allclose(squared(x, y), (u, v), atol=1e-7)
    rim = (np.abs(u) == 1) | (np.abs(v) == 1)
    assert np.hypot(x, y)[rim] == pytest.approx(1.0, rel=1e-14)
    assert (np.hypot(x, y)[~rim] < 1.0).all()


@pytest.mark.parametrize("law", [IsotropicSheet(YEOH), FABRIC], ids=["isotropic", "orthotropic"])
def test_forces_are_the_gradient_of_the_energy_and_the_tangent_theirs(law):
    derivatives_hold(disc(7, 6, law, (60.0, 40.0), prestretch=(1.1, 0.9), mass=500.0), FAR)


@pytest.mark.parametrize("law", [IsotropicSheet(YEOH), FABRIC], ids=["isotropic", "orthotropic"])
def test_a_disc_stretched_both_ways_has_the_exact_stress_energy_and_weight_in_every_skewed_cell(law):
    sheet = disc(13, 9, law, (80.0, 60.0), prestretch=(1.3, 1.1), mass=180.0)
    found, said = rests(replace(sheet, mass=0.0), FAR, 1e-11)
    strain = np.array([[1.69, 1.21, 0.0]])
    s11, s22, _ = law(strain).stress[0]
    assert said.stress_warp == pytest.approx(np.full((13, 9), 1.3 * s11), rel=1e-9)
    assert said.stress_weft == pytest.approx(np.full((13, 9), 1.1 * s22), rel=1e-9)
    assert said.stretch_warp == pytest.approx(np.full((12, 8), 1.3), rel=1e-9)
    assert said.cell_shear == pytest.approx(np.zeros((12, 8)), abs=1e-7)
    assert said.cell_thickness == pytest.approx(np.full((12, 8), 1.0 / 1.43), rel=1e-9)
    rim = np.concatenate([sheet.flat()[s] for s in (np.s_[:-1, 0], np.s_[-1, :-1], np.s_[:0:-1, -1], np.s_[0, :0:-1])])
    area = 0.5 * abs(np.sum(rim[:, 0] * np.roll(rim[:, 1], -1) - rim[:, 1] * np.roll(rim[:, 0], -1))) / 1.43
    assert found.energy == pytest.approx(float(law(strain).energy[0]) * area, rel=1e-12)
    assert sheet.arrays.weight.sum() == pytest.approx(area * 180.0 * 9.80665e-9, rel=1e-12)
    assert sheet.areas.sum() * sheet.rest.prod() == pytest.approx(area, rel=1e-12)


@cache
def sphere() -> Mold:
    """A ball of radius 40 mm as 328 000 facets, its top at z = 0."""
    return mold_of(ball(7, 40.0), (0.0, 0.0, -40.0))


def pressed(n: int, law: MembraneLaw, depth: float, stretch: float = 1.0) -> tuple[float, float, float]:
    """Force and stretch in the middle over a ball of radius 40, and the share wrinkled; 100 mm of undeformed radius."""
    sheet = disc(n, n, law, (200.0 * stretch, 200.0 * stretch), prestretch=(stretch, stretch))
    _, said = rests(sheet, raised(sphere(), depth))
    assert said.cells is not None
    middle = said.cells.stretch[n // 2 - 1 : n // 2 + 1, n // 2 - 1 : n // 2 + 1].mean()
    return said.press_force, float(middle), float(np.average(said.cells.wrinkled, weights=sheet.areas))


# Two independent solvers of the axisymmetric problem (collocation, shooting) agree to the digits shown.
@pytest.mark.parametrize(
    ("material", "depth", "force", "apex"),
    [
        pytest.param(RUBBER, 20.0, 1.7959477986, 1.0307655323, marks=pytest.mark.slow),
        pytest.param(RUBBER, 60.0, 41.576556565, 1.2854086307, marks=pytest.mark.slow),
        pytest.param(YEOH, 40.0, 13.188277813, 1.1145147718, marks=pytest.mark.slow),
        pytest.param(YEOH, 80.0, 62.822435364, 1.6391627787, marks=pytest.mark.slow),
    ],
)
def test_a_ball_on_a_disc_is_felt_as_published_to_second_order(material, depth, force, apex):
    law = IsotropicSheet(material)
    found = [pressed(n, law, depth) for n in (41, 81, 161)]
    off = [abs(one[0] / force - 1.0) for one in found]
    assert off[2] < 1e-3
    assert 2.5 < off[0] / off[1] < 6.0
    assert 2.5 < off[1] / off[2] < 6.0
    assert found[2][1] == pytest.approx(apex, abs=2e-3)
    assert found[2][2] == 0.0


def test_a_disc_mounted_slack_wrinkles_at_its_rim_as_published_and_one_mounted_tight_pulls_more():
    law = IsotropicSheet(RUBBER)
    force, apex, wrinkled = pressed(121, law, 60.0, 0.95)
    assert force == pytest.approx(31.3787731, rel=1e-3)
    assert apex == pytest.approx(1.1969036, abs=1e-3)
    assert wrinkled == pytest.approx(0.24043, abs=2e-3)  # of the undeformed area, half a ring of cells
    assert pressed(121, law, 60.0, 1.05)[0] == pytest.approx(48.8658267, rel=1e-3)


def test_a_disc_does_not_tell_how_its_fabric_lies_in_it():
    """The grid has its own directions, the fabric has others: what a turn changes is an error of second order."""
    mold, spread = raised(sphere(), 50.0), []
    for n in (31, 61):
        forces = [rests(disc(n, n, Turned(FABRIC, a)), mold)[1].press_force for a in (0.0, np.pi / 6, np.pi / 4)]
        spread.append(np.ptp(forces) / np.mean(forces))
    assert spread[1] < 1e-3
    assert spread[1] < 0.4 * spread[0]


@pytest.mark.slow
def test_a_disc_rubs_as_published():
    """Coulomb friction 0.3 at 60 mm: 44.0083 N, about 18.9 N mm rubbed away."""
    sheet = disc(61, 61, IsotropicSheet(RUBBER))
    *_, rest = follow(sheet, sphere(), load_steps([60.0], 12), 0.3)
    assert rest.found.converged, rest.found.status
    said = answers(sheet, raised(sphere(), 60.0), rest.found)
    assert said.press_force == pytest.approx(44.0083276, rel=4e-3)
    assert rest.rubbed == pytest.approx(18.9, rel=2e-2)
    stored = rest.found.energy - rest.unstressed
    assert rest.work == pytest.approx(stored + rest.rubbed, rel=1e-2)


MOLDS = {"box": block(turn=0.3), "punch": punch(64), "saddle": saddle()}


@pytest.mark.parametrize("name", MOLDS)
def test_no_node_and_no_side_is_inside_a_mold(name):
    surface = MOLDS[name]
    _, said = rests(disc(60, 51, FABRIC, (260.0, 260.0)), mold_of(surface, under(surface, 40.0)))
    assert said.cut.edge < 1e-6
    assert said.contact_edges > 0


def test_markers_on_a_disc_are_found_where_they_lie():
    sheet = disc(41, 41, IsotropicSheet(RUBBER))
    coarse = disc(21, 21, IsotropicSheet(RUBBER)).flat().reshape(-1, 3)
    draped: Any = SimpleNamespace(base=sheet.flat(), grid=(21, 21), size=sheet.size, round=True, finer=())
    radius, angle = np.sqrt(np.random.default_rng(2).uniform(0, 1, 60)) * 97.0, np.linspace(0, 6, 60)
    flat = np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=1)
    (base,), weights = at_markers(draped, flat)
    assert np.abs(base[:, :2] - flat).max() < 1e-2
    assert np.abs((weights @ coarse)[:, :2] - flat).max() < 5e-2
