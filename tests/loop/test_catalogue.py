"""Every form and constant of the catalogue is explained to users, and every entry stands in the tables."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path
from types import ModuleType, SimpleNamespace

import numpy as np
import pytest

from hyperfab.curve import TestCurve
from hyperfab.loop import catalogue
from hyperfab.loop.catalogue import contact, drape, fabric, heat, press
from hyperfab.loop.drape import places
from hyperfab.loop.emulator import Axis
from hyperfab.loop.fabric import fabric_problem
from hyperfab.loop.fabric_menu import menu
from hyperfab.loop.heat import _MENU
from hyperfab.loop.press_reading import Setting
from hyperfab.loop.problem import Form
from hyperfab.materials import laws
from hyperfab.materials.effects.path import UNIAXIAL
from hyperfab.materials.effects.path import Path as Way
from hyperfab.materials.law import scaled

MODULES = sorted(path for path in Path(catalogue.__file__).parent.rglob("*.py") if path.name != "__init__.py")
DOCS = Path(__file__).parents[2] / "docs"
#: Names that are put together from others: written out on the page.
_MADE_UP = re.compile(r"[{}]")


@pytest.mark.parametrize("path", MODULES, ids=lambda path: f"{path.parent.name}/{path.stem}")
def test_the_page_of_laws_explains_names(path: Path) -> None:
    page = (DOCS / "close-loop-laws.md").read_text()
    names = re.findall(r'(?:Form|Constant|branch)\(\s*f?"([^"]+)"', path.read_text())
    assert names or path.stem == "context"
    missing = [name for name in names if not _MADE_UP.search(name) and name not in page]
    assert not missing


def fabric_context(stress: float = 1.0, pace: float = 1.0) -> fabric.DataContext:
    """Two loops at rates ten apart, along the warp and at 45 degrees, cold and warm, in units of stress and time."""
    up = np.linspace(1.0, 1.5, 20)
    lam = np.tile(np.concatenate([up, up[-2::-1]]), 4)
    count = len(lam)
    quick = np.where(np.arange(count) < count // 2, 1.0, 10.0)
    nothing = np.full(count, np.nan)
    way = Way(
        starts=(0, count // 2, count),
        mode=np.full(count, UNIAXIAL),
        stretch=lam,
        across=nothing,
        time_s=np.tile(np.arange(count // 2, dtype=float), 2) / quick * pace,
        temperature_degC=np.where(np.arange(count) < count // 2, 20.0, 60.0),
        angle_deg=np.where(np.arange(count) < count // 2, 0.0, 45.0),
        branch=np.zeros(count, dtype=np.int64),
    )
    law = laws()["yeoh-2"]
    own = tuple(scaled(dict(zip(law.names, (0.2, 0.05), strict=True)), stress).values())
    return fabric.DataContext(law, own, way, stress * (lam - 1.0), directions=True, transverse=True)


CONTEXTS = {
    "fabric": fabric_context(),
    "heat": heat.DataContext(
        duration_s=3600.0,
        rise_K=80.0,
        power_W=500.0,
        films=3,
        heaters=2,
        opened=2,
        declared=1,
        probes=3,
        bench=True,
        emits=True,
        typical_film=15.0,
    ),
    "contact": contact.DataContext((20.0, 60.0), 20.0, (0.05, 0.2), 0.5, 10.0, 2.0, 1.5, 6.0),
    "drape": drape.DataContext((0.05, 0.2), 0.5, 0.1, 300.0, 0.06, 8.0),
    "press": press.DataContext(
        setting=Setting(1.0, force=500.0, floating=True, half_mm=60.0),
        foam=press.FoamContext(),
        force_N=500.0,
        travel_mm=5.0,
        time_s=600.0,
        pressure_MPa=0.005,
        temperatures=(20.0,),
        strokes=True,
        formed=False,
    ),
}


DOMAINS: dict[str, ModuleType] = {
    "contact": contact, "drape": drape, "fabric": fabric, "heat": heat, "press": press,
}  # fmt: skip


def forms(kind: str, name: str, context: object) -> dict[str, Form]:
    effect = next(one for one in DOMAINS[kind].entries(context) if one.id == name)
    return {form.name: form for form in effect.forms}


ENTRIES = [(kind, effect.id) for kind, module in DOMAINS.items() for effect in module.entries(CONTEXTS[kind])]


@pytest.mark.parametrize(("kind", "name"), ENTRIES)
def test_the_page_of_laws_and_the_tables_have_the_entry(kind: str, name: str) -> None:
    page = (DOCS / "close-loop-laws.md").read_text()
    assert f"`{name}`" in page
    assert not [form for form in forms(kind, name, CONTEXTS[kind]) if form not in page]
    table = "close-loop.md" if kind in ("fabric", "heat") else "close-loop-shapes.md"
    assert f"| `{name}` |" in (DOCS / table).read_text()


@pytest.mark.parametrize(("kind", "entry"), ENTRIES)
def test_null_starts_and_probes_are_within_bounds_and_a_probe_is_no_null(kind: str, entry: str) -> None:
    for name, form in forms(kind, entry, CONTEXTS[kind]).items():
        low, high = (np.array([getattr(one, end) for one in form.constants]) for end in ("low", "high"))
        for values in (form.null, *form.starts, *form.probes):
            assert len(values) == len(low), name
            assert ((low <= np.array(values)) & (np.array(values) <= high)).all(), name
        assert form.starts, name
        assert all(probe != form.null for probe in form.probes), name


def unit(name: str) -> tuple[int, int]:
    """Powers of stress and of time in a constant's unit, by its name."""
    found = {"MPa_s": (1, -1), "MPa": (1, 0), "1_s": (0, -1), "s": (0, 1)}
    return next((powers for end, powers in found.items() if name.endswith(f"_{end}")), (0, 0))


