"""What the loop computes with an added effect is what the model does that is written: every form, in a press."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from tempfile import mkdtemp
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from loop import blind_press
from loop.generators import press as caps

from hyperfab.cases.options import read
from hyperfab.cases.press import PressCase
from hyperfab.chapters.close_loop.extended_press import WRITERS, extend
from hyperfab.chapters.close_loop.press import closed_press, plan_of, pose
from hyperfab.chapters.job import Job
from hyperfab.chapters.press_contact.result import PressResult
from hyperfab.console import Console
from hyperfab.io.output import Output
from hyperfab.loop.press import PressProblem
from hyperfab.loop.problem import Form

#: A document that has something of most effects already.
MORE = """
relaxation = { share = [0.2], time = ["30 s"], dwell = "600 s" }
shrinkage = { amount = 0.05 }
variation = { x = 0.03 }
press = { stiffness = "2 kN/mm", tilt = { x = "0.1 deg" }, offset = { y = "0.1 mm" } }
"""
#: What a press tells of that is hot and opened again.
HOT = """
relaxation = { share = [0.2], time = ["30 s"], dwell = "600 s" }
conductivity = "0.05 W/m/K"
specific_heat = "1045 J/kg/K"
density = "30 kg/m^3"
set = 0.1
"""
#: How far the loop's table of gaps is from the press itself, of the largest reading: it is linear in tilt and growth,
#: and its force is a thinned sum that is set right at the model as it was.
TABLE = {"pressure": 2e-3, "contact": 0.05, "thickness": 2e-4, "force": 6e-3, "formed": 2e-4, "fabric": 1e-9,
         "mounting": 1e-9}  # fmt: skip
#: The same with the molds up to 180 K colder than the model's: they shrink by 0.4 %, which moves the gap by a third
#: of a millimetre.
COLD = 1.5e-2


@dataclass(frozen=True)
class Posed:
    case: PressCase
    told: PressResult
    problem: PressProblem
    own: np.ndarray
    hot: bool


def posed(case: PressCase, hot: bool) -> Posed:
    told, _ = closed_press(Job("press-contact", [], Console(True)), case)
    read = caps.measure(caps.Truth(()), np.random.default_rng(2), 0.0, "rich")
    if hot:
        more = ("next formed", "next fabric", "next mounting", "next cold")
        read += [one for name in more for one in caps.measure(caps.Truth(()), np.random.default_rng(3), 0.0, name)]
    files = blind_press.as_readings(read)
    if hot:
        files.append(replace(files[-1], name="warm.csv", temperature=110.0))
    problem = pose(told, files, 0.1, [])[0]
    return Posed(case, told, problem, np.array([constant.value for constant in problem.own]), hot)


@cache
def given(hot: bool = False, dwell: bool = False) -> Posed:
    folder = Path(mkdtemp())
    for which in ("male", "female"):
        (folder / f"{which}.stl").write_bytes(caps.stl(which))
    (folder / "foam.toml").write_text(caps.FOAM_TOML + (HOT if hot else MORE))
    words = [f"--{key}={folder}/{name}" for key, name in
             (("male", "male.stl"), ("female", "female.stl"), ("foam", "foam.toml"))]  # fmt: skip
    warm = ["--temperature", "200degC"] * hot + ["--dwell", "600s"] * dwell
    return posed(read(PressCase, [*words, "--gap", f"{caps.GAP}mm", *warm]), hot)


def values_of(form: Form) -> np.ndarray:
    """Return constants of a form of which none stands at its null, of a size that a press has."""
    return np.array(form.null) + 0.2 * (np.array(form.starts[0]) - form.null) + [c.scale for c in form.constants]


def written(before: Posed, own: np.ndarray, terms: dict[str, tuple[str, np.ndarray]], folder: Path) -> Posed:
    """Return the press that the loop writes with ``terms``, closed again."""
    fit = SimpleNamespace(x=np.concatenate([own, *(v for _, v in terms.values())]), own=len(own), terms=terms)
    found: Any = SimpleNamespace(after=SimpleNamespace(fit=fit))
    out = Output(str(folder / "loop.json"), ())
    job = Job("press-contact", [], Console(True))
    extension = extend(job, out, before.case, before.told, before.problem, found)
    for suffix, content in extension.files.items():
        Path(out.path(suffix)).write_bytes(content)
    assert isinstance(extension.case, PressCase)
    return posed(extension.case, before.hot)


def batches() -> list[dict[str, tuple[str, np.ndarray]]]:
    """Return every form, one of each effect at a time."""
    every = {effect.id: effect.forms for effect in given().problem.effects}
    return [
        {name: (forms[k].name, values_of(forms[k])) for name, forms in every.items() if k < len(forms)}
        for k in range(max(map(len, every.values())))
    ]


def test_what_is_found_of_a_press_can_be_written() -> None:
    assert WRITERS.keys() == {effect.id for effect in given().problem.effects}


@pytest.mark.parametrize("which", [0, pytest.param(slice(1, None), marks=pytest.mark.slow, id="others")])
def test_a_press_with_effects_is_the_one_that_is_written(which: int | slice, tmp_path: Path) -> None:
    some = batches()[which]
    for number, terms in enumerate([some] if isinstance(some, dict) else some):
        folder = tmp_path / str(number)
        folder.mkdir()
        check(given(), terms, folder)


#: Foam that softens, fabrics that give way, strain that stays, and what moves the molds: read hot, cold and opened.
HOT_FORMS = {
    "share": {"fabric-compression": "linear", "foam-softening": "exponential", "set": "share",
              "foam-relaxation": "in time", "frame-compliance": "spring"},
    "bent": {"fabric-compression": "stiffening", "foam-softening": "curved", "lateral-shift": "displacement"},
    "grown": {"thermal-expansion": "each mold"},
    "aged": {"foam-shrinkage": "in time"},
    "dwell": {"fabric-compression": "linear", "set": "with strain", "lateral-shift": "displacement"},
}  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("kind", HOT_FORMS)
def test_a_hot_press_with_effects_is_the_one_that_is_written(kind: str, tmp_path: Path) -> None:
    before = given(hot=True, dwell=kind == "dwell")
    forms = {name: before.problem.effect(name).form(form) for name, form in HOT_FORMS[kind].items()}
    values = {name: values_of(form) for name, form in forms.items()}
    if kind == "aged":  # long over by the end of the dwell, which stands for readings whose time nobody knows
        values["foam-shrinkage"][1] = 20.0
    check(before, {name: (form.name, values[name]) for name, form in forms.items()}, tmp_path)


def check(before: Posed, terms: dict[str, tuple[str, np.ndarray]], tmp_path: Path) -> None:
    """Hold what is predicted with terms against the press that is written with them."""
    own = before.own.copy()
    own[[constant.name for constant in before.problem.own].index("foam.compression")] = 1.1
    thought = before.problem.predict(own, terms)
    after = written(before, own, terms, tmp_path)
    found = after.problem.predict(after.own, {})
    # What was set is the same to rounding.
    value = dict(zip((one.name for one in before.problem.own), own, strict=True))
    changes = before.problem.changes(terms)
    late = replace(before.problem.files[0], time_s=np.array([600.0]))
    thick = float(np.max(changes.thickness(late)))
    moved = before.problem._moved(value, changes, thick=thick)
    set_to, closing = after.problem.setting, after.told.closed.case
    # Of a frame with play the document has the stiffness at the force that the press closes with, at which it opens
    # as far.
    force = before.problem.force_at(own, terms, 600.0)
    assert set_to.compliance == pytest.approx(moved.frame.opens(force) / force, rel=1e-9)
    assert after.told.closed.contact.closing_force == pytest.approx(force, rel=TABLE["force"])
    foam = np.asarray(before.told.closed.press.sandwich.foam)
    table = replace(before.problem.summed, plan=plan_of(before.told), foam=foam)
    wide = replace(before.problem, summed=table)._moved(value, changes, thick=thick).table
    assert after.told.closed.press.sandwich.foam == pytest.approx(wide.foam, rel=1e-9)
    tilt = np.array(before.told.closed.case.tilt) + changes.tilt
    assert closing.tilt == pytest.approx(tilt, rel=1e-9, abs=1e-15)
    offset = np.array(before.told.closed.case.offset) + changes.offset
    assert closing.offset == pytest.approx(offset, rel=1e-9, abs=1e-15)
    for more, was, grown in zip(changes.strain, before.told.model.grown, after.told.model.grown, strict=True):
        assert grown.strain == pytest.approx(was.strain + more, rel=1e-9, abs=1e-15)
    # And so is what the sandwich bears at the end of the dwell, and what stays of it.
    left = changes.factor(late)
    bears = moved.relaxed(float(np.max(left)))
    gap = np.linspace(1.5, 4.5, 7)[:, None]
    there = after.told.closed.press.sandwich
    thought_of = replace(there, law=bears.table.law, fabric_law=bears.table.fabric_law).pressure(gap)
    assert there.pressure(gap) == pytest.approx(bears.factor * thought_of, rel=1e-9, abs=1e-15)
    # What is read is the same as far as the table is the press; a hold is the end of the dwell.
    for reading, curve in zip(before.problem.files, before.problem.curves, strict=False):
        rows = np.arange(curve.start, curve.stop)
        if reading.time_s is not None:
            rows = rows[reading.time_s == 600.0]
        if not len(rows):
            continue
        most = np.max(np.abs(thought[before.problem.channel == curve.channel]))
        size = TABLE[reading.kind] if reading.warmth is None else COLD
        assert found[rows] == pytest.approx(thought[rows], abs=size * most), (reading.name, reading.kind)
