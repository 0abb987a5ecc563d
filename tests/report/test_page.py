"""The page carries what the documents say, escaped, and no script but its own."""

from __future__ import annotations

import base64
import hashlib
import json
import re
import zlib
from collections.abc import Callable
from html.parser import HTMLParser
from typing import Any

import numpy as np
import pytest

from hyperfab.errors import InputError
from hyperfab.io.vtu import unstructured
from hyperfab.io.vtu_read import read_vtu
from hyperfab.report.page.parts import Section, Source, number, rounded
from hyperfab.report.page.render import page
from hyperfab.report.page.scenes import STEPS, Field, scene
from hyperfab.report.page.sections import build
from hyperfab.report.page.story import in_order, parents
from hyperfab.report.page.surface import Surface, outside, thinned

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


def source(
    kind: str, data: dict[str, Any], name: str = "a.json", read: Callable[[str], bytes] = nothing
) -> Source:
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
    one = source(
        "material", data, f"{EVIL}.json", lambda name: csv.encode() if name == "a.csv" else nothing(name)
    )
    text = page(EVIL, [(one, build(one))], None).decode()
    assert "<script>alert" not in text
    assert "<img src=x" not in text
    clean = page(
        "a", [(source("material", material()), build(source("material", material())))], None
    ).decode()
    # One script more than a plain page has: the data of the chart, which are no program.
    scripts = Found(text).named("script")
    assert [item.get("type") for item in scripts] == ["application/json", "text/plain", None]
    assert [item.get("type") for item in Found(clean).named("script")] == ["text/plain", None]


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
    whole = Surface(
        points, triangles, np.arange(len(points)), np.arange(len(triangles)), whole=len(triangles)
    )
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
    assert "1/65535 of their range" in view.caption


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
