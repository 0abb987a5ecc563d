"""A case is a value: words give it, a document keeps it, places reach into it, and each way back is exact."""

from __future__ import annotations

import dataclasses
from typing import Any

import jsonschema
import pytest

from hyperfab.cases import options
from hyperfab.cases.case import Case
from hyperfab.cases.place import get, put
from hyperfab.cases.registry import CASES, case_class
from hyperfab.errors import InputError, UsageError
from hyperfab.io.json_io import dump_json, load_json

#: A set-up of each command in which as many fields as can stand together are not at their default.
FULL: dict[str, list[str]] = {
    "drape": [
        "fabric.json", "--mold", "a.stl", "--mold", "b.stl", "--grid", "31x21", "--size", "20cmx180mm", "--depths",
        "2cm,4cm", "--thickness", "0.7 mm", "--clamp", "x-,x+", "--slide", "y-", "--blank-holder", "0.5N/mm",
        "--blank-holder", "x+=1 N/cm", "--friction", "0.3", "--load-steps", "7", "--prestretch", "1.05x1.1", "--mass",
        "0.18kg/m^2", "--shear-modulus", "50kPa", "--max-stretch", "1.9", "--steps", "5", "--divisor", "41",
        "--tolerance", "1e-7", "--uncertainty", "none", "--stl-unit", "cm", "--warp", "w.csv",
    ],
    "fabric-contact": [
        "fabric.json", "--against", "other.json", "--shape", "outline.csv", "--size", "20cm", "--thickness", "0.7mm",
        "--punch", "p.stl", "--depth", "3cm", "--prestretch", "1.05", "--rim-slip", "0.5mm^2/N", "--friction", "stick",
        "--frame-stiffness", "0.05kN/mm",
        "--temperature", "80degC", "--steps", "3", "--mesh-size", "5mm", "--element", "p1", "--tolerance", "1e-3",
        "--uncertainty", "sampled", "--stl-unit", "inch",
    ],
    "mold-heat": [
        "mold.toml", "--warmup-in", "20min", "--share-power", "--heater-max", "0.9kW", "--variations", "v.csv",
        "--uncertainty", "linear", "--stl-unit", "cm",
    ],
    "press-contact": [
        "--male", "m.stl", "--female", "f.stl", "--foam", "foam.toml", "--axis", "x", "--force", "0.5kN", "--male-heat",
        "1.json", "--female-heat", "2.json", "--drape", "d.json", "--mounted", "free", "--zero", "hot", "--float",
        "--force-at", "1cm,-2mm", "--frame-stiffness", "50kN/mm", "--strokes", "7", "--min-spotted", "80%",
        "--max-pressure", "8kPa", "--design-gap", "2mm", "--facets", "flat", "--uncertainty", "linear",
        "--dwell", "40s", "--target", "180degC", "--stl-unit", "m",
        "--wanted", "wanted.csv", "--within", "0.05mm", "--compensate",
    ],
    "fit": [
        "a.csv", "b.xlsx:warp", "--uniaxial", "u.csv", "--shear", "s.csv", "--biaxial", "b.csv", "--volumetric",
        "v.csv", "--model", "yeoh-3", "--fit-on", "uniaxial", "--objective", "absolute", "--stable", "--plane",
        "--accept", "5%", "--specimen", "iso-37-2", "--gauge-length", "2cm", "--width", "5cm", "--thickness", "0.5mm",
        "--diameter", "9cm",
        "--branch", "load", "--cycle", "2", "--zero", "--preload", "0.1N", "--resample", "40", "--noise", "2kPa",
        "--columns", "Kraft=force [N]", "--skip-rows", "3", "--decimal", ",",
    ],
    "close-loop": [
        "fabric.json", "a.csv", "--measured", "m.csv", "--uniaxial", "u.csv", "--shear", "s.csv", "--biaxial", "b.csv",
        "--hold-out", "h.csv", "--noise", "2kPa", "--fix", "C10_MPa", "--prior", "10%", "--branch", "unload",
    ],
    "export": [
        "fabric.json", "--to", "abaqus", "--direction", "warp", "--temperature", "80degC", "--bulk-modulus", "1GPa",
        "--density", "1.1 g/cm^3", "--name", "lycra",
    ],
    "report": ["a.json", "b.json", "--title", "Two"],
    "sweep": ["study.toml", "--out", "out", "--jobs", "3", "--retry-failed", "--parquet", "--yes"],
    "summary": ["a.json", "b.json"],
    "sample": ["folder", "--force"],
    "schema": ["material"],
}  # fmt: skip
#: The least that each command needs.
LEAST: dict[str, list[str]] = {
    "drape": ["fabric.json", "--mold", "a.stl"],
    "fabric-contact": ["fabric.json"],
    "mold-heat": ["mold.toml"],
    "press-contact": ["--male", "m.stl", "--female", "f.stl", "--foam", "foam.toml", "--gap", "3mm"],
    "fit": ["a.csv"],
    "close-loop": ["fabric.json", "a.csv"],
    "export": ["fabric.json", "--to", "abaqus"],
    "report": ["a.json"],
    "sweep": ["study.toml", "--out", "out"],
    "summary": ["a.json"],
    "sample": ["folder"],
    "schema": ["material"],
}


