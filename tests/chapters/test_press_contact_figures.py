"""Every figure of press.json between blocks whose answer is a formula: two parallel faces, hot, and a wedge."""

from __future__ import annotations

import math

import numpy as np
import pytest

from hyperfab.io.stl_write import stl_bytes
from hyperfab.report.figures_press import SpottedMold, spotting

from .test_press_contact import FOAM, press

ALPHA, RISE = 23.6e-6, 180.0
GROWN = 1.0 + ALPHA * RISE


def block(x, y, low, high, cells, slope=0.0):
    """A block about the z axis; ``slope`` tilts the lower face along x."""
    across = [np.linspace(-side / 2, side / 2, cells + 1) for side in (x, y)]
    plan = np.stack(np.meshgrid(*across, indexing="ij"), axis=-1).reshape(-1, 2)
    number = np.arange(len(plan)).reshape(cells + 1, cells + 1)
    quads = np.stack([number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]], axis=-1).reshape(-1, 4)
    top = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    ring = [*number[:, 0], *number[-1, 1:], *number[-2::-1, -1], *number[0, -2:0:-1]]
    side = [
        face for a, b in zip(ring, ring[1:] + ring[:1], strict=True)
        for face in ([a + len(plan), b + len(plan), b], [a + len(plan), b, a])
    ]  # fmt: skip
    points = [
        np.column_stack([plan, 0 * plan[:, :1] + high]),
        np.column_stack([plan, low + slope * plan[:, :1]]),
    ]
    return np.concatenate(points), np.concatenate([top, top[:, ::-1] + len(plan), side])


def shop(folder, foam=FOAM, slope=0.0):
    """A male of 80 x 60 mm, its face at z = 0 and mounted at -30; a female mounted at 45, drawn 5 mm above it."""
    for name, solid in (("male", block(80, 60, -30, 0, 8)), ("female", block(130, 100, 5, 45, 7, slope))):
        (folder / f"{name}.stl").write_bytes(stl_bytes(*solid))
    (folder / "foam.toml").write_text(foam)