@pytest.mark.parametrize("entry", [name for kind, name in ENTRIES if kind == "fabric"])
def test_where_a_search_starts_hangs_on_no_unit(entry: str) -> None:
    """Stress in Pa and time in hours: every start, probe and step goes with the unit of its constant."""
    plain = forms("fabric", entry, fabric_context())
    other = forms("fabric", entry, fabric_context(1e6, 1.0 / 3600.0))
    assert plain.keys() == other.keys()
    for name, form in plain.items():
        powers = np.array([unit(one.name) for one in form.constants]).T
        factor = 1e6 ** powers[0] * 3600.0 ** -powers[1].astype(float)
        for kind in ("starts", "probes"):
            for here, there in zip(getattr(form, kind), getattr(other[name], kind), strict=True):
                np.testing.assert_allclose(there, factor * np.array(here), rtol=1e-9, err_msg=f"{name} {kind}")


def test_what_is_probed_at_the_bench_goes_with_the_films_of_the_mold() -> None:
    contexts = [SimpleNamespace(**{**vars(CONTEXTS["heat"]), "typical_film": film}) for film in (15.0, 150.0)]
    one, ten = (forms("heat", "base-conduction", context) for context in contexts)
    for name, form in one.items():
        for here, there in zip(form.probes, ten[name].probes, strict=True):
            assert there[0] == pytest.approx(10.0 * here[0])


def test_the_test_proposed_is_the_one_that_is_weighed() -> None:
    """What a user is told to do, and the test whose worth was computed: rate, direction, turns, hold, temperature."""
    lam = np.linspace(1.0, 1.4, 30)
    done = TestCurve("uniaxial", lam, lam - 1.0, time_s=(lam - 1.0) / 0.02, direction=30.0, source="done",
                     temperature_degC=np.full(30, 20.0))  # fmt: skip
    found = list(menu([done]))
    rates = sorted({details["rate_1_s"] for _, details, _ in found})
    assert rates == pytest.approx([0.02 / 16, 0.02 / 4, 0.02, 0.02 * 16])
    assert {details["direction_deg"] for _, details, _ in found} == {30.0, 45.0, 120.0}
    for _, details, test in found:
        step, time = np.diff(test.stretch), np.diff(test.time_s)
        moves = np.abs(step) > 1e-12
        np.testing.assert_allclose(np.abs(step[moves]) / time[moves], details["rate_1_s"], rtol=1e-6)
        assert time[~moves].sum() == pytest.approx(details["hold_s"])
        assert test.angle_deg == details["direction_deg"]
        assert (test.temperature_degC == details["temperature_degC"]).all()
        turns = test.stretch[np.flatnonzero(np.diff(np.sign(step[moves]))) + 1] if not details["hold_s"] else []
        assert list(turns) == pytest.approx(details["stretch_turns"][:-1] if len(turns) else [])
        assert test.stretch[-1] == pytest.approx(details["stretch_turns"][-1])


