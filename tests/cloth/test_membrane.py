"""The sheet as a membrane: exact states, derivatives, invariances, other solvers, and molds that nothing enters."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import trimesh
from cloth_checks import derivatives_hold
from cloth_molds import ball, block, punch, saddle, under

from hyperfab.cloth import Answers, BeyondLaw, Equilibrium, Mold, Sheet, answers, drape, mold_of, raised
from hyperfab.cloth.dynamic import swing
from hyperfab.cloth.law import spring_law
from hyperfab.cloth.linear import Tangent, apply
from hyperfab.cloth.membrane import Membrane, MembraneLaw
from hyperfab.cloth.net import FIXED, X, Y, Z
from hyperfab.cloth.path import follow, load_steps
from hyperfab.cloth.start import lowered
from hyperfab.materials import bind
from hyperfab.materials.orthotropic import Orthotropic
from hyperfab.membrane.orthotropic import orthotropic_sheet
from hyperfab.membrane.relaxed import RelaxedSheet
from hyperfab.membrane.tension_field import IsotropicSheet
from hyperfab.samples import torso as samples
from hyperfab.surface import Surface

RUBBER = bind("neo-hookean", {"C10_MPa": 0.2})
YEOH = bind("yeoh-3", {"C10_MPa": 0.2, "C20_MPa": -0.002, "C30_MPa": 0.0003})
THREADS = spring_law(RUBBER)
FABRIC = Orthotropic.of(
    {"C10_MPa": 0.15, "C20_MPa": 0.01, "k1_warp_MPa": 0.4, "k2_warp": 0.3, "k1_weft_MPa": 0.1, "k1_bias_MPa": 0.1,
     "bias_deg": 30.0, "G_MPa": 0.03}
)  # fmt: skip
LAWS = {
    "isotropic": IsotropicSheet(RUBBER),
    "orthotropic": RelaxedSheet(FABRIC),
    "two directions": orthotropic_sheet(YEOH, RUBBER),
}
FAR = mold_of(ball(1), (0.0, 0.0, -500.0))


def membrane(n: int, m: int, law: MembraneLaw, size: tuple[float, float], **options) -> Sheet:
    return Sheet(n, m, size, options.pop("thickness", 1.0), THREADS, THREADS, membrane=law, **options)


def rests(sheet: Sheet, mold: Mold, tolerance: float = 1e-6) -> tuple[Equilibrium, Answers]:
    found = drape(sheet, mold, tolerance)
    said = answers(sheet, mold, found)
    assert found.converged, found.status
    assert found.residual_relative <= tolerance
    assert said.cut.node < 1e-9
    return found, said


@pytest.mark.parametrize("law", LAWS)
def test_forces_are_the_gradient_of_the_energy_and_the_tangent_theirs(law):
    derivatives_hold(membrane(7, 6, LAWS[law], (60.0, 40.0), prestretch=(1.1, 0.9), mass=500.0), FAR)


def test_a_flat_sheet_stretched_both_ways_has_the_exact_stress_energy_force_and_thickness():
    found, said = rests(membrane(13, 9, IsotropicSheet(YEOH), (80.0, 60.0), prestretch=(1.3, 1.1)), FAR)
    exact = YEOH.membrane(1.3, 1.1)
    assert said.stress_warp == pytest.approx(np.full((13, 9), float(exact.P1)), rel=1e-12)
    assert said.stress_weft == pytest.approx(np.full((13, 9), float(exact.P2)), rel=1e-12)
    assert said.cell_thickness == pytest.approx(np.full((12, 8), 1.0 / 1.43), rel=1e-12)
    assert said.reaction[0, :, 0].sum() == pytest.approx(-float(exact.P1) * 60.0 / 1.1, rel=1e-12)
    assert found.energy == pytest.approx(float(exact.W) * 80.0 * 60.0 / 1.43, rel=1e-12)


def test_a_sheet_pressed_across_wrinkles_and_pulls_as_a_free_strip():
    sheet = membrane(13, 9, IsotropicSheet(YEOH), (80.0, 60.0), prestretch=(1.3, 0.8))
    _, said = rests(sheet, FAR)
    assert said.slack_springs == 12 * 8
    assert said.stress_warp == pytest.approx(np.full((13, 9), float(YEOH.uniaxial(1.3).P)), rel=1e-12)
    assert np.abs(said.stress_weft).max() == 0.0
    assert said.cell_thickness == pytest.approx(np.full((12, 8), 1.3**-0.5), rel=1e-12)


@pytest.mark.parametrize("along", [0, 1])
@pytest.mark.parametrize("law", [IsotropicSheet(RUBBER), IsotropicSheet(YEOH)], ids=["neo-hookean", "yeoh-3"])
def test_a_free_strip_narrows_by_the_root_of_its_stretch(law, along):
    if along == 0:
        sheet = membrane(21, 9, law, (100.0, 40.0), prestretch=(1.5, 1.0), edges=(X | Z, X | Z, 0, 0))
    else:
        sheet = membrane(9, 21, law, (40.0, 100.0), prestretch=(1.0, 1.5), edges=(0, 0, Y | Z, Y | Z))
    found, said = rests(sheet, FAR, 1e-9)
    x = found.state.x
    width = np.ptp(x[:, :, 1], axis=1) if along == 0 else np.ptp(x[:, :, 0], axis=0)
    assert width == pytest.approx(np.full(21, 40.0 * 1.5**-0.5), rel=1e-6)
    assert said.cell_thickness == pytest.approx(np.full(said.cell_thickness.shape, 1.5**-0.5), rel=1e-6)
    pull = np.abs(said.reaction[0, :, 0].sum() if along == 0 else said.reaction[:, 0, 1].sum())
    assert pull == pytest.approx(float(law.material.uniaxial(1.5).P) * 40.0, rel=1e-8)


def dome(turn: float = 0.0, mirror: bool = False, scale: float = 1.0) -> Mold:
    """An egg of three axes off the sheet's middle, its top at z = 0."""
    egg = trimesh.creation.icosphere(subdivisions=4, radius=1.0)
    vertices = egg.vertices * [38.0, 27.0, 33.0] + [7.0, -4.0, 0.0]
    faces = egg.faces
    if mirror:
        vertices, faces = vertices * [-1.0, 1.0, 1.0], faces[:, ::-1]
    c, s = np.cos(turn), np.sin(turn)
    vertices = vertices @ np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
    vertices[:, 2] -= vertices[:, 2].max()
    return mold_of(Surface(scale * vertices, faces), (0.0, 0.0, 35.0 * scale))