def test_parallel_faces_hot(tmp_path, monkeypatch):
    """Foam of 4.5 mm pressed to 3 mm, a third: 0.05/3 MPa everywhere; the faces have grown by alpha 180 K."""
    shop(tmp_path)
    status, found = press(tmp_path, monkeypatch, gap="3mm", temperature="200degC", zero="hot")
    assert status == 0
    area, pressure = 80.0 * 60.0 * GROWN**2, 0.05 / 3.0
    force = pressure * area
    for key in ("gap_min_mm", "gap_mean_mm", "gap_max_mm", "clearance_hot_mm"):
        assert found[key] == pytest.approx(3.0, rel=1e-9), key
    for key in ("gap_normal", "gap_axial"):
        assert found[key] == pytest.approx(
            {"min_mm": 3.0, "mean_mm": 3.0, "max_mm": 3.0, "missed_area_fraction": 0.0}, rel=1e-9
        )
    assert found["molding_area_mm2"] == pytest.approx(area, rel=1e-9)
    assert found["flange_area_mm2"] == 0.0
    assert found["contact_area_mm2"] == pytest.approx(area, rel=1e-9)
    assert found["contact_fraction"] == pytest.approx(1.0, rel=1e-9)
    assert found["force_N"] == pytest.approx(force, rel=1e-9)
    assert found["pressure_max_MPa"] == pytest.approx(pressure, rel=1e-9)
    assert found["pressure_mean_MPa"] == pytest.approx(pressure, rel=1e-9)
    assert found["energy_J"] == pytest.approx(1e-3 * 0.5 * force * 1.5, rel=1e-9)
    assert found["stroke_mm"] == pytest.approx(1.5, rel=1e-9)
    assert found["tilt_deg"] == 0.0
    x, y, z = found["centre_of_pressure_mm"]
    assert (x, y) == pytest.approx((0.0, 0.0), abs=1e-9)
    assert z == pytest.approx(30.0 * ALPHA * RISE, rel=1e-6)  # hot, from where it is mounted
    (region,) = found["regions"]
    assert region["contact"] is True
    assert region["area_mm2"] == pytest.approx(area, rel=1e-9)
    assert region["centroid_mm"] == pytest.approx([0.0, 0.0, 0.0], abs=1e-9)
    assert region["gap_mean_mm"] == pytest.approx(3.0, rel=1e-9)
    assert region["pressure_mean_MPa"] == pytest.approx(pressure, rel=1e-9)
    assert region["force_N"] == pytest.approx(force, rel=1e-9)
    assert found["states"] == pytest.approx(
        {"open_mm2": 0.0, "touching_mm2": area, "bottomed_mm2": 0.0, "interfering_mm2": 0.0}, abs=1e-6
    )
    # Cold, 30 mm of male and 40 mm of female have not grown towards each other.
    assert found["clearance_cold_mm"] == pytest.approx(3.0 + 70.0 * ALPHA * RISE, rel=1e-9)
    assert found["clearance_drawn_mm"] == pytest.approx(5.0, rel=1e-9)
    assert found["reference_temperature_degC"] == 20.0
    for name, mount in (("male", -30.0), ("female", 45.0)):
        told = found[name]
        assert told["temperature_degC"] == 200.0
        assert told["expansion_1_K"] == pytest.approx(ALPHA, rel=1e-12)
        assert told["growth_strain"] == pytest.approx(ALPHA * RISE, rel=1e-9)
        assert told["mount_mm"] == pytest.approx(mount, rel=1e-9)
    assert found["sandwich_mm"] == pytest.approx(4.5, rel=1e-12)
    assert found["chord_error_mm"] == pytest.approx(0.0, abs=1e-9)
    assert found["border_area_fraction"] == found["oblique_area_fraction"] == 0.0
    np.testing.assert_allclose(found["force_stroke"], [[s, force * s / 1.5] for s in np.linspace(0, 1.5, 5)], atol=1e-6)
    assert sum(found["histogram"]["area_mm2"]) == pytest.approx(area, rel=1e-9)
    assert found["datum_mm"][2] == pytest.approx(0.0, abs=1e-9)
    assert found["gap_min_at_mm"][2] == pytest.approx(0.0, abs=1e-9)


def test_levers_between_parallel_faces(tmp_path, monkeypatch):
    """A turn by one degree about an axis moves a face of side L by (pi/180) L/sqrt(12), root of the mean square."""
    shop(tmp_path)
    _, found = press(tmp_path, monkeypatch, gap="3mm", temperature="200degC", zero="hot")
    degree, strain = math.pi / 180.0, ALPHA * RISE
    tilt = {axis: degree * side * GROWN / math.sqrt(12.0) for axis, side in (("second", 80.0), ("first", 60.0))}
    # Rates of the hot faces: what has grown grows on.
    stated = {
        "stroke": (1.0, -1.0, 0.1),
        "foam thickness": (1.0, -1.0, 0.1),
        "height of the male's mounting face": (strain, strain, 10.0),
        "height of the female's mounting face": (strain, -strain, 10.0),
        "tilt of the female about the second axis": (tilt["second"], None, 0.05),
        "tilt of the female about the first axis": (tilt["first"], None, 0.05),
        "temperature of the male alone": (ALPHA * 30.0 * GROWN, -ALPHA * 30.0 * GROWN, 10.0),
        "temperature of the female alone": (None, None, 10.0),
        "shift of the female across, first axis": (0.0, 0.0, 0.1),
        "shift of the female across, second axis": (0.0, 0.0, 0.1),
    }
    told = {lever["change"]: lever for lever in found["sensitivity"]}
    assert told.keys() == stated.keys()
    for name, (rms, closest, step) in stated.items():
        lever = told[name]
        assert lever["typical_step"] == step
        assert lever["gap_rms_at_step_mm"] == pytest.approx(lever["gap_rms_mm_per_unit"] * step, rel=1e-12)
        if rms is not None:
            # Vertices stand for a quarter of the cells around them: a grid of 8 cells is 1/64 too wide.
            assert lever["gap_rms_mm_per_unit"] == pytest.approx(rms, rel=0.02, abs=1e-9), name
        if closest is not None:
            assert lever["closest_gap_mm_per_unit"] == pytest.approx(closest, rel=1e-6, abs=1e-9), name
    # The female's face hangs 40 mm, grown, below where it is mounted.
    female = told["temperature of the female alone"]["gap_rms_mm_per_unit"]
    assert female == pytest.approx(ALPHA * 40.0 * GROWN, rel=1e-3)
    sizes = [lever["gap_rms_at_step_mm"] for lever in found["sensitivity"]]
    assert sizes == sorted(sizes, reverse=True)