def test_a_run_of_a_mold_asks_for_more_probes_where_it_says_so() -> None:
    for text, times, shares, everywhere in _MENU:
        assert everywhere == ("in each part" in text)
        assert len(times) == len(shares)
        assert 0.0 <= min(shares) <= max(shares) == 1.0


def test_effects_that_make_one_loop_are_told_apart_by_second_pulls_and_by_rates() -> None:
    up = np.linspace(1.0, 1.4, 20)
    loop = np.concatenate([up, up[-2::-1]])

    def alike(*tests: tuple[np.ndarray, float], slack: str = "", found: tuple[str, ...] = ()) -> list[set[str]]:
        """Of curves at rates [1/s], where the grips were found to give so, and some effects."""
        done = []
        for number, (lam, rate) in enumerate(tests):
            time = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(lam)))]) / rate
            done.append(TestCurve("uniaxial", lam, lam - 1.0, time_s=time, source=f"{number}", specimen=f"{number}"))
        problem = fabric_problem(laws()["neo-hookean"], (0.2,), done)
        named = {form.name: form for form in problem.effect("grip-slack").forms}
        forms = {name: problem.effect(name).forms[0] for name in found}
        return [set(one) for one in problem.look_alikes(forms | ({"grip-slack": named[slack]} if slack else {}))]

    one_loop = {"hysteresis", "mullins", "permanent-set"}
    assert alike((up, 0.01)) == []
    assert alike((loop, 0.01)) == [{*one_loop, "rate"}]
    assert alike((loop, 0.01), (loop, 0.1)) == [one_loop]
    assert alike((np.concatenate([loop, loop[1:]]), 0.01)) == []
    # That a loop moves with the rate is told by several rates alone, however often it is gone through.
    again, both = np.concatenate([loop, loop[1:]]), {"rate", "hysteresis"}
    assert alike((again, 0.01), found=("rate",)) == [both]
    assert alike((again, 0.01), found=("hysteresis",)) == []
    assert alike((again, 0.01), found=("rate", "hysteresis")) == []
    assert alike((again, 0.01), (again, 0.1), found=("rate",)) == []
    # What has slipped out of the grips does not come back; what was slack at the start makes no loop.
    assert alike((loop, 0.01), (loop, 0.1), slack="slips") == [{*one_loop, "grip-slack"}]
    assert alike((loop, 0.01), (loop, 0.1), slack="play") == [one_loop]


@pytest.mark.parametrize(("form", "named"), [("drift", True), ("settling", True), ("constant", False)])
def test_a_zero_that_wanders_shows_where_a_specimen_waits_or_is_let_go(form: str, named: bool) -> None:
    pull = np.linspace(1.0, 1.4, 20)

    def alike(lam: np.ndarray, beside: str) -> list[set[str]]:
        tests = [
            TestCurve("uniaxial", lam, pull[0] + 0.0 * lam, time_s=np.arange(len(lam)) / rate, source=f"{rate}")
            for rate in (0.1, 1.0)
        ]
        problem = fabric_problem(laws()["neo-hookean"], (0.2,), tests)
        forms = {name: problem.effect(name).forms[0] for name in (beside, "load-offset")}
        return [
            set(one) for one in problem.look_alikes(forms | {"load-offset": problem.effect("load-offset").form(form)})
        ]

    both = {"load-offset", "elastic-law"}
    assert (both in alike(pull, "rate")) == named
    assert both not in alike(pull, "grip-slack")
    assert both not in alike(np.concatenate([pull, pull[-2::-1]]), "rate")
    assert both not in alike(np.concatenate([pull, np.full(10, pull[-1])]), "rate")


