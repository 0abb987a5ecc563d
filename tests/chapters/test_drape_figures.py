"""Every figure of drape.json on a sheet that is only stretched, whose answer is a formula, and on a ball by balance."""

from __future__ import annotations

import json

import numpy as np
import pytest

from .test_drape import drape, folder  # noqa: F401

C, THICK = 0.2, 0.8


def nominal(stretch: float) -> float:
    return 2.0 * C * (stretch - stretch**-2)


def energy(stretch: float) -> float:
    return C * (stretch**2 + 2.0 / stretch - 3.0)


def test_a_sheet_that_is_only_stretched(drape, folder):  # noqa: F811
    """200 x 180 mm, mounted stretched by 1.2 and 1.1, the mold's top just at the sheet."""
    import meshio

    status, _, _ = drape("--depth", "0mm", "--prestretch", "1.2x1.1", "-o", "d.json")
    found = json.loads((folder / "d.json").read_text())
    assert status == 0
    assert found["converged"] is True
    assert found["stress_warp_max_MPa"] == pytest.approx(nominal(1.2), rel=1e-8)
    assert found["stress_weft_max_MPa"] == pytest.approx(nominal(1.1), rel=1e-8)
    stored = (energy(1.2) + energy(1.1)) * 200.0 / 1.2 * 180.0 / 1.1 * THICK
    assert found["energy_J"] == pytest.approx(1e-3 * stored, rel=1e-8)
    assert found["force_N"] == pytest.approx(0.0, abs=1e-6)
    assert found["slack_springs"] == 0
    assert found["thickness_mm"] == THICK
    assert found["thickness_min_mm"] == pytest.approx(THICK / 1.32, rel=1e-8)
    assert (found["grid"], found["size_mm"], found["depth_mm"]) == ([31, 21], [200.0, 180.0], 0.0)
    assert found["prestretch"] == [1.2, 1.1]
    assert found["warp"]["stretch_max"] == pytest.approx(1.2, rel=1e-9)
    assert found["weft"]["stretch_max"] == pytest.approx(1.1, rel=1e-9)
    assert found["mold"]["shift_mm"][2] == pytest.approx(-60.0, rel=1e-9)
    assert found["mold"]["facets"] == 1280
    field = meshio.read(folder / "d.vtu")
    assert field.point_data["stress_warp_MPa"] == pytest.approx(np.full(651, nominal(1.2)), rel=1e-8)
    assert field.point_data["stress_weft_MPa"] == pytest.approx(np.full(651, nominal(1.1)), rel=1e-8)
    assert field.cell_data["stretch_warp"][0] == pytest.approx(np.full(600, 1.2), rel=1e-8)
    assert field.cell_data["stretch_weft"][0] == pytest.approx(np.full(600, 1.1), rel=1e-8)


def test_a_sheet_stretched_too_far_says_how_many_springs_and_where(drape):  # noqa: F811
    status, out, _ = drape("--depth", "0mm", "--prestretch", "1.2x1.1", "--max-stretch", "1.15")
    found = json.loads(out)
    assert status == 1
    assert found["max_stretch"] == 1.15
    assert found["over_max_stretch"] == 30 * 21
    x, y = found["over_max_stretch_at_mm"]
    assert abs(x) <= 100.0
    assert abs(y) <= 90.0


def test_what_is_told_of_a_ball_fits_together(drape, folder):  # noqa: F811
    """Force, stress and thickness of the document are those of its field, and the field obeys the law and balances."""
    import meshio

    drape("-o", "d.json")
    found = json.loads((folder / "d.json").read_text())
    field = meshio.read(folder / "d.vtu")
    points, at = field.points.reshape(31, 21, 3), field.point_data
    along = np.linalg.norm(np.diff(points, axis=0), axis=2) / (200.0 / 30.0)
    across = np.linalg.norm(np.diff(points, axis=1), axis=2) / (180.0 / 20.0)
    assert found["warp"]["stretch_max"] == pytest.approx(along.max(), rel=1e-6)
    assert found["weft"]["stretch_max"] == pytest.approx(across.max(), rel=1e-6)
    assert found["slack_springs"] == int((along < 1.0 - 1e-9).sum() + (across < 1.0 - 1e-9).sum())
    springs = np.where(along > 1.0, nominal(along), 0.0)
    padded = np.concatenate([springs[:1], springs, springs[-1:]])
    nodal = 0.5 * (padded[1:] + padded[:-1])
    assert found["stress_warp_max_MPa"] == pytest.approx(nodal.max(), rel=1e-6)
    assert at["stress_warp_MPa"].reshape(31, 21) == pytest.approx(nodal, abs=1e-6)
    stored = sum(
        float((np.where(s > 1.0, energy(s), 0.0) * rest * width).sum()) * THICK
        for s, rest, width in (
            (along, 200.0 / 30.0, 9.0 * np.r_[0.5, np.ones(19), 0.5]),
            (across, 180.0 / 20.0, 200.0 / 30.0 * np.r_[0.5, np.ones(29), 0.5][:, None]),
        )
    )
    assert found["energy_J"] == pytest.approx(1e-3 * stored, rel=1e-6)
    assert at["contact_force_N"][:, 2].sum() == pytest.approx(found["force_N"], rel=1e-6)
    # The press works against what is stored: at this depth the force is the slope of the energy.
    energies = []
    for depth in ("49.9mm", "50.1mm"):
        _, out, _ = drape("--depth", depth)
        energies.append(json.loads(out)["energy_J"])
    assert found["force_N"] == pytest.approx((energies[1] - energies[0]) / 0.2e-3, rel=2e-3)
    assert int(at["contact"].sum()) == found["contact_nodes"]
    diagonal = points[1:, 1:] - points[:-1, :-1], points[:-1, 1:] - points[1:, :-1]
    area = 0.5 * np.linalg.norm(np.cross(*diagonal), axis=2)
    thinnest = THICK * (200.0 / 30.0) * 9.0 / area.max()
    assert found["thickness_min_mm"] == pytest.approx(thinnest, rel=1e-6)
    assert found["residual_relative"] == pytest.approx(found["residual_max_N"] / largest(along, across), rel=1e-3)


