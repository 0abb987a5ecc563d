"""The net's energy, forces, tangent and linear solver agree with each other."""

from __future__ import annotations

import numpy as np
import pytest
from cloth_molds import ball

from hyperfab.cloth import Sheet, mold_of, piecewise_linear, tabulate
from hyperfab.cloth.energy import Energy
from hyperfab.cloth.linear import Solver, Tangent, apply, dot
from hyperfab.cloth.net import FIXED

WARP = tabulate(lambda lam: (lam - lam**-2, 1 + 2 * lam**-3), 4.0)
WEFT = tabulate(lambda lam: (2 * lam**2 - 2 / lam, 4 * lam + 2 * lam**-2), 4.0)
SHEAR = piecewise_linear([1.0, 1.3, 2.6], [0.0, 0.1, 0.9])  # over 1 + the shear angle


FAR = mold_of(ball(1), (0.0, 0.0, -500.0))


def stretched(n: int, m: int, **options) -> tuple[Sheet, np.ndarray]:
    sheet = Sheet(n, m, (60.0, 40.0), 0.8, WARP, WEFT, **options)
    x = sheet.flat() * [1.3, 1.4, 1.0]
    i, j = np.mgrid[:n, :m]
    x[:, :, 0] += 0.8 * np.sin(1.3 * i + 0.7 * j)
    x[:, :, 2] = 12 * np.sin(np.pi * i / (n - 1)) * np.sin(np.pi * j / (m - 1)) + np.cos(2.0 * i * j)
    return sheet, x


@pytest.mark.parametrize("options", [{}, {"shear": SHEAR, "mass": 500.0}, {"prestretch": (1.1, 1.2)}])
def test_forces_are_minus_the_gradient_of_the_energy(options):
    sheet, x = stretched(6, 5, **options)
    f, trash, model, clear = np.zeros_like(x), np.zeros_like(x), Energy(sheet, FAR), np.zeros((6, 5))
    model.forces(x, clear, f)
    rng = np.random.default_rng(0)
    for _ in range(5):
        d = rng.normal(size=x.shape)
        h = 1e-5
        rise = model.forces(x + h * d, clear, trash)[0] - model.forces(x - h * d, clear, trash)[0]
        assert rise / (2 * h) == pytest.approx(-(f * d).sum(), rel=1e-7)


@pytest.mark.parametrize("options", [{}, {"shear": SHEAR}])
def test_the_tangent_is_the_derivative_of_the_forces(options):
    sheet, x = stretched(6, 5, **options)
    tangent, model, clear = Tangent.empty(6, 5, 4 if sheet.shear else 2), Energy(sheet, FAR), np.zeros((6, 5))
    model.tangent(x, 0.0, tangent)
    tangent.q[:] = [1, 0, 0, 1, 0, 1]
    d = np.random.default_rng(1).normal(size=x.shape)
    kd, plus, minus = np.zeros_like(x), np.zeros_like(x), np.zeros_like(x)
    apply(tangent, d, kd)
    h = 1e-6
    model.forces(x + h * d, clear, plus)
    model.forces(x - h * d, clear, minus)
    assert np.allclose(kd, -(plus - minus) / (2 * h), atol=1e-6 * np.abs(kd).max())


def test_sections_of_all_springs_add_up_to_width_times_thickness():
    sheet, _ = stretched(6, 5)
    assert sheet.arrays.warp_area.sum() == pytest.approx(40.0 * 0.8)
    assert sheet.arrays.weft_area.sum() == pytest.approx(60.0 * 0.8)


@pytest.mark.parametrize("sheared", [False, True])
def test_multigrid_keeps_the_number_of_inner_steps_as_the_grid_grows(sheared):
    steps = []
    for n in (25, 50, 101):
        options = {"shear": SHEAR} if sheared else {}
        sheet = Sheet(n, n, (60.0, 60.0), 1.0, WARP, WEFT, **options)
        i, j = np.mgrid[:n, :n] / (n - 1)
        x = sheet.flat() * [1.2, 1.3, 1.0]
        x[:, :, 2] = 20 * np.sin(np.pi * i) * np.sin(np.pi * j)
        tangent, solver = Tangent.empty(n, n, 4 if sheared else 2), Solver(n, n, 4 if sheared else 2)
        Energy(sheet, FAR).tangent(x, 0.0, tangent)
        normal = np.dstack([-np.cos(np.pi * i) * 0.3, 0 * i, 1 + 0 * i])
        normal /= np.linalg.norm(normal, axis=2, keepdims=True)
        q = (
            np.eye(3)
            - (normal[..., None] * normal[..., None, :]) * ((i - 0.5) ** 2 + (j - 0.5) ** 2 < 0.1)[..., None, None]
        )
        q[sheet.fixed == FIXED] = 0
        tangent.q[:] = q[..., [0, 0, 0, 1, 1, 2], [0, 1, 2, 1, 2, 2]]
        b = np.einsum("ijkl,ijl->ijk", q, np.random.default_rng(2).normal(size=x.shape))
        d, back = np.zeros_like(x), np.zeros_like(x)
        assert solver(tangent, b, d, 1e-8)
        apply(tangent, d, back)
        assert np.abs(back - b).max() < 1e-5 * np.abs(b).max()
        steps.append(solver.iterations)
    assert max(steps) <= 40
    assert steps[-1] <= steps[0] + 15


def test_the_preconditioner_is_symmetric():
    sheet, x = stretched(17, 14)
    tangent, solver = Tangent.empty(17, 14, 2), Solver(17, 14, 2)
    Energy(sheet, FAR).tangent(x, 0.0, tangent)
    tangent.q[1:-1, 1:-1] = [1, 0, 0, 1, 0, 1]
    solver.grids.build(tangent.diag, tangent.off, tangent.q)
    rng = np.random.default_rng(3)
    a, b = ((rng.normal(size=x.shape) * (sheet.fixed == 0)[..., None]).astype(np.float32) for _ in range(2))
    ma, mb = np.zeros_like(a), np.zeros_like(b)
    solver.grids(a, ma)
    solver.grids(b, mb)
    assert dot(ma, b) == pytest.approx(dot(a, mb), rel=1e-5)
    assert dot(ma, a) > 0
