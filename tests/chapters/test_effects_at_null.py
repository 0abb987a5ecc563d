"""Every effect of a fabric at its null, written into the document: the forward commands give the same bits."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from loop.generators import fabric as truths

from hyperfab.cases.options import read
from hyperfab.cases.registry import case_class
from hyperfab.chapters.rerun import rerun
from hyperfab.curve import TestCurve
from hyperfab.io.stl_write import stl_bytes
from hyperfab.loop.fabric import fabric_problem
from hyperfab.materials.effects.path import MODE_NAMES
from hyperfab.materials.registry import law

CONSTANTS = {"C10_MPa": 0.06, "C20_MPa": 0.02, "C30_MPa": 0.017}
MODEL: dict[str, Any] = {"format": "hyperfab.material/1", "model": "yeoh-3", "parameters": CONSTANTS}
CONTACT = (
    "fabric-contact", "--shape", "disc", "--size", "200mm", "--thickness", "1mm", "--sphere-radius", "40mm", "--depth",
    "10mm", "--steps", "2", "--mesh-size", "20mm",
)  # fmt: skip
DRAPE = ("drape", "--mold", "ball.stl", "--grid", "15x13", "--size", "200mmx180mm", "--depth", "40mm")


def null_effects() -> dict[str, list[dict[str, Any]]]:
    """Every form of every entry of the catalogue at its null, as a material document writes it, by the entry's id."""
    pull = np.concatenate([np.linspace(1.0, 1.5, 9), np.linspace(1.5, 1.0, 9)])
    tests = [
        TestCurve(
            MODE_NAMES[k % 2],
            pull,
            pull - 1.0,
            time_s=np.arange(18.0),
            temperature_degC=np.full(18, 23.0 + 20.0 * k),
            direction=45.0 * k,
            source=f"t{k}",
        )
        for k in range(3)
    ]
    problem = fabric_problem(law("yeoh-3"), list(CONSTANTS.values()), tests)
    return {
        effect.id: [
            {
                "id": effect.id,
                "form": form.name,
                "parameters": {constant.name: constant.value for constant in form.constants},
                **({"reference_degC": 23.0} if effect.id == "thermal-softening" else {}),
            }
            for form in effect.forms
        ]
        for effect in problem.effects
    }


@pytest.fixture(scope="module")
def computed(tmp_path_factory) -> Callable[[tuple[str, ...], list[dict[str, Any]]], tuple[Any, Any]]:
    folder: Path = tmp_path_factory.mktemp("null")
    mesh = trimesh.creation.icosphere(subdivisions=2, radius=60.0)
    (folder / "ball.stl").write_bytes(stl_bytes(mesh.vertices, mesh.faces))

    def run(words: tuple[str, ...], effects: list[dict[str, Any]]) -> tuple[Any, Any]:
        command, *rest = words
        rest = [str(folder / word) if word == "ball.stl" else word for word in rest]
        name = str(folder / "fabric.json")
        document = {**MODEL, "effects": effects} if effects else MODEL
        (folder / "fabric.json").write_text(json.dumps(document))
        target = str(folder / "out.json")
        made = rerun(read(case_class(command), [name, *rest]), target)
        # What the document says of effects differs; nothing computed may.
        for part in (made.document, made.document.get("setup", {})):
            for key in ("effects", "left_out", "provenance", "sha256"):
                part.pop(key, None)
        return made.document, made.siblings

    return run


@pytest.mark.parametrize(
    "command", [pytest.param(CONTACT, marks=pytest.mark.slow), DRAPE], ids=["fabric-contact", "drape"]
)
def test_every_effect_at_its_null_leaves_every_bit(computed, command: tuple[str, ...]) -> None:
    plain, files = computed(command, [])
    effects = null_effects()
    assert set(effects) == set(truths.IDS)
    first = [forms[0] for forms in effects.values()]
    for given in (first, [form for forms in effects.values() for form in forms]):
        again, same = computed(command, given)
        assert again == plain
        assert same == files