def test_a_quarter_turn_a_mirror_and_ten_times_the_size_change_nothing():
    law = RelaxedSheet(FABRIC)
    sheet = membrane(31, 25, law, (150.0, 120.0))
    found, said = rests(sheet, dome(), 1e-9)
    quarter = replace(sheet, n=25, m=31, size=(120.0, 150.0), membrane=RelaxedSheet(FABRIC.turned()))
    turned, same = rests(quarter, dome(turn=0.5 * np.pi), 1e-9)
    assert same.press_force == pytest.approx(said.press_force, rel=1e-6)
    back = np.stack([turned.state.x[::-1, :, 1], -turned.state.x[::-1, :, 0], turned.state.x[::-1, :, 2]], 2)
    assert np.abs(back.swapaxes(0, 1) - found.state.x).max() < 1e-6 * 150.0
    mirrored, alike = rests(sheet, dome(mirror=True), 1e-9)
    assert alike.press_force == pytest.approx(said.press_force, rel=1e-6)
    assert np.abs(mirrored.state.x[::-1] * [-1.0, 1.0, 1.0] - found.state.x).max() < 1e-6 * 150.0
    large = membrane(31, 25, law, (1500.0, 1200.0), thickness=10.0)
    grown, larger = rests(large, dome(scale=10.0), 1e-9)
    assert larger.press_force == pytest.approx(100.0 * said.press_force, rel=1e-6)
    assert np.abs(0.1 * grown.state.x - found.state.x).max() < 1e-6 * 150.0


def test_the_press_does_the_work_that_the_sheet_stores():
    sheet, mold = (
        membrane(41, 41, IsotropicSheet(YEOH), (200.0, 200.0)),
        mold_of(ball(5, 40.0), (0.0, 0.0, -40.0)),
    )
    _, said = rests(sheet, raised(mold, 60.0), 1e-9)
    up, down = (rests(sheet, raised(mold, 60.0 + h), 1e-9)[0].energy for h in (0.05, -0.05))
    assert said.press_force == pytest.approx((up - down) / 0.1, rel=1e-4)
    assert said.imbalance < 1e-7 * said.press_force


