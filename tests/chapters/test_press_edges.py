"""hf press-contact beneath narrow features of the female: what lies between the corners of a large flat facet."""

import json

import numpy as np
import pytest
import trimesh

from hyperfab.cases.press import PressCase
from hyperfab.chapters import press_contact
from hyperfab.chapters.job import Job
from hyperfab.console import Console
from hyperfab.io.stl_write import stl_bytes

HALF, GAP, HIGH, THICK, MODULUS = 60.0, 3.0, 2.0, 4.5, 0.05
FOAM = f"""
format = "hyperfab.foam/1"
thickness = "{THICK} mm"
compression = {{ law = "linear", modulus = "{MODULUS} MPa" }}
"""


def prism(profile, inside):
    """An outline (k, 2) in x and z, in its order around ``inside`` and all seen from there, drawn out along y."""
    k = len(profile)
    ends = [np.insert(np.vstack([profile, [inside]]), 1, y, axis=1) for y in (-HALF, HALF)]
    i, j = np.arange(k), (np.arange(k) + 1) % k
    far = k + 1
    sides = [np.stack([i, j, j + far], axis=1), np.stack([i, j + far, i + far], axis=1)]
    caps = [np.stack([j, i, 0 * i + k], axis=1), np.stack([i + far, j + far, 0 * i + k + far], axis=1)]
    return np.concatenate(ends), np.concatenate(sides + caps)


def pressed(folder, monkeypatch, **molds):
    """The document of molds (vertices, faces) pressed to the gap."""
    monkeypatch.chdir(folder)
    for name, solid in molds.items():
        (folder / f"{name}.stl").write_bytes(stl_bytes(*solid))
    (folder / "foam.toml").write_text(FOAM)
    given = {"male": "male.stl", "female": "female.stl", "foam": "foam.toml", "gap": f"{GAP} mm", "strokes": 2}
    case = PressCase.of({name: str(text) for name, text in given.items()})
    assert press_contact.run(Job("press-contact", [], Console(quiet=True), target="press.json"), case) == 0
    return json.loads((folder / "press.json").read_text())


def plate():
    return prism(np.array([[-HALF, -30.0], [-HALF, 0.0], [HALF, 0.0], [HALF, -30.0]]), [0.0, -15.0])


@pytest.mark.parametrize("wide", [1.0, 2.0, 4.0])
def test_a_rib_narrower_than_the_facets_beneath_is_felt(tmp_path, monkeypatch, wide):
    at = 1.3
    ribbed = [[-HALF, 40.0], [HALF, 40.0], [HALF, HIGH]]
    ribbed += [[at + wide / 2, HIGH], [at + wide / 2, 0.0], [at - wide / 2, 0.0], [at - wide / 2, HIGH], [-HALF, HIGH]]
    document = pressed(tmp_path, monkeypatch, male=plate(), female=prism(np.add(ribbed, [0.0, 10.0]), [at, 20.0]))
    # Beside the rib the nearest point is its edge, at d = hypot(gap, s): the pressure E (1 - d/t) leans by gap/d.
    s = np.sqrt(THICK**2 - GAP**2)
    beside = MODULUS / THICK * GAP * (THICK * np.arcsinh(s / GAP) - s)
    force = 2.0 * HALF * (wide * MODULUS * (1.0 - GAP / THICK) + 2.0 * beside)
    assert document["gap_min_mm"] == pytest.approx(GAP, abs=1e-6)
    assert document["contact_area_mm2"] == pytest.approx(2.0 * HALF * wide, rel=0.06)  # cells of 0.4 mm
    assert document["force_N"] == pytest.approx(force, rel=0.02)


def test_a_round_knob_smaller_than_the_facets_beneath_is_felt(tmp_path, monkeypatch):
    """No edge of it stands out; it rises from an edge that turns inward."""
    radius, turn = 2.0, np.radians(np.linspace(0.0, 90.0, 11))
    arc = np.stack([radius * np.sin(turn), -radius * np.cos(turn)], axis=1)
    knob = trimesh.creation.revolve(np.vstack([arc, [[90.0, 0.0], [90.0, 30.0], [0.0, 30.0]]]), sections=60)
    vertices = np.add(knob.vertices, [1.3, 2.2, 12.0])
    document = pressed(tmp_path, monkeypatch, male=plate(), female=(vertices, knob.faces))
    # Above it the normal gap is 3 mm and what the ball has risen there: 4.5 mm where it has by 1.5 of its 2 mm.
    across = np.pi * (radius**2 - (radius - (THICK - GAP)) ** 2)
    assert document["gap_min_mm"] == pytest.approx(GAP, abs=0.01)
    assert document["contact_area_mm2"] == pytest.approx(across, rel=0.06)


def body(outline, about=64):
    """An outline (k, 2) of radii and heights, from the axis to the axis, turned about z: vertices and faces."""
    solid = trimesh.creation.revolve(np.array(outline, dtype=float), sections=about)
    return solid.vertices, solid.faces


