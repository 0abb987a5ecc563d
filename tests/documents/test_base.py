"""Documents: kinds and versions are checked by name, errors name the key, schemas are schemas."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any, ClassVar

import jsonschema
import pytest
from conftest import ROOT
from pydantic import Field
from schemas import follows_schema

from hyperfab.documents.base import KINDS, Document, HandWritten, parse_document, schema
from hyperfab.documents.mold import MoldDocument
from hyperfab.documents.study import StudyDocument
from hyperfab.errors import InputError, UsageError


class Sheet(Document):
    KIND: ClassVar[str] = "material"
    VERSION: ClassVar[int] = 2
    width_mm: float = Field(gt=0)
    note: str | None = None


class Recipe(HandWritten):
    KIND: ClassVar[str] = "foam"
    layers: int


def test_what_was_not_computed_is_absent() -> None:
    assert Sheet(width_mm=2.0).to_json() == {"format": "hyperfab.material/2", "width_mm": 2.0, "files": []}


def test_an_older_version_is_read() -> None:
    assert parse_document({"format": "hyperfab.material/1", "width_mm": 1.0}, "a.json", Sheet).width_mm == 1.0


@pytest.mark.parametrize(
    ("document", "cls", "message"),
    [
        (
            {"format": "hyperfab.material/3", "width_mm": 1},
            Sheet,
            "a.json, key format: has version 3 of the format (hyperfab.material/3)",
        ),
        (
            {"format": "hyperfab.material/0", "width_mm": 1},
            Sheet,
            'knows none below 1; write "hyperfab.material/2", or make the document again',
        ),
        ({"format": "hyperfab.drape/1"}, Sheet, "is a drape document, a material document is needed"),
        ({"width_mm": 1}, Sheet, "does not say what it is"),
        ({"format": 7}, Sheet, "unknown format 7"),
        ([], Sheet, "top level is not an object"),
        ({"format": "hyperfab.material/2"}, Sheet, "a.json, key width_mm: is missing"),
        (
            {"format": "hyperfab.material/2", "width_mm": -1},
            Sheet,
            "key width_mm: input should be greater than 0, not -1",
        ),
        (
            {"format": "hyperfab.material/2", "width_mm": float("nan")},
            Sheet,
            "key width_mm: input should be a finite",
        ),
        (
            {"format": "hyperfab.foam/1", "layers": 2, "leyers": 2},
            Recipe,
            "key leyers: is not a key of this document",
        ),
    ],
)
def test_an_unsound_document_is_refused_by_name(document: object, cls: type[Document], message: str) -> None:
    with pytest.raises(InputError) as refused:
        parse_document(document, "a.json", cls)
    assert message in str(refused.value)


@pytest.mark.parametrize("kind", KINDS)
def test_every_kind_has_a_sound_schema_that_demands_its_format(kind: str) -> None:
    found = schema(kind)
    jsonschema.Draft202012Validator.check_schema(found)
    assert "format" in found["required"]
    assert found["properties"]["format"]["const"].startswith(f"hyperfab.{kind}/")


def test_an_unknown_kind_names_the_known_ones() -> None:
    with pytest.raises(UsageError, match="material, contact"):
        schema("nonsense")


def test_a_wrong_key_in_a_list_is_told_by_the_name_of_its_entry() -> None:
    mold: dict[str, Any] = {
        "format": "hyperfab.mold/1",
        "material": {"al": {"density": "1 kg/m^3", "conductivity": "1 W/m/K", "specific_heat": "1 J/kg/K"}},
        "part": [{"name": name, "material": "al", "stl": f"{name}.stl"} for name in ("plate", "lid")],
        "convection": [{"on": "exposed", "h": "1 W/m^2/K", "ambient": "25 degC"}],
    }
    mold["part"][1]["stl"] = {"file": "lid.stl"}
    with pytest.raises(InputError, match=r"key part\.1\.stl: .* in part 'lid'"):
        parse_document(mold, "m.toml", MoldDocument)
    mold["part"][1]["stl"] = "lid.stl"
    mold["convection"][0]["ambent"] = mold["convection"][0].pop("ambient")
    with pytest.raises(InputError, match=r"in 1st convection .*did you mean ambient"):
        parse_document(mold, "m.toml", MoldDocument)


def test_a_key_of_another_section_is_not_proposed_for_itself() -> None:
    """``mean`` of a normal distribution in a lognormal one was met with "did you mean mean?"."""
    study: dict[str, Any] = {
        "format": "hyperfab.study/1",
        "name": "a",
        "axis": {"s": {"lognormal": {"mean": 1.0, "sd": 0.1}}},
        "step": [{"name": "fit", "command": "fit", "arguments": ["{s}"]}],
        "figures": {"E2": "fit.fit.E2"},
    }
    with pytest.raises(InputError, match=r"lognormal\.mean: is no key of axis\.s\.lognormal .*did you mean median\?"):
        parse_document(study, "s.toml", StudyDocument)
    study["axis"]["s"]["lognormal"] = {"median": 1.0, "factor": 1.1, "sd": 0.1}
    with pytest.raises(
        InputError, match=r"lognormal\.sd: is no key of axis\.s\.lognormal; it belongs to another section"
    ):
        parse_document(study, "s.toml", StudyDocument)


def test_all_keys_that_are_wrong_are_named_beside_the_first() -> None:
    with pytest.raises(InputError, match=r"key bogus: .* \(and 3 more: material, part, run\)"):
        parse_document({"format": "hyperfab.mold/1", "bogus": 1}, "m.toml", MoldDocument)


PLATE: dict[str, Any] = {
    "format": "hyperfab.mold/1",
    "material": {"steel": {"density": "7800 kg/m^3", "conductivity": "50 W/m/K", "specific_heat": "470 J/kg/K"}},
    "part": [
        {"name": "plate", "material": "steel", "box": {"origin": ["0 mm"] * 3, "size": ["9 mm"] * 3}},
    ],
    "run": {"start": "25 degC", "until": "60 s", "mesh_size": "9 mm"},
}  # fmt: skip


@pytest.mark.parametrize(
    ("change", "key"),
    [
        ({"run": {"start": "25 degC", "mesh_size": "9 mm"}}, "run"),
        ({"part": [PLATE["part"][0] | {"material": "stel"}]}, "part.0.material"),
        ({"heater": [{"on": "plate.z-", "power": "1 W", "control": {"probe": "p", "set": "99 degC", "band": "2 K"}}]},
         "heater.0.control"),
        ({"run": PLATE["run"] | {"target": "99 degC"}}, "run.target"),
    ],
)  # fmt: skip
def test_keys_that_do_not_go_together_are_told_by_the_one_to_look_at(change: dict[str, Any], key: str) -> None:
    parse_document(PLATE, "mold.toml", MoldDocument)
    with pytest.raises(InputError, match=f"^mold.toml, key {key}: "):
        parse_document(PLATE | change, "mold.toml", MoldDocument)


@pytest.mark.parametrize(
    "path", sorted([*ROOT.glob("molds/*.toml"), *ROOT.glob("specimens/*.toml")]), ids=lambda p: p.name
)
def test_documents_that_people_write_fit_the_schema_of_their_kind(path: Path) -> None:
    plain = tomllib.loads(path.read_text())
    follows_schema(plain, plain["format"].removeprefix("hyperfab.").partition("/")[0])


def test_a_schema_takes_the_short_forms_that_are_read_and_no_others() -> None:
    foam = {"format": "hyperfab.foam/1", "thickness": "4 mm", "compression": "foam.csv"}
    for more in (
        {},
        {"poisson": 0.3},
        {"shrinkage": 0.05},
        {"shrinkage": "0.05 +- 0.01"},
        {"compression": [{"table": "a.csv"}]},
    ):
        follows_schema({**foam, **more}, "foam")
    for wrong in ({"compression": 3}, {"shrinkage": [0.05]}, {"poisson": [0.3]}):
        with pytest.raises(jsonschema.ValidationError):
            follows_schema({**foam, **wrong}, "foam")


def test_a_schedule_that_is_given_as_a_table_is_shown_as_it_is_written() -> None:
    """``input should be a valid string`` told nobody: films and materials take ``{ table = ... }``."""
    heater: dict[str, Any] = {"on": "plate.z-", "schedule": {"table": "p.csv"}}
    with pytest.raises(InputError, match=r'key heater\.0\.schedule: .*schedule = "p\.csv"'):
        parse_document({**PLATE, "heater": [heater]}, "m.toml", MoldDocument)
    contact = {"between": ["plate", "plate"], "h": "9 W/m^2/K", "schedule": 3}
    with pytest.raises(InputError, match=r'key contact\.0\.schedule: .*schedule = "schedule\.csv"'):
        parse_document({**PLATE, "contact": [contact]}, "m.toml", MoldDocument)
    heater["schedule"] = "p.csv"
    assert parse_document({**PLATE, "heater": [heater]}, "m.toml", MoldDocument).heater[0].schedule == "p.csv"