def cases() -> list[Case]:
    """Return the least and the fullest case of each command."""
    return [options.read(case_class(command), words[command]) for words in (LEAST, FULL) for command in CASES]


@pytest.mark.parametrize("case", cases(), ids=lambda case: case.COMMAND)
def test_words_and_documents_give_the_case_back(case: Case) -> None:
    cls = type(case)
    assert options.read(cls, options.words(case)) == case
    hashes = dict.fromkeys(case.inputs, "0" * 64)
    setup = load_json(dump_json(case.setup(hashes)), "a.json")
    jsonschema.validate(setup, cls.schema())
    kept = {one.name: getattr(case, one.name) for one in cls.settings().values() if one.kept}
    found = cls.load(setup, "a.json")
    assert cls.of({}, case.values | found) == case
    assert set(found) == {name for name, value in kept.items() if value is not None}


@pytest.mark.parametrize("case", cases(), ids=lambda case: case.COMMAND)
def test_words_given_are_shown_in_the_order_of_the_help_page(case: Case) -> None:
    words = options.words(case)
    assert options.shown(type(case), options.given(type(case), words)) == words


@pytest.mark.parametrize("case", cases(), ids=lambda case: case.COMMAND)
def test_what_stands_at_a_place_can_be_put_there(case: Case) -> None:
    for one in case.settings().values():
        value = get(case, one.key)
        if value is not None:
            assert put(case, one.key, value) == case


@pytest.mark.parametrize("command", CASES)
def test_every_default_is_within_its_own_bounds_and_every_field_has_help(command: str) -> None:
    cls = case_class(command)
    for one, field in zip(cls.settings().values(), dataclasses.fields(cls), strict=True):
        assert one.help.endswith("."), one.name
        if field.default not in (dataclasses.MISSING, None, ()):
            assert one.kind.load(one.kind.dump(field.default)) == field.default


def test_a_place_reaches_into_what_a_field_holds() -> None:
    case = options.read(case_class("drape"), FULL["drape"])
    assert get(case, "prestretch.1") == 1.1
    assert get(put(case, "prestretch.1", 1.2), "prestretch") == [1.05, 1.2]
    assert get(put(case, "blank_holder_N_mm.x+", 3.0), "blank_holder_N_mm") == {"clamped": 0.5, "x+": 3.0}
    with pytest.raises(UsageError, match="no such setting"):
        get(case, "depht_mm")
    with pytest.raises(UsageError, match=r"0\.5 and 3"):
        put(case, "prestretch.0", 9.0)


def test_an_option_given_wins_over_an_earlier_set_up_and_over_its_rivals() -> None:
    cls: Any = case_class("drape")
    earlier = options.read(cls, FULL["drape"]).values
    assert cls.of({"depth": "9mm"}, earlier).wanted == [9.0]
    assert cls.of({"shear_law": "bias.csv"}, earlier).shear_modulus is None
    assert cls.of({"friction": "", "load_steps": ""}, earlier).friction == 0.0