def test_a_wedge(tmp_path, monkeypatch):
    """A female that rises by 5 % along x: part of the sandwich touches, the rest is open; integrals over x."""
    slope = 0.05
    shop(tmp_path, slope=slope)
    status, found = press(tmp_path, monkeypatch, gap="2mm", facets="flat")
    assert status == 0
    cosine = 1.0 / math.hypot(1.0, slope)
    low = 2.0  # the least axial clearance, at x = -40
    axial = lambda x: low + slope * (x + 40.0)  # noqa: E731
    assert found["clearance_cold_mm"] == pytest.approx(low, rel=1e-9)
    assert found["gap_axial"] == pytest.approx(
        {"min_mm": 2.0, "mean_mm": 4.0, "max_mm": 6.0, "missed_area_fraction": 0.0}, rel=1e-6
    )
    assert found["gap_normal"]["mean_mm"] == pytest.approx(4.0, rel=1e-6)  # the male's face is level
    assert [found[f"gap_{what}_mm"] for what in ("min", "mean", "max")] == pytest.approx(
        [2.0 * cosine, 4.0 * cosine, 6.0 * cosine], rel=1e-6
    )
    assert found["gap_min_at_mm"][0] == pytest.approx(-40.0, abs=1e-6)
    # Touched where the gap is below 4.5 mm, along the axis or the nearest (0.2 % apart); p = 0.05 (1 - gap/4.5).
    length = (4.5 / cosine - low) / slope
    assert found["contact_area_mm2"] == pytest.approx(60.0 * length, rel=4e-3)
    assert found["contact_fraction"] == pytest.approx(length / 80.0, rel=4e-3)
    assert found["states"]["open_mm2"] == pytest.approx(60.0 * (80.0 - length), rel=6e-3)
    most = 0.05 * (1.0 - 2.0 * cosine / 4.5)
    assert found["pressure_max_MPa"] == pytest.approx(most, rel=1e-6)
    assert found["pressure_mean_MPa"] == pytest.approx(most / 2.0, rel=0.03)
    # Pressure is along the nearest direction: the press feels its part along z.
    load = 60.0 * length * most / 2.0
    assert found["force_N"] == pytest.approx(load * cosine, rel=0.03)
    energy = 60.0 * (4.5 / 2.0 / 0.05) * most**2 * length / 3.0
    assert found["energy_J"] == pytest.approx(1e-3 * energy, rel=0.03)
    # A triangle of pressure acts at a third of its length.
    assert found["centre_of_pressure_mm"][0] == pytest.approx(-40.0 + length / 3.0, abs=0.6)
    touching, apart = sorted(found["regions"], key=lambda region: not region["contact"])
    assert touching["area_mm2"] == pytest.approx(60.0 * length, rel=4e-3)
    assert touching["centroid_mm"][0] == pytest.approx(-40.0 + length / 2.0, abs=0.1)
    assert touching["gap_mean_mm"] == pytest.approx(cosine * axial(-40.0 + length / 2.0), rel=0.01)
    assert apart["gap_mean_mm"] == pytest.approx(cosine * axial(length / 2.0), rel=0.01)
    assert apart["pressure_mean_MPa"] == pytest.approx(0.0, abs=1e-4)
    edges, areas = np.array(found["histogram"]["edges_mm"]), np.array(found["histogram"]["area_mm2"])
    middle = areas @ (0.5 * (edges[1:] + edges[:-1])) / areas.sum()
    assert middle == pytest.approx(4.0 * cosine, abs=0.1)
    assert areas.sum() == pytest.approx(4800.0, rel=1e-9)