def test_newton_and_dynamic_relaxation_end_in_the_same_energy():
    sheet, mold = membrane(17, 17, IsotropicSheet(RUBBER), (150.0, 150.0)), dome()
    newton = drape(sheet, mold, 1e-8)
    other = swing(sheet, mold, lowered(sheet, mold), 1e-7)
    assert other.converged, other.status
    assert other.energy == pytest.approx(newton.energy, rel=1e-8)


def torso() -> Surface:
    """The sample's chest, smooth, with a valley between two domes."""
    solid = samples.torso()
    return Surface(solid.vertices, solid.faces)


MOLDS = {"box": block(turn=0.3), "punch": punch(64), "torso": torso(), "saddle": saddle()}


@pytest.mark.parametrize(
    ("name", "law"),
    [
        *((name, "isotropic") for name in MOLDS),
        *(
            pytest.param(name, "orthotropic", marks=pytest.mark.slow if name in ("box", "punch") else ())
            for name in MOLDS
        ),
    ],
)
def test_no_node_is_inside_a_mold(name, law):
    surface = MOLDS[name]
    sheet = membrane(60, 51, LAWS[law], (220.0, 210.0))
    _, said = rests(sheet, mold_of(surface, under(surface, 40.0)))
    if name == "saddle":  # round along its ridges: a side beside one cuts its arch, of 72 mm radius
        longest = said.stretch_max * max(sheet.spacing)
        assert said.cut.edge < longest**2 / (8.0 * 72.0)
    elif name != "torso":  # round all over
        assert said.cut.edge < 1e-6
    if name != "torso":
        assert said.contact_edges > 0


def test_a_sharp_punch_is_felt_alike_on_all_grids():
    forces = []
    for n in (30, 41, 50):
        sheet, surface = membrane(n, n, IsotropicSheet(RUBBER), (220.0, 220.0)), punch(64)
        forces.append(rests(sheet, mold_of(surface, under(surface, 40.0)))[1].press_force)
    assert np.ptp(forces) < 0.02 * np.mean(forces)


def test_asking_which_sides_to_leave_straight_changes_nothing_that_is_known_of_the_forces():
    mold = mold_of(punch(90), (0.0, 0.0, 40.0))
    sheet = membrane(24, 24, IsotropicSheet(RUBBER), (200.0, 200.0))
    found = drape(sheet, mold, 1e-4)
    model, f = Membrane(sheet, mold), np.zeros_like(found.state.x)
    model.forces(found.state.x, found.state.clear, f)
    springs, ways, push = model.springs.copy(), model.ways.copy(), model.push.copy()
    assert push[2] > 1.0
    start = found.state._replace(x=np.add(sheet.flat(), [0.0, 0.0, 50.0]))
    assert not model.leave(start, start)
    assert not model.leave(start, start, 0)
    np.testing.assert_array_equal(model.push, push)
    np.testing.assert_array_equal(model.springs, springs)
    np.testing.assert_array_equal(model.ways, ways)
    assert found.push[2] == pytest.approx(push[2], rel=1e-12)


def test_steps_that_a_jump_cuts_again_and_again_are_not_crawled():
    """Facets of the chest turn by just more than a sharp edge's angle here and there: ways over such an edge jump."""
    sheet, steps = membrane(100, 100, IsotropicSheet(RUBBER), (220.0, 220.0)), []
    surface = torso()
    found = drape(sheet, mold_of(surface, under(surface, 40.0)), report=steps.append)
    assert found.converged
    assert len([one for one in steps if one.nodes == (100, 100)]) <= 14  # 17, of 10 to 20 tries each
    assert sum(one.step_length < 2.0**-6 for one in steps) <= 2


@pytest.mark.slow
def test_a_membrane_rises_off_a_flat_at_once():
    """Beside an edge that runs across its cells it is lifted a little; rows of nodes must not leave one a step."""
    sheet, steps = membrane(200, 200, IsotropicSheet(RUBBER), (220.0, 220.0)), []
    surface = block(turn=0.3)
    found = drape(sheet, mold_of(surface, under(surface, 40.0)), report=steps.append)
    assert found.converged
    fine = [one for one in steps if one.nodes == (200, 200)]
    assert fine[-1].contacts < 200
    assert max(one.contacts for one in fine[3:]) < 200  # released row by row: thousands, and 27 steps


