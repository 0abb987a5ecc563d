"""No law is used in silence where nobody tested it: what is outside is computed, told, and refused by ``--strict``."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from builders import plate
from conftest import Run

from hyperfab.chapters.close_loop.contact import note_temperatures
from hyperfab.chapters.fabric import FabricDocument
from hyperfab.chapters.job import Job
from hyperfab.chapters.validity import Ranges
from hyperfab.console import Console
from hyperfab.documents.base import parse_document
from hyperfab.documents.material import MaterialDocument
from hyperfab.loop.contact import ForceDepth
from hyperfab.materials import bind

C10 = {23.0: 0.08, 80.0: 0.05, 105.0: 0.04}


def document(**more: object) -> dict[str, object]:
    rows = [{"temperature_degC": t, "parameters": {"C10_MPa": c}} for t, c in C10.items()]
    tests = {"uniaxial": {"stretch": [1.0, 1.8], "temperature_degC": [22.4, 105.3]}}
    return {
        "format": "hyperfab.material/1", "model": "neo-hookean", "parameters": {"C10_MPa": 0.08}, "thickness_mm": 0.6,
        "temperature_degC": 23.0, "temperatures": rows, "tested": tests, **more,
    }  # fmt: skip


@pytest.fixture
def shop(tmp_path: Path, root: Path) -> Path:
    (tmp_path / "cup.stl").write_bytes((root / "molds" / "cup-male.stl").read_bytes())
    (tmp_path / "fabric.json").write_text(json.dumps(document()))
    return tmp_path


CONTACT = (
    "fabric-contact",
    "fabric.json",
    "--depth",
    "30mm",
    "--steps",
    "2",
    "--tolerance",
    "1e-2",
    "--mesh-size",
    "20mm",
)
DRAPE = ("drape", "fabric.json", "--mold", "cup.stl", "--grid", "15x15", "--depth", "20mm")
EXPORT = ("export", "fabric.json", "--to", "abaqus")


@pytest.mark.parametrize("command", [CONTACT, DRAPE, EXPORT], ids=lambda words: words[0])
@pytest.mark.parametrize(
    ("asked", "outside"),
    [
        (None, False), ("200degC", True), pytest.param("105.3degC", False, marks=pytest.mark.slow),
        pytest.param("1500degC", True, marks=pytest.mark.slow),
        pytest.param("60degC", False, marks=pytest.mark.slow), pytest.param("-40degC", True, marks=pytest.mark.slow),
    ],
)  # fmt: skip
def test_a_temperature_beyond_the_tests_is_computed_told_in_one_line_and_refused_by_strict(
    hf: Run, shop: Path, command: tuple[str, ...], asked: str | None, outside: bool
) -> None:
    words = [*command, *(() if asked is None else ("--temperature", asked))]
    plain, strict = hf(*words, cwd=shop), hf(*words, "--strict", cwd=shop)
    assert plain.returncode == 0, plain.stderr.decode()
    assert strict.returncode == (1 if outside else 0)
    assert strict.stdout == plain.stdout
    told = [line for line in plain.stderr.decode().splitlines() if "beyond what is known" in line]
    assert len(told) == (1 if outside else 0)
    asks = "is the unit right?" in plain.stderr.decode()
    assert asks == (asked == "1500degC")
    if command is EXPORT:
        return
    found = json.loads(plain.stdout)
    entry = next(one for one in found["validity"] if one["of"] == "temperature_degC")
    assert entry["used"] == [float((asked or "23degC").removesuffix("degC"))] * 2
    assert entry["known"] == [22.4, 105.3]
    assert entry["within"] is not outside
    assert entry["from"] == "fabric.json"
    at = found["setup"] if command is CONTACT else found
    assert at["temperature_degC"] == entry["used"][0]
    assert at.get("constants_degC") == {"200degC": 105.3, "1500degC": 105.3, "-40degC": 22.4}.get(str(asked))


@pytest.mark.parametrize("command", [DRAPE, EXPORT], ids=lambda words: words[0])
@pytest.mark.parametrize("known", [None, 23.0])
def test_a_fabric_of_one_temperature_or_none_is_computed_at_another_and_that_is_told(
    hf: Run, shop: Path, command: tuple[str, ...], known: float | None
) -> None:
    own = {"temperatures": None, "tested": None, "temperature_degC": known}
    (shop / "fabric.json").write_text(json.dumps({k: v for k, v in document(**own).items() if v is not None}))
    done = hf(*command, "--temperature", "190degC", "--strict", cwd=shop)
    assert done.returncode == (0 if known is None else 1), done.stderr.decode()
    told = "says nothing of temperature" if known is None else "the constants of 23 degC are taken"
    assert done.stderr.decode().count(told) == 1
    if command is DRAPE:
        entry = next(one for one in json.loads(done.stdout)["validity"] if one["of"] == "temperature_degC")
        assert entry["used"] == [190.0, 190.0]
        assert entry.get("known") == (None if known is None else [known, known])


def test_one_set_of_constants_for_tests_at_several_temperatures_is_told_as_that_of_its_own(hf: Run, shop: Path) -> None:
    """``hf close-loop`` writes such: there are no constants of 80 degC that could be taken."""
    tests = {"uniaxial": {"stretch": [1.0, 1.8], "temperature_degC": [23.0, 80.0]}}
    own = {"temperatures": None, "tested": tests, "temperature_degC": 23.0}
    (shop / "fabric.json").write_text(json.dumps({k: v for k, v in document(**own).items() if v is not None}))
    done = hf(*DRAPE, "--temperature", "190degC", cwd=shop)
    assert "fabric.json: 23 to 80 degC; the constants of 23 degC are taken" in done.stderr.decode()
    assert json.loads(done.stdout)["constants_degC"] == 23.0
    assert "constants_degC" not in json.loads(hf(*DRAPE, "--temperature", "60degC", cwd=shop).stdout)


@pytest.mark.parametrize("command", [CONTACT, DRAPE], ids=lambda words: words[0])
@pytest.mark.parametrize("tested", [None, 1.01, 1.8])
def test_a_stretch_beyond_the_tests_is_told_and_refused_by_strict(
    hf: Run, shop: Path, command: tuple[str, ...], tested: float | None
) -> None:
    tests = None if tested is None else {"uniaxial": {"stretch": [1.0, tested]}}
    (shop / "fabric.json").write_text(json.dumps({k: v for k, v in document(tested=tests).items() if v is not None}))
    done = hf(*command, "--strict", cwd=shop)
    found = json.loads(done.stdout)
    stretches = [one for one in found["validity"] if one["of"] == "stretch"]
    assert stretches
    reached = found.get("stretch_max") or max(found[way]["stretch_max"] for way in ("warp", "weft"))
    assert max(one["used"][1] for one in stretches) == pytest.approx(reached, rel=1e-12)
    assert reached > 1.015
    for one in stretches:
        assert one.get("known") == (None if tested is None else [1.0, tested])
        assert one.get("within") == (None if tested is None else tested == 1.8)
    assert done.returncode == (1 if tested == 1.01 else 0)


@pytest.mark.slow
def test_a_drape_at_a_temperature_is_that_of_its_constants(hf: Run, shop: Path) -> None:
    """Half-way between two tests the constants are the mean of theirs, and at a test they are its own."""
    for asked, c in (("80degC", 0.05), ("92.5degC", 0.045)):
        warm = json.loads(hf(*DRAPE, "--temperature", asked, cwd=shop).stdout)
        own = document(parameters={"C10_MPa": c}, temperatures=None)
        (shop / "own.json").write_text(json.dumps({k: v for k, v in own.items() if v is not None}))
        plain = json.loads(hf("drape", "own.json", *DRAPE[2:], cwd=shop).stdout)
        assert warm["force_N"] == pytest.approx(plain["force_N"], rel=1e-9)


@pytest.mark.slow
def test_all_readers_of_a_material_document_take_the_same_law_from_it(hf: Run, shop: Path) -> None:
    """Softening and added terms are obeyed alike in drape and contact: scaled constants give scaled forces."""
    soft = {
        "id": "thermal-softening",
        "form": "exponential",
        "parameters": {"softening_1_K": 0.005},
        "reference_degC": 23.0,
    }
    rich = {"id": "elastic-law", "form": "high-powers", "parameters": {"C40_MPa": 0.01, "C2_MPa": 0.02}}
    given = document(temperatures=None, effects=[soft, rich])
    (shop / "fabric.json").write_text(json.dumps({k: v for k, v in given.items() if v is not None}))
    factor = np.exp(-0.005 * (83.0 - 23.0))
    for command in (CONTACT, DRAPE):
        cold, warm = (json.loads(hf(*command, "--temperature", at, cwd=shop).stdout) for at in ("23degC", "83degC"))
        assert warm["force_N"] == pytest.approx(factor * cold["force_N"], rel=1e-6)
    plain = document(temperatures=None, effects=[soft])
    (shop / "plain.json").write_text(json.dumps({k: v for k, v in plain.items() if v is not None}))
    poor = json.loads(hf("drape", "plain.json", *DRAPE[2:], cwd=shop).stdout)
    assert json.loads(hf(*DRAPE, cwd=shop).stdout)["force_N"] > 1.02 * poor["force_N"]


def test_export_says_no_effect_is_missing_that_its_constants_have(hf: Run, shop: Path) -> None:
    soft = {
        "id": "thermal-softening",
        "form": "exponential",
        "parameters": {"softening_1_K": 0.005},
        "reference_degC": 23.0,
    }
    given = document(temperatures=None, effects=[soft, {"id": "rate", "form": "branch"}])
    (shop / "fabric.json").write_text(json.dumps({k: v for k, v in given.items() if v is not None}))
    told = hf(*EXPORT, "--temperature", "83degC", cwd=shop).stderr.decode()
    assert "without the effects rate" in told
    assert "thermal-softening" not in told


def test_a_fit_notes_the_stretches_it_predicts_beyond_those_it_fitted(hf: Run, root: Path, tmp_path: Path) -> None:
    tests = [
        word for name in ("uniaxial", "biaxial") for word in (f"--{name}", root / f"specimens/treloar-1944/{name}.csv")
    ]
    done = hf("fit", *tests, "--model", "gent", "--fit-on", "biaxial", "--strict", "--accept", "10")
    assert done.returncode == 1
    for of, ends in (("stretch", [1.0, pytest.approx(4.44, abs=0.1)]), ("temperature_degC", [20.0, 20.0])):
        entries = {one["from"]: one for one in json.loads(done.stdout)["validity"] if one["of"] == of}
        assert len(entries) == 2
        assert all(one["known"] == ends for one in entries.values())
        assert sorted(one["within"] for one in entries.values()) == [of != "stretch", True]


def test_ranges_join_what_one_law_was_used_at_and_judge_the_ends_to_rounding() -> None:
    ranges = Ranges()
    ranges.used("film.csv", [30.0, 250.0 * (1.0 + 1e-12)], known=[25.0, 250.0], source="mold.toml", unit="degC")
    assert not ranges.outside
    ranges.used("film.csv", [np.nan, 20.0], known=[25.0, 250.0], source="mold.toml", unit="degC", then="held")
    ranges.used("stretch", 1.2, known=None, source="a.json")
    ranges.used("stretch", [], known=(1.0, 1.1), source="b.json")
    assert [one.within for one in ranges.entries] == [False, None]
    assert ranges.entries[0].used == (20.0, pytest.approx(250.0))
    assert ranges.warning == "used beyond what is known: film.csv 20 to 250 degC (mold.toml: 25 to 250 degC; held)"


@pytest.mark.parametrize(("end", "within"), [(3600 * 1.1667, True), (4200.01, True), (4201.0, False)])
def test_a_table_whose_end_is_rounded_elsewhere_is_not_left(end: float, within: bool) -> None:
    """A schedule of 70 min in seconds, a run in hours with four decimals."""
    ranges = Ranges()
    ranges.used("power.csv", [0.0, end], known=[0.0, 4200.0], source="mold.toml", unit="s")
    assert ranges.entries[0].within is within
    # The share is one of the span, so that what is tested by two per cent of stretch is held to as much of that.
    ranges.used("stretch", [1.0, 1.02001], known=[1.0, 1.02], source="fabric.json")
    assert ranges.entries[1].within is False


def test_a_mold_that_starts_at_the_first_row_of_its_film_is_within_it(hf: Run, tmp_path: Path) -> None:
    """No wall of a mold that is heated is ever colder than it began, whatever its first steps are off by."""
    (tmp_path / "film.csv").write_text("temperature [degC],h [W/m^2/K]\n25,5\n250,13\n")
    (tmp_path / "plate.toml").write_text(
        plate(200, 200, 40)
        + """