def test_what_is_out_of_balance_is_what_mold_and_clamps_do_not_hold(drape, folder):  # noqa: F811
    """Stopped long before rest, at 40 degC: contact forces, and the springs at the clamped edges, summed by hand."""
    import meshio

    fabric = json.loads((folder / "fabric.json").read_text())
    same = [{"temperature_degC": degrees, "parameters": fabric["parameters"]} for degrees in (20.0, 60.0)]
    (folder / "warm.json").write_text(json.dumps({**fabric, "temperatures": same}))
    options = ("--solver", "relaxation", "--steps", "40", "--temperature", "40degC", "-o", "d.json")
    assert drape(*options, fabric="warm.json")[0] == 4
    found = json.loads((folder / "d.json").read_text())
    assert found["temperature_degC"] == 40.0
    field = meshio.read(folder / "d.vtu")
    points, pull = field.points.reshape(31, 21, 3), np.zeros((31, 21, 3))
    for axis, rest, width, ends in ((0, 200.0 / 30.0, 9.0, 21), (1, 9.0, 200.0 / 30.0, 31)):
        way = np.diff(points, axis=axis)
        length = np.linalg.norm(way, axis=2, keepdims=True)
        share = np.r_[0.5, np.ones(ends - 2), 0.5].reshape((1, -1, 1) if axis == 0 else (-1, 1, 1))
        force = np.where(length > rest, nominal(length / rest), 0.0) * width * share * THICK * way / length
        pull[: -1 if axis == 0 else None, : -1 if axis == 1 else None] += force
        pull[1 if axis == 0 else 0 :, 1 if axis == 1 else 0 :] -= force
    pull[1:-1, 1:-1] = 0.0
    left = field.point_data["contact_force_N"].sum(axis=0) - pull.sum(axis=(0, 1))
    assert found["imbalance_N"] > 0.1
    assert found["imbalance_N"] == pytest.approx(np.abs(left).max(), rel=1e-6)


def largest(along: np.ndarray, across: np.ndarray) -> float:
    """The largest force of a spring [N]."""
    width = (9.0 * np.r_[0.5, np.ones(19), 0.5], 200.0 / 30.0 * np.r_[0.5, np.ones(29), 0.5][:, None])
    return max(float((nominal(s) * w * THICK).max()) for s, w in zip((along, across), width, strict=True))


def test_what_rubs_is_accounted_for_with_its_size(drape):  # noqa: F811
    _, out, _ = drape("--friction", "0.3")
    found = json.loads(out)
    told = found["rubbing"]
    balance = (told["work_J"] - found["energy_J"] - told["rubbed_J"] - told["drawn_J"]) / told["work_J"]
    assert told["balance_relative"] == pytest.approx(balance, rel=1e-9)
    assert abs(balance) < 5e-3
    assert told["drawn_J"] == 0.0
    assert 0.02 * found["energy_J"] < told["rubbed_J"] < 0.2 * found["energy_J"]
    assert told["sticking_nodes"] + told["sliding_nodes"] == found["contact_nodes"]
    assert told["load_steps"] >= 5


def test_a_picture_does_not_span_what_the_memory_held(monkeypatch):
    """Facets of the mold and cells of the sheet in one collection: where these have not as many corners, matplotlib
    fills up those that have fewer with memory as it lies there, and its axes span that too."""
    from types import SimpleNamespace

    from matplotlib.colors import Normalize
    from matplotlib.figure import Figure

    from hyperfab.report.figures_drape import Draped, _scene

    x, y = np.meshgrid([0.0, 1.0, 2.0], [0.0, 1.0, 2.0], indexing="ij")
    points = np.stack([x, y, x * y], axis=2)
    peak = ([1.0, 1.0], [1.0, 1.0, 1.0])
    mold = np.array([[0.0, 0.0, 3.0], [2.0, 0.0, 1.0], [0.0, 2.0, 2.0]]), np.array([[0, 1, 2]])
    plain = np.empty
    monkeypatch.setattr(np, "empty", lambda *shape, **kind: np.full_like(plain(*shape, **kind), 1e300))
    scene = Figure().add_subplot(projection="3d")
    _scene(scene, Draped(points, points, SimpleNamespace(), peak, mold), np.ones((2, 2)), Normalize(0.0, 1.0))
    assert scene.xy_dataLim.get_points() == pytest.approx(np.array([[0.0, 0.0], [2.0, 2.0]]))
    assert scene.zz_dataLim.get_points()[:, 0] == pytest.approx([0.0, 4.0])