def test_foam_that_is_crushed_tired_and_springs_back(tmp_path, monkeypatch):
    """Foam between two fabrics that has lost thickness and stress to heat, is bottomed, and gives back 40 % of it."""
    (tmp_path / "foam.csv").write_text("strain [-],stress [MPa]\n0,0\n0.2,0.004\n0.5,0.01\n")
    foam = FOAM.replace('{ law = "linear", modulus = "0.05 MPa" }', '{ table = "foam.csv" }').replace(
        'thickness = "4.5 mm"',
        """thickness = "4.5 mm"
fabric = { above = "0.2 mm", below = "0.3 mm" }
shrinkage = { amount = 0.1, time = "10 s", dwell = "20 s", recovery = 0.4 }
relaxation = { share = 0.2, time = "10 s", dwell = "20 s" }""",
    )
    shop(tmp_path, foam)
    _, found = press(tmp_path, monkeypatch, gap="2mm")
    gone = 1.0 - math.exp(-2.0)
    whole, left = 4.5 * (1.0 - 0.1 * gone), 1.0 - 0.2 * gone
    strain = 1.0 - 1.5 / whole
    assert found["foam_shrinkage"] == pytest.approx(0.1 * gone, rel=1e-9)
    assert found["foam_relaxation"] == pytest.approx(0.2 * gone, rel=1e-9)
    assert found["sandwich_mm"] == pytest.approx(whole + 0.5, rel=1e-9)
    # Beyond the last row along its slope, 0.02 MPa.
    assert found["pressure_max_MPa"] == pytest.approx(left * 0.02 * strain, rel=1e-9)
    assert found["force_N"] == pytest.approx(4800.0 * left * 0.02 * strain, rel=1e-9)
    assert found["states"]["bottomed_mm2"] == pytest.approx(4800.0, rel=1e-9)
    assert found["states"]["touching_mm2"] == pytest.approx(0.0, abs=1e-6)
    assert found["final_thickness"]["mean_mm"] == pytest.approx(2.0 + 0.4 * (whole - 1.5), rel=1e-9)
    assert found["energy_J"] == pytest.approx(1e-3 * 4800.0 * whole * left * 0.5 * 0.02 * strain**2, rel=1e-9)


def test_a_yielding_frame_and_a_force_off_centre(tmp_path, monkeypatch):
    """Parallel faces as springs: k = E A/t, the frame in a row; floating, a force aside tilts by M/(E I/t + F h)."""
    shop(tmp_path)
    _, soft = press(tmp_path, monkeypatch, gap="3mm", frame_stiffness="100N/mm")
    stiffness = 0.05 * 4800.0 / 4.5
    force = 1.5 * stiffness * 100.0 / (stiffness + 100.0)
    assert soft["force_N"] == pytest.approx(force, rel=1e-6)
    assert soft["frame_stiffness_N_mm"] == 100.0
    assert soft["clearance_cold_mm"] == pytest.approx(3.0 + force / 100.0, rel=1e-6)
    assert soft["clearance_to_set_mm"] == pytest.approx(3.0, rel=1e-6)
    _, aside = press(tmp_path, monkeypatch, force="80N", floating=True, force_at="1mm,0mm")
    # Pressure turns with the female's face, 43 mm below where it is mounted: that much more moment against the tilt.
    turning = 0.05 / 4.5 * 60.0 * 80.0**3 / 12.0 + 80.0 * 43.0
    assert aside["tilt_deg"] == pytest.approx(math.degrees(80.0 / turning), rel=2e-3)
    assert aside["tilt_vector_deg"] == pytest.approx([0.0, aside["tilt_deg"], 0.0], abs=1e-4)
    # The line of the force runs through the place asked for, where the female is mounted.
    at_face = 1.0 - 43.0 * math.radians(aside["tilt_deg"])
    assert aside["centre_of_pressure_mm"][0] == pytest.approx(at_face, abs=1e-3)


