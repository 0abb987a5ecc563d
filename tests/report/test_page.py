"""The page carries what the documents say, escaped, and no script but its own."""

from __future__ import annotations

import base64
import hashlib
import io
import json
import re
import zlib
from collections.abc import Callable
from html.parser import HTMLParser
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

from hyperfab.errors import InputError
from hyperfab.io.vtu import unstructured
from hyperfab.io.vtu_read import read_vtu
from hyperfab.report.figures_loop import LoopPicture
from hyperfab.report.figures_press import SpottedMold, spotting_drawing
from hyperfab.report.labels import AFTER, BEFORE, DATA
from hyperfab.report.page.front import front, still
from hyperfab.report.page.parts import Chart, Section, Source, in_order, number, parents, rounded
from hyperfab.report.page.render import page
from hyperfab.report.page.scenes import STEPS, Field, Surface, outside, scene, thinned
from hyperfab.report.page.sections import build
from hyperfab.report.page.sections import contact as contact_section
from hyperfab.report.page.sections import drape as drape_section
from hyperfab.report.page.sections import press as press_section

EVIL = "<script>alert(1)</script>\"'&<img src=x onerror=alert(2)>"


def material(model: str = "yeoh-3", **more: Any) -> dict[str, Any]:
    """Return a small material document."""
    figures = {"E2": 0.4, "relative_rms": 0.1234567, "nrmse": 0.02, "points": 12}
    return {
        "format": "hyperfab.material/1",
        "model": model,
        "parameters": {"C10_MPa": 0.17858268348482623},
        "fit": {**figures, "tests": {"uniaxial": figures, "shear": {**figures, "predicted": True}}},
        "accepted": True,
        "stable": True,
        **more,
    }


def nothing(name: str) -> bytes:
    """There is no file beside the document."""
    raise InputError("no such file", file=name)


def source(kind: str, data: dict[str, Any], name: str = "a.json", read: Callable[[str], bytes] = nothing) -> Source:
    """Return a document as the page takes it."""
    digest = hashlib.sha256(json.dumps(data).encode()).hexdigest()
    return Source(name, kind, digest, data, read)