[[heater]]
on = "plate.z-"
power = "3000 W"
[[convection]]
on = "exposed"
h = { table = "film.csv" }
ambient = "25 degC"
[run]
start = "25 degC"
until = "60 s"
mesh_size = "25 mm"
"""
    )
    done = hf("mold-heat", "plate.toml", "--strict", cwd=tmp_path)
    assert done.returncode == 0, done.stderr.decode()
    (film,) = json.loads(done.stdout)["validity"]
    assert film["used"][0] == 25.0
    # Colder air does cool it below the first row.
    (tmp_path / "plate.toml").write_text(
        (tmp_path / "plate.toml").read_text().replace('ambient = "25 degC"', 'ambient = "0 degC"')
    )
    done = hf("mold-heat", "plate.toml", "--strict", cwd=tmp_path)
    assert done.returncode == 1
    (film,) = json.loads(done.stdout)["validity"]
    assert 24.0 < film["used"][0] < 25.0


@pytest.mark.slow
def test_what_is_made_of_documents_stands_on_their_ranges(hf: Run, shop: Path) -> None:
    """A summary, a page and a study of a drape beyond the tests say so, and end with status 1 with --strict."""
    assert hf(*DRAPE, "--temperature", "200degC", "-o", "far.json", cwd=shop).returncode == 0
    assert hf(*DRAPE, "-o", "near.json", cwd=shop).returncode == 0
    for words in (("summary",), ("report", "-o", "page.html")):
        for name, status in (("far.json", 1), ("near.json", 0)):
            plain, strict = hf(*words, name, cwd=shop), hf(*words, name, "--strict", cwd=shop)
            assert (plain.returncode, strict.returncode) == (0, status)
            assert (b"beyond what is known: temperature 200 degC" in plain.stderr) is bool(status)


@pytest.mark.slow
def test_the_shrinkage_of_foam_beyond_its_table_is_told(hf: Run, tmp_path: Path, root: Path) -> None:
    foam = (root / "specimens" / "foam.toml").read_text()
    head = foam.index("\nthickness")
    foam = foam[:head] + '\nshrinkage = { amount = { table = "s.csv" } }' + foam[head:]
    (tmp_path / "foam.toml").write_text(foam)
    (tmp_path / "foam.csv").write_bytes((root / "specimens" / "foam.csv").read_bytes())
    (tmp_path / "s.csv").write_text("temperature [degC],shrinkage [-]\n20,0\n180,0.08\n")
    molds = ("--male", root / "molds" / "cup-male.stl", "--female", root / "molds" / "cup-female.stl")
    words = ("press-contact", *molds, "--foam", "foam.toml", "--gap", "3mm", "--strokes", "2")
    for temperature, status in (("170degC", 0), ("200degC", 1)):
        done = hf(*words, "--temperature", temperature, "--strict", cwd=tmp_path)
        assert done.returncode == status, done.stderr.decode()
        entry = next(one for one in json.loads(done.stdout)["validity"] if one["of"] == "shrinkage")
        assert entry["known"] == [20.0, 180.0]
        assert entry["used"] == [float(temperature.removesuffix("degC"))] * 2
        assert entry["within"] is (status == 0)
        assert (b"shrinkage 200 degC" in done.stderr) is bool(status)


@pytest.mark.parametrize("command", [CONTACT, DRAPE], ids=lambda words: words[0])
def test_how_far_a_law_that_stiffens_was_used_beyond_its_tests_is_told_by_its_stress(
    hf: Run, shop: Path, command: tuple[str, ...]
) -> None:
    """A tenth more stretch than was tested may be fifty times the stress, which the stretch alone does not show."""
    c = {"C10_MPa": 0.08, "C20_MPa": 0.5, "C30_MPa": 60.0}
    tested = {"uniaxial": {"stretch": [1.0, 1.01]}}
    kept = document(model="yeoh-3", parameters=c, temperatures=None, temperature_degC=None, tested=tested)
    (shop / "fabric.json").write_text(json.dumps({key: value for key, value in kept.items() if value is not None}))
    done = hf(*command, cwd=shop)
    assert done.returncode == 0, done.stderr.decode()
    found = json.loads(done.stdout)
    law, entry = bind("yeoh-3", c), found["validity"][0]

    def pulled(stretch: float) -> float:
        return float(law.uniaxial(np.array(stretch)).P)

    if command is DRAPE:  # the spring that is stretched most, by the law of a strip
        assert entry["stress_ratio"] == pytest.approx(pulled(entry["used"][1]) / pulled(1.01), rel=1e-6)
    else:  # in both directions more than a strip has
        assert entry["stress_ratio"] > 1.2 * pulled(entry["used"][1]) / pulled(1.01)
    ratio = f"{entry['stress_ratio']:.2g}"
    assert f"extrapolated to {ratio} times the stress at the end of its tests" in done.stderr.decode()


def test_a_loop_tells_where_its_model_was_used_beyond_its_tests(hf: Run, shop: Path) -> None:
    stretch = np.linspace(1.05, 2.0, 20)
    stress = 2.0 * 0.08 * (stretch - stretch**-2) * (1.0 + 1e-3 * np.cos(7.0 * np.arange(20)))
    rows = "".join(f"{a:.4f},{b:.6f}\n" for a, b in zip(stretch, stress, strict=True))
    (shop / "strip.csv").write_text(f"# test: uniaxial\nstretch [-],stress [MPa]\n{rows}")
    words = ("close-loop", "fabric.json", "strip.csv", "--noise", "1kPa")
    done = hf(*words, cwd=shop)
    assert done.returncode == 0, done.stderr.decode()
    assert json.loads(done.stdout)["validity"] == [
        {"of": "stretch", "used": [1.0, 2.0], "known": [1.0, 1.8], "within": False, "from": "fabric.json"}
    ]
    told = [line for line in done.stderr.decode().splitlines() if "beyond what is known" in line]
    assert told == ["hf: warning: used beyond what is known: stretch 1 to 2 (fabric.json: 1 to 1.8)"]
    assert hf(*words, "--strict", cwd=shop).returncode == 1


def test_a_loop_tells_at_which_temperatures_its_model_was_used(hf: Run, shop: Path) -> None:
    """It told the stretches alone, of the extended model too."""
    stretch = np.linspace(1.05, 1.7, 20)
    for name, warm in (("cold.csv", 30), ("hot.csv", 120)):
        stress = 2.0 * 0.08 * (stretch - stretch**-2) * (1.0 + 1e-3 * np.cos(warm * np.arange(20)))
        rows = "".join(f"{a:.4f},{b:.6f}\n" for a, b in zip(stretch, stress, strict=True))
        (shop / name).write_text(f"# test: uniaxial\n# temperature: {warm} degC\nstretch [-],stress [MPa]\n{rows}")
    words = ("close-loop", "fabric.json", "cold.csv", "hot.csv", "--noise", "1kPa")
    done = hf(*words, "-o", "loop.json", cwd=shop)
    assert done.returncode == 0, done.stderr.decode()
    found, model = (json.loads((shop / name).read_text())["validity"] for name in ("loop.json", "loop.model.json"))
    assert [one for one in found if one["of"] == "temperature_degC"] == [
        {"of": "temperature_degC", "used": [30.0, 120.0], "known": [22.4, 105.3], "within": False,
         "from": "fabric.json"}
    ]  # fmt: skip
    assert b"temperature 30 to 120 degC (fabric.json: 22.4 to 105.3 degC)" in done.stderr
    warm = {one["from"]: one for one in model if one["of"] == "temperature_degC"}
    assert {name: one["known"] for name, one in warm.items()} == {"cold.csv": [30.0, 30.0], "hot.csv": [120.0, 120.0]}
    assert len(model) == 4


def test_force_over_depth_is_told_at_the_temperatures_it_was_read_at() -> None:
    """That of the model alone was told, at which no test need have been."""
    job = Job("close-loop", [], Console(True))
    fabric = FabricDocument(parse_document(document(), "fabric.json", MaterialDocument), "fabric.json")
    depth = np.array([1.0, 2.0])
    warm = [None, np.array([23.0, 24.0]), np.array([140.0, 140.0])]
    note_temperatures(job, fabric, [ForceDepth("a.csv", depth, depth, one) for one in warm])
    [entry] = job.ranges.entries
    assert (entry.of, entry.used, entry.within) == ("temperature_degC", (23.0, 140.0), False)
    assert entry.known == (22.4, 105.3)
