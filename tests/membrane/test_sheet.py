"""Elements: homogeneous stretch is exact, forces are the energy's derivative, stiffness is the forces'."""

from __future__ import annotations

import numpy as np
import pytest
from builders import uniform

from hyperfab.materials import bind
from hyperfab.membrane.mesh import sheet_mesh
from hyperfab.membrane.meshing import triangulate
from hyperfab.membrane.orthotropic import orthotropic_sheet
from hyperfab.membrane.outline import Disc, Square
from hyperfab.membrane.recovery import recovered_strain
from hyperfab.membrane.sheet import Sheet
from hyperfab.membrane.tension_field import IsotropicSheet

YEOH = bind("yeoh-3", {"C10_MPa": 0.18, "C20_MPa": -0.004, "C30_MPa": 0.0008})
OGDEN = bind("ogden-1", {"mu1_MPa": 0.4, "alpha1": 2.3})
LAWS = {
    "invariants": IsotropicSheet(YEOH),
    "stretches": IsotropicSheet(OGDEN),
    "two directions": orthotropic_sheet(bind("neo-hookean", {"C10_MPa": 0.3}), YEOH),
}


def _sheet(law, order=2, outline=None):
    outline = outline or Square(40.0)
    return Sheet(sheet_mesh(outline, triangulate(outline, uniform(9.0)), order), law, 0.7)


def _bent(sheet, seed=0):
    """Places of a stretched, curved sheet without any symmetry."""
    x, y = sheet.mesh.nodes.T
    noise = np.random.default_rng(seed).normal(size=(len(x), 3))
    smooth = np.column_stack([1.15 * x + 0.05 * y, 0.02 * x + 1.1 * y, 0.01 * (x**2 - 0.5 * x * y)])
    return smooth + 0.02 * noise


@pytest.mark.parametrize("order", [1, 2])
def test_homogeneous_stretch_is_exact(order):
    sheet = _sheet(LAWS["invariants"], order)
    stretch = np.array([[1.3, 0.0], [0.0, 0.9], [0.2, 0.1]])
    strain = stretch.T @ stretch
    for found in (
        sheet.strain(sheet.mesh.nodes @ stretch.T),
        recovered_strain(sheet.mesh, sheet.mesh.nodes @ stretch.T),
    ):
        np.testing.assert_allclose(
            found, np.tile([strain[0, 0], strain[1, 1], strain[0, 1]], (len(found), 1)), atol=1e-7
        )


@pytest.mark.parametrize("name", LAWS)
@pytest.mark.parametrize("order", [1, 2])
def test_forces_are_the_derivative_of_the_energy(name, order):
    sheet = _sheet(LAWS[name], order)
    places = _bent(sheet)
    way = np.random.default_rng(1).normal(size=places.shape)
    small = 1e-5
    slope = (sheet.energy(places + small * way) - sheet.energy(places - small * way)) / (2 * small)
    assert (sheet.assemble(places).force * way).sum() == pytest.approx(slope, rel=1e-8)


@pytest.mark.parametrize("name", LAWS)
def test_stiffness_is_the_derivative_of_the_forces_and_symmetric(name):
    sheet = _sheet(LAWS[name])
    places = _bent(sheet)
    pattern = sheet.pattern
    matrix = pattern.matrix(sheet.assemble(places).blocks)
    way = pattern.extend(np.random.default_rng(2).normal(size=pattern.unknowns))
    small = 1e-5
    ahead, behind = (sheet.assemble(places + sign * small * way).force for sign in (1, -1))
    slope = pattern.restrict((ahead - behind) / (2 * small))
    np.testing.assert_allclose(matrix @ pattern.restrict(way), slope, atol=2e-7 * np.abs(slope).max())
    assert abs(matrix - matrix.T).max() < 1e-12 * abs(matrix).max()


@pytest.mark.parametrize("name", LAWS)
def test_energy_does_not_hang_on_the_frame(name):
    sheet = _sheet(LAWS[name])
    places = _bent(sheet)
    turn, _ = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))
    assert sheet.energy(places @ turn.T + [1.0, 2.0, 3.0]) == pytest.approx(sheet.energy(places), rel=1e-12)


def test_recovered_strain_converges_faster_than_the_elements_own():
    """Of a smooth curved surface the recovered strain is third order at least; the elements' own is second."""
    errors = []
    for length in (8.0, 4.0):
        outline = Disc(30.0)
        mesh = sheet_mesh(outline, triangulate(outline, uniform(length)))
        x, y = mesh.nodes.T
        places = np.column_stack([x + 1e-3 * x**3 / 30, y, 6 * np.sin(x / 15) * np.cos(y / 20)])
        c1, c2 = 0.4 * np.cos(x / 15) * np.cos(y / 20), -0.3 * np.sin(x / 15) * np.sin(y / 20)
        exact = np.column_stack([(1 + 1e-4 * x**2) ** 2 + c1**2, 1 + c2**2, c1 * c2])
        inner = np.hypot(x, y) < 18.0
        errors.append(np.abs(recovered_strain(mesh, places) - exact)[inner].max())
    assert errors[0] / errors[1] > 6.0
