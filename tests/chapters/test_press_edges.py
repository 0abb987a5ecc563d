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