def lathed(radius, height, around):
    """Points and outward facets of a surface turned about z, its profile from the top on the axis outward."""
    phi = 2.0 * np.pi * np.arange(around) / around
    rings = [
        np.column_stack([r * np.cos(phi), r * np.sin(phi), 0.0 * phi + z]) for r, z in zip(radius, height, strict=True)
    ]
    j, faces = np.arange(around), []
    k = (j + 1) % around
    points = np.concatenate([[[0.0, 0.0, height[0]]], *rings[1:]])
    faces.append(np.column_stack([0 * j, 1 + j, 1 + k]))
    for i in range(len(radius) - 2):
        a, b = 1 + i * around, 1 + (i + 1) * around
        faces += [np.column_stack([a + j, b + j, b + k]), np.column_stack([a + j, b + k, a + k])]
    return points, np.concatenate(faces)


def test_touched_and_pressed_area_of_a_ball_in_a_cone_are_one(tmp_path, monkeypatch):
    """R = 40 mm under a cone whose wall slopes by 55 degrees, D from the ball's middle.

    Along the ball's normal at theta from the top the cone is D / cos(theta - 55 deg) away: the sandwich of 4.5 mm is
    touched up to d on both sides of 55 degrees, cos d = D / (R + 4.5), and the ring there is 4 pi R^2 sin 55 deg sin d.
    """
    ball, slope, thick, gap = 40.0, math.radians(55.0), 4.5, 4.3
    theta = np.linspace(0.0, math.radians(85.0), 71)
    points, faces = lathed(ball * np.sin(theta), ball * np.cos(theta), 96)
    (tmp_path / "male.stl").write_bytes(stl_bytes(points, faces))
    radius = np.linspace(0.0, 60.0, 61)
    points, faces = lathed(radius, 100.0 - radius * math.tan(slope), 108)
    (tmp_path / "female.stl").write_bytes(stl_bytes(points, faces[:, ::-1]))
    (tmp_path / "foam.toml").write_text(FOAM)
    _, found = press(tmp_path, monkeypatch, gap=f"{gap}mm", strokes=3)
    far = ball + gap * math.cos(slope)
    side = math.acos(far / (ball + thick))
    area = 4.0 * math.pi * ball**2 * math.sin(slope) * math.sin(side)
    assert found["contact_area_mm2"] == pytest.approx(area, rel=2e-3)
    rows = np.genfromtxt(tmp_path / "press.csv", delimiter=",", names=True)
    assert rows["pressed_area_mm2"][-1] == pytest.approx(found["contact_area_mm2"], rel=1e-9)
    # Halfway, after half the stroke.
    half = ball + (gap + 0.5 * found["stroke_mm"]) * math.cos(slope)
    side = math.acos(half / (ball + thick))
    area = 4.0 * math.pi * ball**2 * math.sin(slope) * math.sin(side)
    assert rows["pressed_area_mm2"][1] == pytest.approx(area, rel=5e-3)


def test_touched_and_pressed_area_of_flat_faces_are_the_face(tmp_path, monkeypatch):
    shop(tmp_path)
    _, found = press(tmp_path, monkeypatch, gap="3mm", strokes=3)
    rows = np.genfromtxt(tmp_path / "press.csv", delimiter=",", names=True)
    assert rows["pressed_area_mm2"][1:] == pytest.approx(found["molding_area_mm2"], rel=1e-12)
    assert found["contact_area_mm2"] == pytest.approx(found["molding_area_mm2"], rel=1e-12)


@pytest.mark.pictures
@pytest.mark.parametrize("apart", [0.0, 1e-15, 1e-9, 0.5])
def test_gaps_that_hardly_differ_are_drawn_too(apart):
    places = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    gap = 4.0 + apart * np.arange(3)
    mold = SpottedMold(
        places, np.array([[0, 1, 2]]), np.tile([0.0, 0.0, 1.0], (3, 1)), gap, 0.0 * gap, 5.0 - gap, np.ones(3), 5.0,
        ("x", "y"),
    )  # fmt: skip
    assert spotting(mold, np.array([[0.0, 0.0], [1.0, 2.0]]), "even").startswith(b"\x89PNG")