@pytest.mark.parametrize("command", [command for command in CASES if command in FULL])
def test_an_empty_value_is_none_but_beside_an_earlier_set_up(command: str) -> None:
    """A variable of a shell that is not set, ``--depth "$DEPTH"``, went as the default."""
    cls = case_class(command)
    least = options.given(cls, LEAST[command])
    for one in cls.settings().values():
        if not one.metavar or (one.required and not one.kind.repeated):
            continue
        for text in [["a.csv", ""]] if one.required else ["", [""]]:
            with pytest.raises(UsageError, match="is empty; give a value"):
                cls.of({**least, one.name: text})


def test_a_set_up_that_is_not_sound_is_refused_by_its_key() -> None:
    cls = case_class("drape")
    setup = options.read(cls, LEAST["drape"]).setup({})
    for key, wrong in (("depth_mm", "60mm"), ("grid", [2, 100]), ("clamp", ["north"]), ("solver", "magic")):
        with pytest.raises(InputError) as refused:
            cls.load({**setup, key: wrong}, "a.json")
        assert refused.value.key == f"setup.{key}"
    del setup["mold"]
    with pytest.raises(UsageError, match=r"MOLD\.stl is missing"):
        cls.of({}, cls.load(setup, "a.json"))


TOLERANCES = {
    "fabric-contact": (["--thickness", "0.7mm +- 5 %", "--friction", "0.3 ± 0.05", "--depth", "60mm +- 1mm"],
                       {"thickness_mm": 0.035, "friction_coefficient": 0.05, "depth_mm": 1.0}),
    "drape": (["--size", "200mm±2mm x 18cm", "--blank-holder", "x-=0.5N/mm±10%"],
              {"size_mm.0": 2.0, "blank_holder_N_mm.x-": 0.05}),
    "press-contact": (["--temperature", "200degC ± 5 K"], {"temperature_degC": 5.0}),
}  # fmt: skip


@pytest.mark.parametrize("command", TOLERANCES)
def test_a_tolerance_goes_through_words_and_documents_and_leaves_the_numbers_as_they_are(
    command: str,
) -> None:
    more, wanted = TOLERANCES[command]
    cls = case_class(command)
    case = options.read(cls, LEAST[command] + more)
    setup = load_json(dump_json(case.setup({})), "a.json")
    jsonschema.validate(setup, cls.schema())
    found = setup.pop("tolerances")
    assert found == pytest.approx(wanted)
    for again in (
        options.read(cls, options.words(case)),
        cls.of({}, cls.load({**setup, "tolerances": found}, "a.json")),
    ):
        assert again.setup({})["tolerances"] == found
    bare = options.read(
        cls,
        [word.split("±")[0].split("+-")[0] if "x 18cm" not in word else "200mmx18cm" for word in LEAST[command] + more],
    )
    assert bare.setup({}) == setup


def test_sizes_have_one_side_or_two() -> None:
    size = case_class("drape").settings()["size"].kind
    assert size.read("220mmx180mm", "--size") == (220.0, 180.0)
    assert size.read("22cm x 7in", "--size") == (220.0, 177.8)
    assert size.read("200mm", "--size") == (200.0, 200.0)
    for text in ("220x220", "220mmx220", "1mmx2mmx3mm", "", "x"):
        with pytest.raises(UsageError, match="--size"):
            size.read(text, "--size")


@pytest.mark.parametrize(
    ("typed", "told"),
    [
        ("220", "--size 220: a length needs its unit; write 220mm"),
        ("220mmx180", "--size 220mmx180: 180: a length needs its unit; write 180mm"),
        ("220mmx", "--size 220mmx: write 220mmx220mm"),
    ],
)
def test_the_right_form_of_a_size_is_told_once(typed: str, told: str) -> None:
    with pytest.raises(UsageError, match=f"^{told}$"):
        case_class("drape").settings()["size"].kind.read(typed, "--size")