@pytest.mark.parametrize("effect", ["grip-slack", "load-offset"])
def test_what_each_arm_of_a_cruciform_has_of_its_own_is_not_told_from_warp_and_weft(effect: str) -> None:
    lam = np.linspace(1.0, 1.1, 20)
    arms = [
        TestCurve("biaxial-general", lam, lam - 1.0, stretch2=lam, direction=angle, source=f"{angle}", specimen="1")
        for angle in (0.0, 90.0)
    ]
    strip = TestCurve("uniaxial", lam, lam - 1.0, direction=0.0, source="strip")

    def alike(form: str, *tests: TestCurve) -> bool:
        problem = fabric_problem(laws()["neo-hookean"], (0.2,), [*arms, *tests])
        return {effect, "anisotropy"} in problem.look_alikes({effect: problem.effect(effect).form(form)})

    assert alike("each")
    assert not alike("each", strip)
    assert not alike("play" if effect == "grip-slack" else "constant")


def test_what_the_plan_of_the_tests_cannot_tell_is_said_to_be_alike() -> None:
    lam = np.linspace(1.0, 1.4, 20)

    def alike(*states: tuple[float | None, float], gives: str = "", beside: str = "") -> list[set[str]]:
        """Of pulls at angles [deg] and temperatures [degC], where the grips were found to give so, beside an effect."""
        done = [
            TestCurve("uniaxial", lam, lam - 1.0, direction=angle, temperature_degC=np.full(20, heat), source=f"{k}")
            for k, (angle, heat) in enumerate(states)
        ]
        problem = fabric_problem(laws()["neo-hookean"], (0.2,), done)
        forms = {"grip-slack": problem.effect("grip-slack").form(gives)} if gives else {}
        forms |= {beside: problem.effect(beside).forms[0]} if beside else {}
        return [set(one) for one in problem.look_alikes(forms)]

    for gives in ("smooth", "smooth-force", "yields", "yields-curved"):
        assert alike((0.0, 23.0), (0.0, 23.0), gives=gives) == [{"grip-slack", "elastic-law"}]
        told = [{"grip-slack", "elastic-law"}] if gives == "smooth" else []
        assert alike((0.0, 23.0), (90.0, 23.0), gives=gives, beside="anisotropy") == told
        assert alike((0.0, 23.0), (0.0, 80.0), gives=gives, beside="thermal-softening") == told
        # Where the weft is as the warp it is no other curve.
        assert alike((0.0, 23.0), (90.0, 23.0), gives=gives) == [{"grip-slack", "elastic-law"}]
    assert alike((0.0, 23.0), (0.0, 23.0), gives="play") == []  # it has a corner
    assert alike((0.0, 23.0), (90.0, 80.0), (0.0, 23.0)) == [{"anisotropy", "thermal-softening"}]
    assert alike((0.0, 23.0), (90.0, 80.0), (0.0, 80.0)) == []
    assert alike((None, 23.0), (None, 80.0)) == []


def test_a_membrane_is_asked_for_no_shear_beside_its_laws():
    context = drape.DataContext((0.05, 0.2), 0.5, 0.0, 300.0)
    (shear,) = (one for one in drape.entries(context) if one.id == "shear-stiffness")
    assert shear.not_sought == "the law of a membrane has its own shear"
    assert not shear.forms
    names = ("prestretch", "weft more", "friction", "mass")
    runs = places([Axis("law C10", 1.0, 0.3, mixes=False), *(Axis(name, 0.0, 1.0) for name in names)])
    assert {name for run in runs for name in run} == {"law C10", *names}