@pytest.mark.parametrize("degrees", [30.0, 45.0])
@pytest.mark.parametrize("rings", [1, 5])
def test_a_cone_that_ends_in_an_upright_wall_is_touched_as_far_as_each_side_of_its_edge_is(
    tmp_path, monkeypatch, degrees, rings
):
    """The female goes on beyond the wall; along it the gap is wider than along the cone, and grows downwards."""
    turn, inner, outer = np.radians(degrees), 25.0, 45.0
    high, wide, low = (outer - inner) * np.tan(turn), outer + 10.0, -10.0 * np.tan(turn)
    cone = np.linspace([inner, high], [outer, 0.0], rings + 1)
    wall = np.linspace([outer, 0.0], [outer, -30.0], rings + 1)
    male = [[0.0, -30.0], *wall[::-1], *cone[::-1][1:], [0.0, high]]
    female = [[0.0, high], [inner, high], [wide, low], [80.0, low], [80.0, high + 40.0], [0.0, high + 40.0]]
    document = pressed(tmp_path, monkeypatch, male=body(male), female=body(np.add(female, [0.0, 10.0]), 70))
    # Along the wall the gap is that of the cone at its height, GAP / tan(turn), and grows by 1 / tan(turn) downwards.
    wall = max(THICK * np.tan(turn) - GAP, 0.0)
    area = np.pi * (inner**2 + (outer**2 - inner**2) / np.cos(turn) + 2.0 * outer * wall)
    assert document["contact_area_mm2"] == pytest.approx(area, rel=4e-3)  # 64 chords to a circle


@pytest.mark.parametrize(
    "turns", [(37.0,), pytest.param((17.0, 45.0, 90.0), marks=pytest.mark.slow)], ids=["37", "others"]
)
def test_a_turn_of_the_press_about_its_axis_changes_nothing(tmp_path, monkeypatch, turns):
    """Large facets of both, a narrower female, and a rib: all that facets are cut by. No end is above another, where
    rounding tells whether it is met."""
    ribbed = [[-30.0, 40.0], [40.0, 40.0], [40.0, HIGH], [2.3, HIGH], [2.3, 0.0], [0.3, 0.0], [0.3, HIGH]]
    vertices, faces = prism(np.add([*ribbed, [-30.0, HIGH]], [0.0, 10.0]), [1.3, 20.0])
    female = vertices * [1.0, 1.1, 1.0], faces
    found = []
    for degrees in (0.0, *turns):
        cosine, sine = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
        turn = np.array([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]])
        molds = {name: (solid[0] @ turn.T, solid[1]) for name, solid in (("male", plate()), ("female", female))}
        document = pressed(tmp_path, monkeypatch, **molds)
        found.append([document[key] for key in ("force_N", "contact_area_mm2", "gap_mean_mm", "energy_J")])
    assert found == [pytest.approx(found[0], rel=1e-5)] * len(found)  # rounding of an STL


def box(low, high):
    solid = trimesh.creation.box(bounds=[low, high])
    return solid.vertices, solid.faces


def together(*solids):
    starts = np.cumsum([0, *(len(vertices) for vertices, _ in solids)])
    faces = [faces + start for (_, faces), start in zip(solids, starts, strict=False)]
    return np.concatenate([vertices for vertices, _ in solids]), np.concatenate(faces)


@pytest.mark.parametrize(
    "beside",
    [
        box([-150.0, -150.0, -60.0], [150.0, 150.0, -40.0]),  # a bolster under the male, wider than it
        box([110.0, -20.0, -60.0], [150.0, 20.0, -45.0]),  # a clamp
        (box([-30.0, -5.0, -25.0], [30.0, 5.0, -15.0])[0], box([0.0] * 3, [1.0] * 3)[1][:, ::-1]),  # a channel in it
    ],
)
def test_what_lies_below_or_within_the_male_is_none_of_its_molding_surface(tmp_path, monkeypatch, beside):
    male = [[0.0, -40.0], [100.0, -40.0], [100.0, -30.0], [60.0, -30.0], [40.0, 0.0], [0.0, 0.0]]
    female = [[0.0, 0.0], [40.0, 0.0], [60.0, -30.0], [100.0, -30.0], [100.0, 40.0], [0.0, 40.0]]
    alone, other = (
        pressed(tmp_path, monkeypatch, male=solid, female=body(np.add(female, [0.0, 10.0])))
        for solid in (body(male), together(body(male), beside))
    )
    for key in ("contact_fraction", "molding_area_mm2", "gap_mean_mm", "gap_max_mm"):
        assert other[key] == pytest.approx(alone[key], rel=1e-3), key
    assert alone["flange_area_mm2"] == pytest.approx(np.pi * (100.0**2 - 60.0**2), rel=2e-3)
