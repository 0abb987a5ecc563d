"""Short slanted strips in their grips: against linear finite elements, and what a fit makes of them."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import scipy.sparse as sp
from scipy.sparse.linalg import spsolve

from hyperfab.curve import TestCurve
from hyperfab.materials.orthotropic import Orthotropic
from hyperfab.materials.orthotropic.grips import at_readings, stiffening
from hyperfab.materials.orthotropic.identify import identify
from hyperfab.materials.orthotropic.specimen import strip

#: Threads both ways that turn in a soft ground: at rest E1 = 4 k1_warp + 4 C10, and G as it stands.
SHEET = {"C10_MPa": 0.3, "nu": 0.3, "k1_warp_MPa": 1.4, "k1_weft_MPa": 4.5, "G_MPa": 0.5}
#: The laminate: 97 mm between the grips, 75 mm wide.
LAMINATE = 97.0 / 75.0


def _elements(D: np.ndarray, aspect: float, n: int = 12) -> float:
    """Load over strain and width of a strip held at both ends, which may shift sideways: linear biquadratic elements.

    ``D`` is the stiffness in the strip's axes, y along it.
    """
    rows, columns = int(n * aspect), n
    point, share = np.polynomial.legendre.leggauss(3)

    def shape(s: float) -> tuple[np.ndarray, np.ndarray]:
        return np.array([s * (s - 1) / 2, 1 - s * s, s * (s + 1) / 2]), np.array([s - 0.5, -2 * s, s + 0.5])

    hx, hy = 1.0 / columns, aspect / rows
    K = np.zeros((18, 18))
    for a, wa in zip(point, share, strict=True):
        for b, wb in zip(point, share, strict=True):
            (na, da), (nb, db) = shape(a), shape(b)
            dx, dy = np.outer(nb, da).ravel() * 2 / hx, np.outer(db, na).ravel() * 2 / hy
            B = np.zeros((3, 18))
            B[0, 0::2] = B[2, 1::2] = dx
            B[1, 1::2] = B[2, 0::2] = dy
            K += wa * wb * hx * hy / 4 * B.T @ D @ B
    node = np.arange((2 * columns + 1) * (2 * rows + 1)).reshape(2 * rows + 1, -1)
    ij = [
        np.stack([2 * own, 2 * own + 1], axis=1).ravel()
        for j in range(rows) for i in range(columns)
        for own in [node[2 * j : 2 * j + 3, 2 * i : 2 * i + 3].ravel()]
    ]  # fmt: skip
    el, size = np.array(ij), 2 * node.size
    whole = sp.csr_matrix(
        (np.tile(K.ravel(), len(el)), (np.repeat(el, 18, axis=1).ravel(), np.tile(el, 18).ravel())),
        (size, size),
    )
    top, held = 2 * node[-1], np.concatenate([2 * node[0], 2 * node[0] + 1, 2 * node[-1], 2 * node[-1] + 1])
    u = np.zeros(size)
    u[top + 1] = aspect
    inner = np.setdiff1d(np.arange(size), held)
    ties = sp.csr_matrix(
        (np.ones(len(inner) + len(top)),
         (np.concatenate([inner, top]), np.concatenate([np.arange(len(inner)), np.full(len(top), len(inner))]))),
        (size, len(inner) + 1),
    )  # fmt: skip
    u += ties @ spsolve((ties.T @ whole @ ties).tocsc(), -ties.T @ (whole @ u))
    return float(u @ (whole @ u)) / aspect


@pytest.mark.parametrize("aspect", [1.0, 1.6])
@pytest.mark.parametrize("angle", [20.0, 45.0, 70.0])
def test_the_grips_stiffen_as_finite_elements_say(angle, aspect):
    law = Orthotropic.of({"C10_MPa": 1e-3, "nu": 0.0, "k1_warp_MPa": 2.0, "k1_weft_MPa": 5.0, "G_MPa": 0.9})
    small = np.array([1.0 + 1e-5])
    own = stiffening(law, angle, aspect, small)[0] * strip(law, angle, small).stress[0] / 1e-5
    # The sheet at rest, threads taken as taut both ways, turned so that y is along the strip.
    at_rest = np.diag([8.0, 20.0, 0.9]) + 1e-3 * np.diag([4.0, 4.0, 2.0])
    t = np.deg2rad(90.0 - angle)
    c, s = np.cos(t), np.sin(t)
    T = np.array([[c * c, s * s, c * s], [s * s, c * c, -c * s], [-2 * c * s, 2 * c * s, c * c - s * s]])
    assert own == pytest.approx(_elements(T.T @ at_rest @ T, aspect), rel=0.01)


def test_grips_count_little_where_nothing_shears_or_the_strip_is_long():
    rubber, lam = Orthotropic.of({"C10_MPa": 0.2, "nu": 0.0}), np.linspace(1.0, 1.3, 5)
    np.testing.assert_allclose(at_readings(rubber, 45.0, 1.0, lam), 1.0, rtol=1e-9)
    law = Orthotropic.of(SHEET)
    for angle, aspect in ((45.0, 2.0), (45.0, None), (0.0, 1.0), (None, 1.0)):
        assert (at_readings(law, angle, aspect, lam) == 1.0).all()
    falling = [stiffening(law, 45.0, aspect, np.array([1.02]))[0] for aspect in (0.8, 1.3, 2.0, 4.0)]
    assert (np.diff(falling) < 0.0).all()
    # Mirror and quarter turn.
    lam = np.array([1.01, 1.03])
    own = stiffening(law, 30.0, 1.3, lam)
    np.testing.assert_allclose(stiffening(law, -30.0, 1.3, lam), own, rtol=1e-9)
    np.testing.assert_allclose(stiffening(law.turned(), 120.0, 1.3, lam), own, rtol=1e-9)


@pytest.mark.slow
def test_shear_is_found_from_a_short_strip_without_what_its_grips_add():
    law, lam = Orthotropic.of(SHEET), np.linspace(1.002, 1.04, 12)
    tests = []
    for angle in (0.0, 45.0, 90.0):
        stress = strip(law, angle, lam).stress * at_readings(law, angle, LAMINATE, lam)
        width = (strip(law, angle, lam).width, None, np.full(len(lam), 50.0)) if angle != 45.0 else ()
        tests.append(TestCurve("uniaxial", lam, stress, 1.0 / stress, *width, direction=angle))
    held = [replace(test, aspect=LAMINATE) for test in tests]
    found, uniform = identify(held).law, identify(tests).law
    for angle in (20.0, 45.0, 70.0):
        own = strip(law, angle, lam).stress
        np.testing.assert_allclose(strip(found, angle, lam).stress, own, rtol=2e-3)
    # Taken as uniform, the sheet would be that much too stiff at 45 degrees.
    assert strip(uniform, 45.0, lam).stress[-1] > 1.15 * strip(law, 45.0, lam).stress[-1]


@pytest.mark.slow
def test_a_laminate_pulled_along_across_and_at_45_degrees_tells_the_other_angles(hf, data_dir, tmp_path):
    """Stiffness at 3 % of the sheet, against strips at four angles the fit has not seen: within 15 %."""

    def file(angle: int) -> str:
        return str(data_dir / "nylon-laminate" / f"uniaxial-{angle}.csv")

    run = hf("fit", file(0), file(45), file(90), "--model", "orthotropic", "-o", "-", cwd=tmp_path, timeout=600)
    assert run.returncode == 0, run.stderr.decode()
    document = json.loads(run.stdout)
    assert any("held in their grips" in line for line in document["preparation"])
    assert document["fit"]["nrmse"] < 0.02
    law = Orthotropic.of(document["parameters"])
    for angle in (15, 30, 60, 75):
        lines = [line for line in Path(file(angle)).read_text().splitlines() if line[0].isdigit()]
        strain, stress = np.array([[float(v) for v in line.split(",")] for line in lines]).T / [
            [97.0],
            [75.0],
        ]
        ratio = strip(law, float(angle), [1.03]).stress[0] / np.interp(0.03, strain, stress)
        assert ratio == pytest.approx(1.0, abs=0.15)