@pytest.mark.parametrize(("quicker", "told"), [(2.0, True), (1.9, True), (1.3, False)])
def test_a_pull_twice_as_quick_shows_a_rate(quicker: float, told: bool) -> None:
    """Rates that were chosen to differ do, paces that were kept as well as can be do not."""
    stretch = np.linspace(1.0, 1.5, 30)
    tests = [
        TestCurve("uniaxial", stretch, 0.3 * (stretch - 1.0), time_s=(stretch - 1.0) / rate, source=f"{rate}")
        for rate in (0.03, 0.03 * quicker)
    ]
    problem = fabric_problem(laws()["yeoh-2"], [0.05, 0.0], tests, prior=None)
    assert (not problem.effect("rate").not_sought) is told


def test_a_power_of_a_term_of_nothing_stays_where_powers_are_sought() -> None:
    stretch = np.linspace(1.0, 1.5, 30)
    tests = [TestCurve("uniaxial", stretch, 0.3 * (stretch - 1.0))]
    own = fabric_problem(laws()["ogden-2"], [0.1, 2.0, 0.0, 45.0], tests, prior=None).own
    assert [(one.low, one.high) for one in own if one.name.startswith("alpha")] == [
        (-30.0, 30.0),
        (-30.0, 45.0),
    ]


@pytest.mark.parametrize(
    ("form", "values", "off"),
    [
        ("settling", (0.0, -0.01, 2.0), 0.0),
        ("settling", (0.0, -0.1, 20.0), 0.5),
        ("drift", (0.02, 0.001), 0.0),
        ("drift", (0.0, -0.0135), 0.1),
    ],
)
def test_a_load_cell_that_drifts_is_off_by_half_of_the_peak_at_most(
    form: str, values: tuple[float, ...], off: float
) -> None:
    stretch = np.linspace(1.0, 1.5, 30)
    test = TestCurve("uniaxial", stretch, 0.3 * (stretch - 1.0), time_s=20.0 * (stretch - 1.0) / 3.0 * 2.0)
    problem = fabric_problem(laws()["yeoh-2"], [0.05, 0.0], [test], prior=None)
    asked = problem.forbidden(np.array([0.05, 0.0]), {"load-offset": (form, np.array(values))})
    assert (asked["zero of the load cell"] > 0.0) is (off > 0.0)
    if form == "drift":
        assert max(asked["zero of the load cell"], 0.0) == pytest.approx(off, abs=1e-6)


def test_poissons_ratio_of_a_refitted_law_is_one_that_nature_has() -> None:
    stretch = np.linspace(1.0, 1.5, 30)
    tests = [TestCurve("uniaxial", stretch, 0.3 * (stretch - 1.0))]
    own = fabric_problem(laws()["blatz-ko-general"], [0.1, 0.2, 0.3], tests, prior=None).own
    assert [(one.low, one.high) for one in own if one.name == "nu"] == [(0.0, 0.4999)]


@pytest.mark.parametrize(("back", "paces", "tried"), [(False, (1.0, 1.0), False), (False, (1.0, 20.0), True),
                                                       (True, (1.0, 1.0), True)])  # fmt: skip
def test_a_zero_that_drifts_is_tried_where_time_does_not_go_as_the_stretch_does(
    back: bool, paces: tuple[float, float], tried: bool
) -> None:
    out = np.linspace(1.0, 1.4, 20)
    lam = np.concatenate([out, out[-2::-1]]) if back else out
    done = [
        TestCurve("uniaxial", lam, lam - 1.0, time_s=np.arange(len(lam)) / pace, source=f"{k}")
        for k, pace in enumerate(paces)
    ]
    offsets = fabric_problem(laws()["neo-hookean"], (0.2,), done).effect("load-offset")
    for name in ("drift", "settling", "smooth"):
        assert bool(offsets.form(name).simpler) is tried


@pytest.mark.parametrize("name", ["flow", "smooth", "smooth-flow"])
def test_a_smooth_set_finds_what_section_is_left_where_nobody_measured_across(name: str) -> None:
    context = replace(fabric_context(), transverse=False)
    width = forms("fabric", "permanent-set", context)[name].constants[-1]
    assert (width.name, width.low < width.high) == ("contraction", name != "flow")
