"""What the loop computes with an added effect is what the model does that is written: every form, on a mold."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from conftest import Run

from hyperfab.chapters.close_loop import heat
from hyperfab.chapters.close_loop.extended_mold import extend
from hyperfab.chapters.job import Job
from hyperfab.chapters.mold_heat.problem import MoldBuilder
from hyperfab.console import Console
from hyperfab.documents.base import parse_document
from hyperfab.documents.mold import MoldDocument
from hyperfab.io.toml_io import load_toml
from hyperfab.loop.heat import HeatProblem
from hyperfab.loop.problem import Form

MOLD = """format = "hyperfab.mold/1"
[material.steel]
density = "7800 kg/m^3"
conductivity = "40 W/m/K"
specific_heat = "460 J/kg/K"
[[part]]
name = "plate"
material = "steel"
box = { origin = ["0 mm", "0 mm", "0 mm"], size = ["60 mm", "40 mm", "20 mm"] }
[[part]]
name = "block"
material = "steel"
box = { origin = ["0 mm", "0 mm", "20 mm"], size = ["60 mm", "40 mm", "30 mm"] }
[[part]]
name = "lid"
material = "steel"
box = { origin = ["0 mm", "0 mm", "50 mm"], size = ["60 mm", "40 mm", "10 mm"] }
[[contact]]
between = ["block", "lid"]
h = "2000 W/m^2/K"
[[heater]]
volume = "block"
power = "60 W"
[[insulated]]
on = ["plate.z-"]
[[convection]]
on = ["lid.z+"]
h = "60 W/m^2/K"
ambient = "20 degC"
[[convection]]
on = "exposed"
h = "20 W/m^2/K"
ambient = "25 degC"
[[probe]]
name = "A"
at = ["20 mm", "15 mm", "10 mm"]
[[probe]]
name = "B"
at = ["30 mm", "20 mm", "40 mm"]
[[probe]]
name = "C"
at = ["30 mm", "20 mm", "55 mm"]
lag = "12 s"
[run]
start = "25 degC"
until = "1800 s"
mesh_size = "60 mm"
"""
TIMES = np.linspace(0.0, 1800.0, 61)
#: Between the runs of two reduced molds [K]: each has a basis of its own, and tables are linear between their rows.
NEAR_K = 0.02
#: The forms that a mold document has no key for; each is told of.
NO_KEY = {"uneven"}


@dataclass(frozen=True)
class Posed:
    data: dict[str, Any]
    document: MoldDocument
    problem: HeatProblem
    own: np.ndarray


def posed(text: bytes, folder: Path) -> Posed:
    name = str(folder / "mold.toml")
    data = dict(load_toml(text, name))
    document = parse_document(data, name, MoldDocument)
    job = Job("close-loop", [], Console(True))
    warm = np.tile(np.linspace(25.0, 120.0, len(TIMES))[:, None], (1, 3))
    builder = MoldBuilder(document, name, job.inputs)
    problem = heat.pose(builder, heat.Thermocouples(TIMES, warm, ["A", "B", "C"]), [], 0.1)
    return Posed(data, document, problem, np.array([constant.value for constant in problem.own]))


@cache
def given() -> Posed:
    return posed(MOLD.encode(), Path())


def values_of(form: Form) -> np.ndarray:
    """Return constants of a form of which none stands at its null."""
    return np.array(form.starts[0]) + 0.2 * np.array([constant.scale for constant in form.constants])


def written(
    own: np.ndarray,
    terms: dict[str, tuple[str, np.ndarray]],
    folder: Path,
    before: Posed | None = None,
    noise_K: float = np.inf,
) -> tuple[Posed, list[str]]:
    """Return the mold that the loop writes with ``terms``, read again, and what it says of them."""
    before = before or given()
    forms = {name: before.problem.effect(name).form(form) for name, (form, _) in terms.items()}
    x = np.concatenate([own, *(values for _, values in terms.values())])
    fit: Any = SimpleNamespace(x=x, own=len(own), terms=terms, forms=forms)
    files, notes = extend(before.data, before.document, before.problem, fit, "loop", ("", ""), noise_K)
    for suffix, content in files.items():
        (folder / f"loop{suffix}").write_bytes(content)
    return posed(files[".model.toml"], folder), notes


def told(form: Form) -> bool:
    """Whether a mold document has keys for a form."""
    return form.name not in NO_KEY


def batches() -> list[dict[str, tuple[str, np.ndarray]]]:
    """Return every form that a mold document has keys for, one of each effect at a time.

    A film that rides on the temperature difference is a table of the ambient at the start: it comes last, beside an
    ambient that stands.
    """
    every = {effect.id: [form for form in effect.forms if told(form)] for effect in given().problem.effects}
    most = max(map(len, every.values()))
    late = {name: most - 1 if name == "convection-law" else 0 for name in every}
    return [
        {
            name: (forms[k - late[name]].name, 0.5 * values_of(forms[k - late[name]]))
            for name, forms in every.items()
            if 0 <= k - late[name] < len(forms)
        }
        for k in range(most)
    ]


def test_every_constant_of_a_mold_has_its_place_in_the_set_up() -> None:
    every = [form for effect in given().problem.effects for form in effect.forms]
    assert all(constant.places for form in every for constant in form.constants)


@pytest.mark.parametrize("which", [pytest.param(slice(0, -1), marks=pytest.mark.slow, id="others"), -1], ids=str)
def test_a_mold_with_effects_is_the_one_that_is_written(which: int | slice, tmp_path: Path) -> None:
    some = batches()[which]
    for number, terms in enumerate([some] if isinstance(some, dict) else some):
        folder = tmp_path / str(number)
        folder.mkdir()
        check(terms, folder)


def check(terms: dict[str, tuple[str, np.ndarray]], tmp_path: Path) -> None:
    before = given()
    own = before.own * 1.02
    own[[constant.name for constant in before.problem.own].index("ambient")] = 1.5
    thought = before.problem.predict(own, terms)
    after, _ = written(own, terms, tmp_path)
    found = after.problem.predict(after.own, {})
    np.testing.assert_allclose(found, thought, rtol=0.0, atol=NEAR_K)
    for name in terms:
        without = before.problem.predict(own, {key: term for key, term in terms.items() if key != name})
        assert np.max(np.abs(thought - without)) > 5.0 * NEAR_K, name


#: The same faces under another name: of a shape of the part, in a box, beside others; or those at a side.
BASES = {
    "shape": ('on = ["foot.z-"]', None),
    "box": (
        'on = [{ part = "plate", box = { origin = ["-1 mm", "-1 mm", "-1 mm"], '
        'size = ["62 mm", "42 mm", "1 mm"] } }, "lid.x-"]', ["lid.x-"]),
    "side": (
        'on = ["plate.x-", "lid.x-"]\n[[convection]]\non = "plate.z-"\nh = "9 W/m^2/K"\nambient = "25 degC"', None),
}  # fmt: skip


@pytest.mark.parametrize(
    "base", [pytest.param(one, marks=pytest.mark.slow) if one != "shape" else one for one in BASES]
)
def test_a_base_is_no_longer_insulated_whatever_it_is_called(base: str, tmp_path: Path) -> None:
    """A film on faces that the document says to be insulated is refused."""
    named, left = BASES[base]
    text = MOLD.replace('on = ["plate.z-"]', named).replace(
        'box = { origin = ["0 mm", "0 mm", "0 mm"], size = ["60 mm", "40 mm", "20 mm"] }',
        'shapes = [{ name = "foot", box = { origin = ["0 mm", "0 mm", "0 mm"], size = ["60 mm", "40 mm", "20 mm"] } }]',
    )
    before, terms = posed(text.encode(), tmp_path), {"base-conduction": ("film", np.array([40.0]))}
    after, _ = written(before.own, terms, tmp_path, before)
    np.testing.assert_allclose(
        after.problem.predict(after.own, {}), before.problem.predict(before.own, terms), rtol=0.0, atol=NEAR_K
    )
    assert [place for section in after.document.insulated for place in section.on] == (left or [])


def test_what_a_mold_document_has_no_key_for_is_told(tmp_path: Path) -> None:
    problem = given().problem
    for effect in problem.effects:
        for form in (form for form in effect.forms if not told(form)):
            before = given()
            values = values_of(form)
            fit: Any = SimpleNamespace(
                x=np.concatenate([before.own, values]), own=len(before.own),
                terms={effect.id: (form.name, values)}, forms={effect.id: form},
            )  # fmt: skip
            _, notes = extend(before.data, before.document, problem, fit, "loop", ("", ""))
            assert any(note.startswith(effect.id) for note in notes), form.name


@pytest.mark.slow
def test_a_mold_with_all_effects_at_once_is_heated_as_the_loop_computes(hf: Run, tmp_path: Path) -> None:
    """By the finite elements of ``hf mold-heat`` themselves."""
    before, terms = given(), batches()[0]
    thought = before.problem.predict(before.own, terms).reshape(3, -1)
    written(before.own, terms, tmp_path)
    done = hf("mold-heat", "loop.model.toml", "-o", "run.json", cwd=tmp_path, timeout=600)
    assert done.returncode == 0, done.stderr.decode()
    run = np.genfromtxt(tmp_path / "run.csv", delimiter=",", names=True)
    clock = run[run.dtype.names[0]]
    for name, values in zip("ABC", thought, strict=True):
        column = next(one for one in run.dtype.names if one.startswith(name))
        # Half the loop's usual noise of a thermocouple.
        assert np.interp(TIMES, clock, run[column]) == pytest.approx(values, abs=0.15)
