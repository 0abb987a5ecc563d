"""What the loop computes with an added effect is what the model does that is written: every form, on a fabric."""

from __future__ import annotations

from functools import cache
from itertools import pairwise
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from laws.constants import CONSTANTS

from hyperfab.chapters.close_loop.extended import extend
from hyperfab.chapters.close_loop.fabric import pose
from hyperfab.chapters.close_loop.measured_tests import Measured
from hyperfab.curve import TestCurve
from hyperfab.documents.base import parse_document
from hyperfab.documents.material import MaterialDocument
from hyperfab.loop import fabric_constants
from hyperfab.loop.fabric import FabricProblem
from hyperfab.materials import bind
from hyperfab.materials.effects.path import MODE_NAMES
from hyperfab.materials.effects.thermal_softening import LAWS
from hyperfab.materials.registry import laws


def measured() -> Measured:
    """Return cycles along warp, weft and between, at four temperatures, with the second stretch of one."""
    turns = [1.0, 1.2, 1.0, 1.2, 1.0, 1.4, 1.0]
    lam = np.concatenate([[1.0], *(np.linspace(a, b, 9)[1:] for a, b in pairwise(turns))])
    found = []
    for number, (angle, temperature, mode) in enumerate(
        [(0.0, 23.0, 0), (90.0, 23.0, 0), (0.0, 60.0, 1), (45.0, 40.0, 0), (0.0, 80.0, 0), (0.0, 5.0, 0)]
    ):
        found.append(
            TestCurve(
                MODE_NAMES[mode],
                lam,
                np.full_like(lam, 0.1),
                stretch2=lam**-0.45 if number == 0 else None,
                time_s=np.linspace(0.0, 100.0 / (1 + 9 * number), len(lam)),
                temperature_degC=np.full_like(lam, temperature),
                direction=angle,
                source=f"t{number}",
                specimen=f"s{number}",
            )
        )
    return Measured(found, "MPa")


def constants_of(model: str) -> dict[str, float]:
    return dict(zip(laws()[model].names, CONSTANTS[model], strict=True))


@cache
def given(model: str) -> tuple[MaterialDocument, FabricProblem]:
    document = parse_document(
        {
            "format": "hyperfab.material/1",
            "model": model,
            "parameters": constants_of(model),
            "thickness_mm": 0.8,
            "temperature_degC": 23.0,
        },
        "fabric.json",
        MaterialDocument,
    )
    return document, pose(document, "fabric.json", measured())


def written(model: str, own: np.ndarray, terms: dict[str, tuple[str, np.ndarray]]) -> MaterialDocument:
    """Return the document that the loop writes with ``terms``, read again."""
    document, problem = given(model)
    fit: Any = SimpleNamespace(x=np.concatenate([own, *(v for _, v in terms.values())]), own=len(own), terms=terms)
    return parse_document(extend(document, problem, fit, problem.law).to_json(), "loop.json", MaterialDocument)


def sought(model: str) -> list[Any]:
    _, problem = given(model)
    return [
        pytest.param(model, effect.id, form.name, id=f"{model}-{effect.id}-{form.name}")
        for effect in problem.effects
        for form in effect.forms
    ]


@pytest.fixture
def no_starts(monkeypatch: pytest.MonkeyPatch) -> None:
    """Problems say nothing of where a fit is to begin, beside the document's own constants: half of their time."""
    monkeypatch.setattr(fabric_constants, "_best_by_law", lambda *of: ())


@pytest.mark.usefixtures("no_starts")
@pytest.mark.parametrize(("model", "effect", "form"), [*sought("yeoh-3"), *sought("yeoh-1"), *sought("ogden-2")])
def test_a_fabric_with_an_effect_is_the_one_that_is_written(model: str, effect: str, form: str) -> None:
    _, problem = given(model)
    own = 1.1 * np.array([constant.value for constant in problem.own])
    entry = problem.effect(effect).form(form)
    values = np.array(entry.starts[0]) + 0.1 * np.array([constant.scale for constant in entry.constants])
    terms = {effect: (form, values)}
    thought = problem.predict(own, terms)
    again = pose(written(model, own, terms), "loop.json", measured())
    constants = np.array([constant.value for constant in again.own])
    found = again.predict(constants, {})
    np.testing.assert_allclose(found, thought, rtol=0.0, atol=1e-9 * np.nanmax(np.abs(thought)))
    assert np.max(np.abs(thought - problem.predict(own, {}))) > 1e-6
    # What no material may do is asked of both alike.
    asked, told = problem.forbidden(own, terms), again.forbidden(constants, {})
    # A law that is added in the law's own terms is written as one law: then there is one modulus.
    both = asked.keys() & told.keys()
    assert len(both) == min(len(asked), len(told))
    assert {name: told[name] for name in both} == pytest.approx({name: asked[name] for name in both}, abs=1e-9)


@pytest.mark.parametrize(("model", "effect", "form"), sought("yeoh-3"))
def test_a_fabric_with_an_effect_meets_one_plain_pull(model: str, effect: str, form: str) -> None:
    """That shows nothing of directions, modes, warmth or contraction: the effect is what it was, and holds."""
    _, problem = given(model)
    own = np.array([constant.value for constant in problem.own])
    entry = problem.effect(effect).form(form)
    values = np.array(entry.starts[0]) + 0.1 * np.array([constant.scale for constant in entry.constants])
    lam = np.linspace(1.0, 1.3, 30)
    pull = TestCurve("uniaxial", lam, lam - 1.0, time_s=10.0 * lam, temperature_degC=np.full(30, 23.0), source="t")
    again = pose(written(model, own, {effect: (form, values)}), "loop.json", Measured([pull], "MPa"))
    assert np.all(np.isfinite(again.predict(np.array([constant.value for constant in again.own]), {})))
    stays = {f"{effect} {one.name}" for one in entry.constants if one.low == one.high}
    assert all(one.low == one.high for one in again.own if one.name in stays)


@pytest.mark.parametrize("model", [name for name, law in laws().items() if law.isotropic])
@pytest.mark.parametrize(
    ("effect", "form", "values"),
    [
        ("anisotropy", "ratio", [0.6]),
        ("thermal-softening", "exponential", [0.004]),
        ("thermal-softening", "curved", [0.004, 2e-5]),
        ("thermal-softening", "glass", [0.002, 0.8, 30.0, 9.0]),
    ],
    ids=["ratio", "exponential", "curved", "glass"],
)
def test_an_effect_that_scales_constants_scales_the_law_of_every_command(
    model: str, effect: str, form: str, values: list[float]
) -> None:
    """As ``hf drape`` and ``hf fabric-contact`` read the constants: by direction and temperature."""
    _, problem = given(model)
    own = np.array([constant.value for constant in problem.own])
    document = written(model, own, {effect: (form, np.array(values))})
    reach = np.array([0.95, 1.05, 1.1])
    plain = bind(model, constants_of(model)).uniaxial(reach).P
    for direction, share in (("warp", 1.0), ("weft", values[0])) if effect == "anisotropy" else ():
        stress = bind(model, document.constants(direction)).uniaxial(reach).P
        np.testing.assert_allclose(stress, share * plain, rtol=1e-9)
    for degrees in (5.0, 23.0, 40.0, 60.0, 80.0) if effect == "thermal-softening" else ():
        stress = bind(model, document.constants(None, degrees)).uniaxial(reach).P
        share = float(LAWS[form](np.array(degrees), 23.0, *values))
        np.testing.assert_allclose(stress, share * plain, rtol=1e-9)