class Found(HTMLParser):
    """The tags and texts of a page."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))

    def named(self, tag: str) -> list[dict[str, str | None]]:
        return [attributes for name, attributes in self.tags if name == tag]


def test_everything_from_a_document_is_escaped() -> None:
    data = material(model=EVIL, files=[EVIL], warnings=[EVIL])
    data["provenance"] = {"hf": EVIL, "command": EVIL, "arguments": [EVIL], "inputs": []}
    csv = f"test,direction,stretch,stress_MPa,stress_model_MPa,predicted\n{EVIL.replace(',', '')},,1,1,1,0\n"
    data["files"].append("a.csv")
    one = source("material", data, f"{EVIL}.json", lambda name: csv.encode() if name == "a.csv" else nothing(name))
    text = page(EVIL, [(one, build(one))], None).decode()
    assert "<script>alert" not in text
    assert "<img src=x" not in text
    clean = page("a", [(source("material", material()), build(source("material", material())))], None).decode()
    # One script more than a plain page has: the data of the chart, which are no program.
    scripts = Found(text).named("script")
    assert [item.get("type") for item in scripts] == ["application/json", "text/plain", None]
    assert [item.get("type") for item in Found(clean).named("script")] == ["text/plain", None]


def test_a_page_of_one_study_is_called_what_it_is_and_says_what_came_out() -> None:
    data = {
        "format": "hyperfab.sweep/1", "name": "Foam and gap", "cases": 4, "by_status": {"0": 4}, "within_limits": 3,
        "axes": {}, "figures": ["force_N", "contact_fraction"], "table": "none.csv",
        "senses": {"force_N": "least"}, "best": {"force_N": {"force_N": 97.4321, "number": 2}},
    }  # fmt: skip
    one = source("sweep", data)
    text = page(None, [(one, build(one))], None).decode()
    assert "<h1>Study: " in text
    assert "3 of 4 cases keep to the limits, of these the least force is 97.4 N." in text.replace(
        "\N{NO-BREAK SPACE}", " "
    )
    two = [source("material", material()), one]
    assert "<h1>From fabric to press</h1>" in page(None, [(each, build(each)) for each in two], None).decode()


def test_the_policy_allows_the_page_its_own_scripts_and_nothing_else() -> None:
    one = source("material", material())
    text = page("a", [(one, build(one))], None).decode()
    policy = next(
        str(item["content"])
        for item in Found(text).named("meta")
        if item.get("http-equiv") == "Content-Security-Policy"
    )
    rules = {part.split()[0]: part.split()[1:] for part in policy.split("; ")}
    assert rules["default-src"] == ["'none'"]
    assert "unsafe" not in " ".join(rules["script-src"])
    for body in re.findall(r'<script(?: type="text/plain" id="plotly")?>(.*?)</script>', text, re.DOTALL):
        digest = base64.b64encode(hashlib.sha256(body.encode()).digest()).decode()
        assert f"'sha256-{digest}'" in rules["script-src"]
    # Nothing is fetched: what is named stands in the page.
    for tag, attributes in Found(text).tags:
        for name in ("src", "href"):
            target = attributes.get(name)
            assert target is None or target.startswith(("data:", "#")), (tag, target)


def test_numbers_are_rounded_and_the_full_value_is_kept() -> None:
    one = source("material", material())
    text = page("a", [(one, build(one))], None).decode()
    assert '<td class="number" title="0.17858268348482623 MPa">0.1786 MPa</td>' in text
    assert number(200.0, "°C").full == ""
    assert rounded(1234567.0) == "1 234 567"


def test_tables_have_captions_and_pictures_words() -> None:
    one = source("material", material())
    found = Found(page("a", [(one, build(one))], None).decode())
    assert len(found.named("table")) == len(found.named("caption"))
    assert all(item.get("alt") for item in found.named("img"))
    assert all(item.get("aria-label") for item in found.named("div") if item.get("role") == "img")


@pytest.mark.parametrize("kind", ["material", "contact", "drape", "heat", "press", "loop", "sweep"])
def test_a_document_without_what_a_section_needs_costs_its_section_only(kind: str) -> None:
    broken, sound = source(kind, {"format": "?"}, "old.json"), source("material", material(), "new.json")
    told = [(broken, build(broken)), (sound, build(sound))]
    assert told[0][1].verdict.startswith("Cannot be shown")
    text = page("a", told, None).decode()
    assert "old.json" in text
    assert "0.1786 MPa" in text


def test_a_field_that_is_gone_is_told() -> None:
    one = source("material", {**material(), "files": ["a.csv"]})
    assert "Gone from beside the document, and missing here: a.csv." in build(one).notes


def test_the_story_runs_along_the_line_whatever_the_order_given() -> None:
    fabric = source("material", material())
    made = {"provenance": {"inputs": [{"name": "a.json", "sha256": fabric.sha256}]}}
    drape, press = source("drape", made), source("press", {})
    assert in_order([press, drape, fabric]) == [fabric, drape, press]
    assert parents(drape, [press, drape, fabric]) == [fabric]
    assert parents(press, [press, drape, fabric]) == []


def test_the_outside_of_tetrahedra_is_closed() -> None:
    # Two tetrahedra that share a face: six outer faces, each edge of them in two.
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 1]], dtype=float)
    cells = {"tetra": [[0, 1, 2, 3], [1, 2, 3, 4]]}
    surface = outside(read_vtu(unstructured(points, cells), "a.vtu"))
    assert len(surface.triangles) == 6
    edges = np.sort(surface.triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    assert (np.unique(edges, axis=0, return_counts=True)[1] == 2).all()


def test_thinning_out_keeps_places_and_values_and_tells_the_loss() -> None:
    side = np.linspace(0.0, 100.0, 101)
    x, y = (axis.ravel() for axis in np.meshgrid(side, side))
    points = np.stack([x, y, 0.01 * x * y], axis=1)
    corner = (np.arange(100)[:, None] * 101 + np.arange(100)).ravel()
    triangles = np.concatenate(
        [np.stack([corner, corner + 1, corner + 102], 1), np.stack([corner, corner + 102, corner + 101], 1)]
    )
    whole = Surface(points, triangles, np.arange(len(points)), np.arange(len(triangles)), whole=len(triangles))
    thin = thinned(whole, most=2000)
    assert 200 < len(thin.triangles) <= 2000
    assert np.array_equal(thin.points, points[thin.origin])
    # No point is farther from one that stays than is said.
    from scipy.spatial import cKDTree

    assert cKDTree(thin.points).query(points)[0].max() <= thin.moved_mm
    assert thinned(whole, most=20_000) is whole


def test_packed_values_come_back_within_the_rounding_that_is_stated() -> None:
    rng = np.random.default_rng(3)
    points, values = rng.normal(size=(300, 3)) * 50, rng.normal(size=300)
    cells = {"triangle": np.arange(300).reshape(100, 3)}
    grid = read_vtu(unstructured(points, cells, {"h_mm": values}), "a.vtu")
    view = scene("View.", "View.", grid, [Field("h_mm", "height", "mm"), Field("absent", "none")])
    assert view is not None
    assert [field["name"] for field in view.fields] == ["h_mm"]
    packed = view.fields[0]["values"]
    whole = np.frombuffer(zlib.decompress(base64.b64decode(packed["deflated"])), dtype="<u2")
    found = packed["low"] + whole * packed["step"]
    assert np.abs(found - values).max() <= 0.5001 * np.ptp(values) / STEPS
    assert (view.fields[0]["low"], view.fields[0]["high"]) == (values.min(), values.max())


def charts(section: Section) -> list[Chart]:
    return [part for part in section.parts if isinstance(part, Chart)]


@given(
    temperatures=st.lists(st.sampled_from([23.0, 60.0, 105.0, 190.0]), min_size=1, max_size=3, unique=True),
    replicates=st.integers(1, 3),
    directions=st.sampled_from([[""], ["warp", "weft"]]),
)
def test_each_fitted_line_is_one_test_at_one_temperature(
    temperatures: list[float], replicates: int, directions: list[str]
) -> None:
    """Replicates, cycles and temperatures in one table must not make a line that runs to and fro between them."""
    rows = ["test,direction,temperature_degC,specimen,stretch,stretch_2,stress_MPa,stress_model_MPa,predicted"]
    laws: dict[tuple[str, float], dict[float, float]] = {}
    for way in directions:
        for heat in temperatures:
            law = laws.setdefault((way, heat), {})
            for specimen in range(replicates):
                for step in [*range(8), *reversed(range(8))]:
                    stretch = 1.0 + 0.1 * step
                    law[stretch] = (stretch - 1.0) * (2.0 if way == "weft" else 1.0) / heat
                    measured = law[stretch] * (1.0 + 0.1 * specimen)
                    rows.append(f"uniaxial,{way},{heat},{specimen},{stretch!r},,{measured!r},{law[stretch]!r},0")
    table = "\n".join(rows).encode()
    one = source("material", material(files=["a.csv"]), read=lambda name: table)
    [drawing] = charts(build(one))
    lines = [trace for trace in drawing.data if trace["mode"] == "lines"]
    assert len(lines) == len(laws) == len({trace["name"] for trace in lines})
    assert len({trace["line"]["color"] for trace in lines}) == len(lines)
    found = sorted((tuple(trace["x"]), tuple(trace["y"])) for trace in lines)
    assert found == sorted((tuple(sorted(law)), tuple(law[x] for x in sorted(law))) for law in laws.values())
    points = [trace for trace in drawing.data if trace["mode"] == "markers"]
    assert sum(len(trace["x"]) for trace in points) == len(rows) - 1


def test_predictions_of_two_axes_at_once_are_no_line() -> None:
    rows = "".join(f"biaxial-general,,,1,{x},{y},{x * y},{x * y},0\n" for x in (1.1, 1.2) for y in (1.0, 1.3))
    head = "test,direction,temperature_degC,specimen,stretch,stretch_2,stress_MPa,stress_model_MPa,predicted\n"
    one = source("material", material(files=["a.csv"]), read=lambda name: (head + rows).encode())
    [drawing] = charts(build(one))
    assert all(trace["mode"] == "markers" for trace in drawing.data)


@pytest.mark.parametrize("values", [np.ones(4), np.zeros(4), np.array([0.0, 1.0, 1.0, 0.0])])
@pytest.mark.parametrize("module", [contact_section, drape_section, press_section])
def test_contact_has_two_colours_from_none_to_all(module: Any, values: np.ndarray) -> None:
    points = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], dtype=float)
    grid = read_vtu(unstructured(points, {"quad": [[0, 1, 2, 3]]}, {"contact": values}), "a.vtu")
    field = next(field for field in module._FIELDS if field.array == "contact")
    view = scene("View.", "View.", grid, [field])
    assert view is not None
    [shown] = view.fields
    assert (shown["low"], shown["high"]) == (0.0, 1.0)
    assert len({colour for _, colour in shown["colours"]}) == 2
    assert len(shown["words"]) == 2
    with Image.open(io.BytesIO(still(view))) as picture:
        solid = np.asarray(picture.convert("RGBA")).reshape(-1, 4)
    blue = solid[solid[:, 3] == 255][:, 2].astype(int) - solid[solid[:, 3] == 255][:, 0]
    # The mark's blue against the grey of what is free, as a share of the picture.
    assert np.mean(blue > 50) == pytest.approx(values.mean(), abs=0.06)


def test_before_and_after_have_the_same_colours_on_the_page_and_in_pictures() -> None:
    table = "test,stretch,stress_MPa,before_MPa,after_MPa,noise_sd_MPa\na,1.1,1,2,1.1,0.1\na,1.2,2,3,2.1,0.1\n"
    data = loop(files=["a.csv"])
    first, second = charts(build(source("loop", data, read=lambda name: table.encode())))
    colours = {trace["name"]: (trace.get("line") or trace["marker"])["color"] for trace in first.data}
    assert colours == {"measured": DATA, "model before": BEFORE, "model after": AFTER}
    assert [trace["marker"]["color"] for trace in second.data] == [BEFORE, AFTER]
    picture = LoopPicture(**drawn(np.linspace(1.0, 2.0, 9), {"stretch": np.linspace(1.0, 2.0, 9)})).drawing()
    drawn_in = {line.get_label(): line.get_color() for line in picture.axes[0].lines}
    assert drawn_in == {"measured": DATA, "model before": BEFORE, "model after": AFTER}
    assert first.layout["xaxis"]["title"]["text"] == "stretch"
    assert first.layout["yaxis"]["title"]["text"] == "stress, MPa"


def loop(**more: Any) -> dict[str, Any]:
    figures = {"rms": 0.1, "relative_rms": 0.2, "chi2_reduced": 1.0}
    errors = {"unit": "MPa", **dict.fromkeys(("before", "after", "noise"), figures)}
    return {"verdict": "effect", "error": errors, "candidates": [], **more}


@pytest.mark.parametrize(
    ("verdict", "claim"),
    [
        ("effect", "the model meets measurement to 20 %"),
        ("noise", "the model meets measurement to 20 %"),
        ("unexplained", "the model misses measurement by 20 %"),
        ("ambiguous", "the model meets measurement to 20 %"),
    ],
)
def test_a_model_that_lacks_something_does_not_meet_the_measurement(verdict: str, claim: str) -> None:
    found = build(source("loop", loop(verdict=verdict)))
    assert found.claim == claim
    assert [one.text for one in found.figures] == ["20 %"]  # nothing was added: no before and after


def drawn(abscissa: np.ndarray, states: dict[str, np.ndarray]) -> dict[str, Any]:
    """What the picture of a loop takes."""
    count = len(abscissa)
    rng = np.random.default_rng(1)
    return {
        "abscissa": abscissa, "label": "x", "unit": "mm", "curves": [slice(0, count)],
        "measured": rng.normal(size=count), "before": rng.normal(size=count), "after": rng.normal(size=count),
        "sd": np.ones(count), "states": states, "scores": {"friction": 0.0}, "scores_label": "BIC lowered by",
        "verdict": "noise", "added": [],
    }  # fmt: skip


def test_the_picture_says_how_far_off_the_delivered_model_was() -> None:
    given = drawn(np.arange(4.0), {"x": np.arange(4.0)}) | {"measured": np.full(4, 2.0)}
    given |= {"before": np.full(4, 2.2), "after": np.full(4, 2.01), "delivered": np.full(4, 1.5)}
    told = "misses the readings by 25 % as delivered, 10 % refitted, 0.5 % at the end"
    assert told in LoopPicture(**given).drawing().get_suptitle().replace("\n", " ")


@pytest.mark.parametrize("verdict", ["ambiguous", "unexplained"])
def test_the_heading_of_a_loops_picture_stands_inside_it(verdict: str) -> None:
    """With few states the picture is narrow, with many names the heading long."""
    given = drawn(np.arange(4.0), {"x": np.arange(4.0)}) | {"verdict": verdict}
    figure = LoopPicture(**given | {"added": ["thermal-softening", "elastic-law", "permanent-set"]}).drawing()
    figure.canvas.draw()
    [heading] = [text for text in figure.texts if "verdict" in text.get_text()]
    extent = heading.get_window_extent()
    assert 0.0 <= extent.x0 < extent.x1 <= figure.bbox.width


def test_readings_scattered_on_a_sheet_are_a_map_and_no_polyline() -> None:
    rng = np.random.default_rng(2)
    x, y = rng.uniform(-90, 90, (2, 40))
    states = {"x0_mm": np.tile(x, 3), "y0_mm": np.tile(y, 3), "axis": np.repeat([0.0, 1.0, 2.0], 40)}
    given = drawn(rng.normal(size=120), states)
    figure = LoopPicture(**given).drawing()
    joined = [line for axes in figure.axes for line in axes.lines if line.get_linestyle() not in ("None", "")]
    assert joined == []
    maps = [axes for axes in figure.axes if axes.get_title().startswith(("before", "after"))]
    assert len(maps) == 2
    for axes, model in zip(maps, (given["before"], given["after"]), strict=True):
        spots = axes.collections[0]
        assert np.allclose(spots.get_offsets(), np.stack([x, y], axis=1))
        rest = (given["measured"] - model).reshape(3, 40)
        assert np.allclose(spots.get_array(), np.linalg.norm(rest, axis=0))
    rows = "".join(
        f"{x[k % 40]},{given['measured'][k]},{given['before'][k]},{given['after'][k]},1,{x[k % 40]},{y[k % 40]},"
        f"{k // 40},m.csv\n"
        for k in range(120)
    )
    head = "from_the_middle_mm,measured_mm,before_mm,after_mm,noise_sd_mm,x0_mm,y0_mm,axis,file\n"
    [drawing] = charts(build(source("loop", loop(files=["a.csv"]), read=lambda name: (head + rows).encode())))
    assert [trace["mode"] for trace in drawing.data] == ["markers", "markers"]
    assert all(len(trace["x"]) == 40 for trace in drawing.data)


def test_residuals_stand_under_the_values_that_were_measured() -> None:
    states = {
        "temperature_degC": np.repeat([23.0, 80.0, 105.0], 4),
        "direction_deg": np.tile([0.0, 90.0], 6),
        "branch": np.tile([-1.0, -1.0, 1.0], 4),
        "probe": np.repeat([0.0, 1.0], 6),
        "log rate": np.full(12, -2.4) + 1e-12 * np.arange(12),
    }
    figure = LoopPicture(**drawn(np.arange(12.0), states), value_words={"probe": ["top", "cup, left"]}).drawing()
    told = {
        axes.get_xlabel(): [label.get_text() for label in axes.get_xticklabels()]
        for axes in figure.axes
        if axes.get_xlabel()
    }
    assert told["temperature, °C"] == ["23", "80", "105"]
    assert told["direction, ° from warp"] == ["0", "90"]
    assert told["branch"] == ["unloading", "loading"]
    assert told["probe"] == ["top", "cup, left"]
    assert not any("rate" in label for label in told)  # all alike: nothing rides on it


def test_rates_that_differ_by_rounding_stand_under_the_rate_of_the_machine() -> None:
    rng = np.random.default_rng(4)
    rates = np.repeat([0.01, 0.05], 20) * (1.0 + 1e-6 * rng.normal(size=40))
    figure = LoopPicture(**drawn(np.arange(40.0), {"log rate": np.log(rates)})).drawing()
    [axes] = [axes for axes in figure.axes if "rate" in axes.get_xlabel()]
    assert axes.get_xlabel() == "rate of stretching, 1/s"
    assert [label.get_text() for label in axes.get_xticklabels()] == ["0.01", "0.05"]


def test_curves_of_a_loop_stand_in_a_panel_of_their_direction_and_temperature() -> None:
    tests = [(90.0, 80.0), (0.0, 80.0), (0.0, 23.0), (90.0, 23.0), (0.0, 23.4)]
    states = {
        "stretch": np.tile(np.linspace(1.0, 1.5, 8), 5),
        "direction_deg": np.repeat([way for way, _ in tests], 8),
        "temperature_degC": np.repeat([degrees for _, degrees in tests], 8),
    }
    given = drawn(states["stretch"], states) | {"curves": [slice(8 * k, 8 * k + 8) for k in range(5)]}
    figure = LoopPicture(**given | {"unit": "MPa"}).drawing()
    panels = {axes.get_title(): axes for axes in figure.axes if axes.get_title()}
    assert list(panels) == ["warp, 23 °C", "warp, 80 °C", "weft, 23 °C", "weft, 80 °C"]
    drawn_in = {name: len(axes.lines) // 3 for name, axes in panels.items()}
    assert drawn_in == {"warp, 23 °C": 2, "warp, 80 °C": 1, "weft, 23 °C": 1, "weft, 80 °C": 1}
    assert np.allclose(panels["weft, 80 °C"].lines[0].get_ydata(), given["measured"][:8])
    assert panels["warp, 23 °C"].get_ylabel() == "nominal stress [MPa]"
    assert len({axes.get_ylim() for axes in panels.values()}) == 1


@pytest.mark.parametrize("least", [-0.5, 0.1])  # touching in part, and everywhere
def test_pressure_is_told_from_light_where_a_mold_touches(least: float) -> None:
    """The colour of a touching place is its pressure's alone, over the range there is; the light is the steel's."""
    u, v = (side.ravel() for side in np.meshgrid(np.linspace(20.0, 60.0, 9), np.linspace(-30.0, 30.0, 9)))
    k = np.arange(72).reshape(8, 9)[:, :-1].ravel()
    faces = np.concatenate([np.stack([k, k + 1, k + 10], 1), np.stack([k, k + 10, k + 9], 1)])
    level = least + np.linspace(0.0, 1.0, 81)
    pressure = np.where(level > 0.0, 0.005 + 0.002 * level, 0.0)
    normals = np.random.default_rng(3).normal(size=(81, 3))
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    mold = SpottedMold(
        np.stack([u, v, 0.0 * u], 1),
        faces,
        normals,
        3.0 - level,
        pressure,
        level,
        np.ones(81),
        3.0,
        ("x", "y"),
    )
    plan = spotting_drawing(mold, np.array([[0.0, 0.0], [1.0, 9.0]]), "").axes[0]
    _, blue = plan.collections[:2]
    assert np.allclose(blue.get_array(), 1000.0 * pressure)
    touched = 1000.0 * pressure[level > 0.0]
    assert (blue.norm.vmin, blue.norm.vmax) == pytest.approx((touched.min(), touched.max()))
    assert (blue.get_clip_path() is None) == (least > 0.0)
    low, high = plan.get_xlim()
    assert low > 15.0
    assert high < 65.0


def test_warnings_are_told_once_a_kind_under_a_heading() -> None:
    said = [f"lab/strip {n}.csv: the specimen is 2 times as long as wide" for n in range(18)]
    one = source("material", material(warnings=[*said, "the noise is large"]))
    text = page("a", [(one, build(one))], None).decode()
    assert "19 warnings of 2 kinds" in text
    assert text.count("2 times as long as wide") == 1
    assert "(and 17 more like it)" in text


def test_the_first_screen_is_a_sentence_and_at_most_five_figures() -> None:
    kinds = [source("material", material(f"law-{n}"), f"{n}.json") for n in range(4)]
    told = [(one, build(one)) for one in kinds]
    found = front(told)
    assert found.sentence == "Law-3 carries the tests to 12\N{NO-BREAK SPACE}%."
    assert [figure.text for _, figure in found.figures] == ["12 %"]
    assert {number for number, _ in found.figures} == {3}  # the last of a kind speaks for it


def test_the_same_documents_give_the_same_bytes() -> None:
    one = source("material", material())
    assert page("a", [(one, build(one))], None) == page("a", [(one, build(one))], None)


def test_a_verdict_says_pass_or_not_in_words() -> None:
    good, bad = source("material", material()), source("material", {**material(), "accepted": False})
    assert build(good).passed is True
    assert build(bad).passed is False
    text = page("a", [(bad, build(bad)), (good, Section("", None, "Nothing to pass."))], None).decode()
    assert "Does not pass" in text
    assert "1 of them does not pass" in text


def test_the_page_draws_the_widths_beside_the_stresses() -> None:
    head = "test,stretch,stress_MPa,before_MPa,after_MPa,noise_sd_MPa"
    table = f"{head},transverse_stretch,transverse_before,transverse_after,transverse_noise_sd\n"
    table += "a,1.1,1,2,1.1,0.1,0.97,0.95,0.971,0.001\nb,1.1,1,2,1.1,0.1,,,,\n"
    data = loop(files=["a.csv"])
    data["contraction"] = {
        k: {"rms": r, "relative_rms": r, "chi2_reduced": 1.0} for k, r in (("before", 0.6), ("after", 0.02))
    }
    *_, widths = charts(build(source("loop", data, read=lambda name: table.encode())))
    assert widths.layout["yaxis"]["title"]["text"] == "transverse stretch"
    assert [[y for y in trace["y"] if y is not None] for trace in widths.data] == [[0.97], [0.95], [0.971]]
    assert "60" in widths.alt
    assert "2.0 %" in widths.alt or "2 %" in widths.alt


def test_what_a_contraction_brings_is_seen_though_the_stresses_stay() -> None:
    """A panel of the widths, measured and by both models, and how far off they are in the heading."""
    stretch = np.linspace(1.0, 1.5, 9)
    widths = [(stretch, stretch**-0.3, stretch**-0.5, stretch**-0.3)]
    figure = LoopPicture(**drawn(stretch, {"stretch": stretch}) | {"widths": widths}).drawing()
    (axes,) = [one for one in figure.axes if one.get_ylabel() == "transverse stretch"]
    assert [line.get_ydata()[-1] for line in axes.lines] == pytest.approx([1.5**-0.3, 1.5**-0.5, 1.5**-0.3])
    missed = np.sqrt(np.mean((stretch**-0.3 - stretch**-0.5) ** 2) / np.mean((1.0 - stretch**-0.3) ** 2))
    words = " ".join(figure.get_suptitle().split())
    assert f"how much narrower it becomes by {100.0 * missed:.2g} % refitted, 0 % at the end" in words
