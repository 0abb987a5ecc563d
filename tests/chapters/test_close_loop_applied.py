"""What the loop computes with an added effect is what the forward command computes from the case that is written."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh

from hyperfab.cases import options
from hyperfab.cases.contact import ContactCase
from hyperfab.cases.drape import DrapeCase
from hyperfab.chapters.close_loop.contact import Forward as Pressed
from hyperfab.chapters.close_loop.drape import Forward as Draped
from hyperfab.chapters.close_loop.extended_sheet import contact_applied, drape_applied
from hyperfab.chapters.drape.model import at_depths, model_of, read_files
from hyperfab.chapters.fabric_contact.setup import read_geometry, setup_of
from hyperfab.chapters.job import Job
from hyperfab.chapters.sheet import read_fabric
from hyperfab.console import Console
from hyperfab.documents.base import parse_document
from hyperfab.documents.material import MaterialDocument
from hyperfab.io.stl_write import stl_bytes
from hyperfab.loop.catalogue import contact, drape
from hyperfab.loop.problem import Effect

FABRIC: dict[str, Any] = {
    "format": "hyperfab.material/1",
    "model": "neo-hookean",
    "parameters": {"C10_MPa": 0.2},
    "thickness_mm": 0.8,
}


#: The entries as an emulator scales them that reaches so far.
DRAPE = drape.entries(drape.DataContext((0.02, 0.05), 0.4, 0.03, 900.0, 0.0, 7.0))
CONTACT = contact.entries(contact.DataContext((20.0, 40.0, 60.0), 20.0, (0.0, 0.05), 0.4, 1.0, 1.0, 1.5, 6.0))


def settings_of(effects: tuple[Effect, ...]) -> list[dict[str, float]]:
    """Return what each form of each entry adds where its search begins; a clamp that holds at first has no key."""
    found = []
    for effect in effects:
        for form in effect.forms:
            added: dict[str, float] = {}
            for constant, value in zip(form.constants, form.starts[0], strict=True):
                for place in constant.places:
                    added[place] = added.get(place, 0.0) + value + constant.scale
            added.pop("hold", None)
            if added and added not in found:
                found.append(added)
    return found


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    mesh = trimesh.creation.icosphere(subdivisions=2, radius=60.0)
    (tmp_path / "ball.stl").write_bytes(stl_bytes(mesh.vertices, mesh.faces))
    (tmp_path / "fabric.json").write_text(json.dumps(FABRIC))
    monkeypatch.chdir(tmp_path)
    return tmp_path


def quiet(command: str) -> Job:
    return Job(command, [], Console(True))


@pytest.mark.parametrize(
    "given",
    [
        [],
        ["--prestretch", "1.02x1.03", "--mass", "200g/m^2", "--shear-modulus", "20kPa", "--offset", "-2mmx1.5mm"],
    ],
)
@pytest.mark.parametrize(
    "settings",
    [
        {},
        {"depth": 0.7},
        *settings_of(DRAPE),
        {"prestretch": 0.02, "mass": 300.0, "shear": 0.01, "depth": -0.4},
    ],
    ids=lambda one: "+".join(one) or "none",
)
def test_a_drape_with_effects_rests_where_hf_drape_lays_it(
    folder: Path, given: list[str], settings: dict[str, float]
) -> None:
    words = [
        "fabric.json",
        "--mold",
        "ball.stl",
        "--grid",
        "13x11",
        "--size",
        "200mmx180mm",
        "--depth",
        "20mm",
    ]
    # The loop goes the way of the mold in ten steps where something rubs.
    steps = ["--load-steps", "10"] if "friction" in settings else []
    case = options.read(DrapeCase, [*words, *given])
    document = parse_document(FABRIC, "fabric.json", MaterialDocument)
    forward = Draped(quiet("close-loop"), case, document)
    thought = forward.nodes(np.ones(len(forward.names)), settings)
    written = options.read(DrapeCase, [*options.words(drape_applied(case, settings)), *steps])
    model = model_of(written, read_files(quiet("drape"), written))
    state = list(at_depths(model, lambda depth, step: None))[-1]
    rests = np.asarray(state.found.state.x)
    np.testing.assert_allclose(thought, rests, rtol=0.0, atol=1e-9 * np.abs(rests).max())


def test_every_constant_has_its_place_in_the_set_up() -> None:
    """But for softening with temperature, which is written as constants of the material at each temperature."""
    every = [*DRAPE, *(effect for effect in CONTACT if effect.id != "thermal-softening")]
    assert all(constant.places for effect in every for form in effect.forms for constant in form.constants)


@pytest.mark.parametrize("settings", [{}, *settings_of(CONTACT)], ids=lambda one: "+".join(one) or "none")
def test_a_punched_sheet_with_effects_is_the_one_that_is_written(folder: Path, settings: dict[str, float]) -> None:
    case = options.read(
        ContactCase,
        [
            "fabric.json",
            "--depth",
            "30mm",
            "--prestretch",
            "1.01",
            "--rim-slip",
            "0.1mm^2/N",
            "--frame-stiffness",
            "20N/mm",
        ],
    )
    document = parse_document(FABRIC, "fabric.json", MaterialDocument)
    thought = Pressed(quiet("close-loop"), case, document).test(settings)
    written = options.read(ContactCase, options.words(contact_applied(case, settings)))
    job = quiet("fabric-contact")
    fabric = read_fabric(job, written.material, written.temperature)
    test = setup_of(written, read_geometry(job, written), fabric).test(fabric)
    # On a coarser mesh of straight elements; all else is the same.
    assert replace(thought, mesh_size=0.0, order=0, law=test.law) == replace(test, mesh_size=0.0, order=0)