def test_a_membrane_rubs_and_is_drawn_in_with_its_energy_balanced():
    mold = mold_of(ball(4, 40.0), (0.0, 0.0, -40.0))
    sheet = membrane(
        21, 21, IsotropicSheet(RUBBER), (200.0, 200.0), edges=(Z, Z, FIXED, FIXED), holder=(0.05, 0.05, 0, 0)
    )
    *_, rest = follow(sheet, mold, load_steps([40.0], 16), 0.3)
    assert rest.found.converged, rest.found.status
    assert rest.rubbed > 0.0
    assert rest.drawn > 0.0
    stored = rest.found.energy - rest.unstressed
    assert rest.work == pytest.approx(stored + rest.rubbed + rest.drawn, rel=1e-2)


def test_the_forces_of_laid_sides_are_derivatives_of_the_energy_and_the_tangent_theirs():
    mold = mold_of(punch(90), (0.0, 0.0, 40.0))
    sheet = membrane(24, 24, IsotropicSheet(RUBBER), (200.0, 200.0))
    state = drape(sheet, mold, 1e-4).state
    d = np.random.default_rng(0).normal(size=state.x.shape)
    on_top = state.contact != 0
    d[on_top, 2] = 0.0
    x = state.x + 1e-3 * d  # out of equilibrium
    model, clear, f, plus, minus = Membrane(sheet, mold), np.zeros((24, 24)), *np.zeros((3, *x.shape))
    model.forces(x, clear, f)
    bent = len(model.springs)
    assert bent > 20
    tangent, turned, h = Tangent.empty(24, 24, 4), np.zeros_like(x), 1e-6
    model.tangent(x, 0.0, tangent)
    tangent.q[:] = [1, 0, 0, 1, 0, 1]
    apply(tangent, d, turned)
    rise = model.forces(x + h * d, clear, plus)[0] - model.forces(x - h * d, clear, minus)[0]
    assert len(model.springs) == bent
    assert rise / (2 * h) == pytest.approx(-(f * d).sum(), rel=1e-6)
    error = np.abs(turned + (plus - minus) / (2 * h))
    error[on_top, 2] = 0.0
    assert error.max() < 1e-6 * np.abs(turned).max()


def test_a_flat_sheet_that_rubs_begins_on_an_edge() -> None:
    """The upper one of an icosahedron in single precision, which nodes are put onto: rounding, and no way on."""
    solid = trimesh.creation.icosphere(0, 40.0)
    points = (solid.vertices - [0.0, 0.0, solid.vertices[:, 2].max()]).astype(np.float32)
    mold = mold_of(Surface(points.astype(float), solid.faces))
    *_, rest = follow(membrane(61, 61, LAWS["orthotropic"], (220.0, 220.0)), mold, np.array([5.0]), 0.3)
    assert (rest.height, rest.found.converged) == (5.0, True)


def test_a_law_that_ends_before_the_strains_of_its_net_is_pushed_up_to_where_it_rests():
    """It was refused as one whose chains lock, with an equilibrium well before that."""
    energies = []
    for limit in (0.4, 0.42, 0.44, 0.46, 0.48, 0.5):  # the stiffer ones are not led to by their nets
        gent = bind("gent", {"mu_MPa": 0.4, "Im": limit})
        springs = spring_law(gent)
        sheet = Sheet(21, 21, (200.0, 200.0), 1.0, springs, springs, membrane=IsotropicSheet(gent))
        found = drape(sheet, mold_of(ball(4, 40.0), (0.0, 0.0, 20.0)))
        assert found.converged, found.status
        energies.append(found.energy)
    # One smooth curve: both kinds rest in the same shape.
    assert np.abs(np.diff(energies, 4)).max() < 0.01 * np.ptp(energies)


def test_a_law_that_ends_before_the_mold_does_has_no_rest():
    gent = bind("gent", {"mu_MPa": 0.4, "Im": 0.02})
    sheet = Sheet(21, 21, (200.0, 200.0), 1.0, spring_law(gent), spring_law(gent), membrane=IsotropicSheet(gent))
    with pytest.raises(BeyondLaw):
        drape(sheet, mold_of(ball(4, 40.0), (0.0, 0.0, 20.0)))
