"""The first screen: one sentence, five figures and two pictures that one can put before a customer."""

from __future__ import annotations

import base64
import io
import re
import zlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from PIL import Image, ImageColor, ImageDraw

from hyperfab.arrays import Array
from hyperfab.report.page.parts import Chart, Figure, Scene, Section, Source, rounded

#: What a first screen holds.
MOST_FIGURES, MOST_PICTURES, MOST_CLAIMS = 5, 2, 3
#: Kinds in the order in which their figures and pictures tell most about a part.
WEIGHT = ("press", "drape", "heat", "loop", "contact", "sweep", "material")
#: Kinds in the order in which a sentence tells them.
TOLD = ("material", "drape", "contact", "heat", "press", "loop", "sweep")


@dataclass(frozen=True)
class FrontPicture:
    """A picture of the first screen: WebP of a view, or the number of a chart among the section's parts."""

    section: int
    caption: str
    image: bytes | None = None
    chart: int | None = None
    #: Colours of the scale and what stands at its ends.
    colours: str = ""
    ends: tuple[str, str] = ("", "")


@dataclass(frozen=True)
class FrontPage:
    """What stands on the first screen; figures and pictures with the number of their section."""

    sentence: str
    figures: list[tuple[int, Figure]]
    pictures: list[FrontPicture]


def front(told: Sequence[tuple[Source, Section]]) -> FrontPage:
    """Return the first screen of sections: the last document of each kind speaks for it."""
    last = {source.kind: number for number, (source, section) in enumerate(told) if section.figures}
    ranked = [last[kind] for kind in WEIGHT if kind in last]
    return FrontPage(_sentence(told, last), _figures(told, ranked), _pictures(told))


def _sentence(told: Sequence[tuple[Source, Section]], last: dict[str, int]) -> str:
    weighty = [kind for kind in WEIGHT if kind in last and told[last[kind]][1].claim][:MOST_CLAIMS]
    claims = [told[last[kind]][1].claim for kind in TOLD if kind in weighty]
    if not claims:
        return ""
    text = claims[0] if len(claims) == 1 else f"{', '.join(claims[:-1])}, and {claims[-1]}"
    text = re.sub(r"(?<=\d) (?=(?:°C|K|N|MPa|kPa|mm|min|MJ)\b|%)", "\N{NO-BREAK SPACE}", text)
    return f"{text[0].upper()}{text[1:]}."


def _figures(told: Sequence[tuple[Source, Section]], ranked: Sequence[int]) -> list[tuple[int, Figure]]:
    """Take the first figure of each kind, then the second, until there are enough; in the order of the line."""
    chosen: list[tuple[int, int]] = []
    for turn in range(MOST_FIGURES):
        for number in ranked:
            if turn < len(told[number][1].figures) and len(chosen) < MOST_FIGURES:
                chosen.append((number, turn))
    return [(number, told[number][1].figures[turn]) for number, turn in sorted(chosen)]


def _pictures(told: Sequence[tuple[Source, Section]]) -> list[FrontPicture]:
    found: list[FrontPicture] = []
    kinds = {source.kind: number for number, (source, _) in enumerate(told)}
    ranked = [kinds[kind] for kind in WEIGHT if kind in kinds]
    for number in ranked:
        scene = next((part for part in told[number][1].parts if isinstance(part, Scene)), None)
        if scene is not None and len(found) < MOST_PICTURES:
            found.append(_of_view(number, scene))
    for number in ranked:
        parts = told[number][1].parts
        charts = [place for place, part in enumerate(parts) if isinstance(part, Chart)]
        if charts and len(found) < MOST_PICTURES and all(one.section != number for one in found):
            chart = parts[charts[0]]
            found.append(FrontPicture(number, chart.caption, chart=charts[0]))
    return sorted(found, key=lambda one: one.section)


def _of_view(number: int, scene: Scene) -> FrontPicture:
    """Return the still of a view: of stretches the one that goes furthest, else its first field."""
    stretches = [place for place, one in enumerate(scene.fields) if one["name"].startswith("stretch_w")]
    shown = max(stretches, key=lambda place: scene.fields[place]["high"]) if stretches else 0
    field = scene.fields[shown]
    unit = f" {field['unit']}" if field["unit"] else ""
    ends = field.get("words") or tuple(f"{rounded(field[end], 3)}{unit}" for end in ("low", "high"))
    stops = ", ".join(f"{colour} {100 * place:.0f}%" for place, colour in field["colours"])
    return FrontPicture(number, field["title"], still(scene, shown), colours=stops, ends=ends)


#: Pixels of the picture; it is drawn at twice the size and made smaller, for smooth edges.
WIDTH, HEIGHT, FINER = 880, 560, 2
#: Share of light that falls everywhere; the rest comes from above the eye's left shoulder.
AMBIENT = 0.62


def still(scene: Scene, field: int = 0) -> bytes:
    """Return the WebP of a view, coloured by its field of that number; the paper around it is transparent."""
    points = np.stack([unpacked(scene.mesh[axis]) for axis in "xyz"], axis=1)
    corners = np.stack([unpacked(scene.mesh[corner]) for corner in "ijk"], axis=1).astype(np.int64)
    given = scene.fields[field]
    values = unpacked(given["values"])
    share = np.clip((values - given["low"]) / (given["high"] - given["low"]), 0.0, 1.0)
    odd = np.full(len(corners), -1)
    if given["mode"] == "vertex":
        share = share[corners]
        if given.get("words"):  # what is, is or is not: a triangle across the border is divided
            share = np.rint(share)
            count = share.sum(axis=1)
            for alone in (1, 2):
                rows = count == alone
                odd[rows] = np.argmax(share[rows] == (alone == 1), axis=1)
            share = (count >= 2).astype(float)
        else:
            share = share.mean(axis=1)
    across, up, toward = _camera(scene.eye)
    flat = np.stack([points @ across, -(points @ up)], axis=1)
    flat -= flat.min(axis=0)
    size = np.array([WIDTH, HEIGHT]) * FINER
    scale = float(np.min((size - 16.0) / np.maximum(flat.max(axis=0), 1e-9)))
    flat = flat * scale + (size - flat.max(axis=0) * scale) / 2
    a, b, c = (points[corners[:, index]] for index in range(3))
    normals = np.cross(b - a, c - a)
    normals /= np.maximum(np.linalg.norm(normals, axis=1), 1e-300)[:, None]
    light = toward + 0.6 * up - 0.5 * across
    bright = AMBIENT + (1.0 - AMBIENT) * np.abs(normals @ (light / np.linalg.norm(light)))
    colours = (_colours(given["colours"], share) * bright[:, None]).round().astype(int)
    others = (_colours(given["colours"], 1.0 - share) * bright[:, None]).round().astype(int)
    picture = Image.new("RGBA", (int(size[0]), int(size[1])), (255, 255, 255, 0))
    draw = ImageDraw.Draw(picture)
    places = flat[corners].reshape(-1, 6)
    for face in np.argsort((a + b + c) @ toward, kind="stable"):
        shade = (*map(int, colours[face]), 255)
        draw.polygon(places[face].tolist(), fill=shade, outline=shade)
        if odd[face] >= 0:
            own = flat[corners[face]]
            half = 0.5 * (own + own[odd[face]])
            shade = (*map(int, others[face]), 255)
            draw.polygon(half.ravel().tolist(), fill=shade, outline=shade)
    used = picture.getbbox() or (0, 0, *picture.size)
    small = picture.crop(used)
    small = small.resize((max(small.width // FINER, 1), max(small.height // FINER, 1)), Image.Resampling.BOX)
    buffer = io.BytesIO()
    small.save(buffer, "WEBP", quality=90, method=4)
    return buffer.getvalue()


def unpacked(packed: Mapping[str, Any]) -> Array:
    """Return the numbers that a view packs."""
    data = zlib.decompress(base64.b64decode(packed["deflated"]))
    whole = np.frombuffer(data, dtype=f"<{packed['dtype']}").astype(np.float64)
    return whole if "step" not in packed else packed["low"] + whole * packed["step"]


def _camera(eye: Sequence[float]) -> tuple[Array, Array, Array]:
    """Return the directions to the right, up and towards the eye."""
    toward = np.asarray(eye, dtype=np.float64)
    toward = toward / np.linalg.norm(toward)
    across = np.cross([0.0, 0.0, 1.0], toward)
    across /= np.linalg.norm(across)
    return across, np.cross(toward, across), toward


def _colours(stops: Sequence[tuple[float, str]], share: Array) -> Array:
    """Return red, green and blue (0 to 255) for shares of the scale."""
    at = [place for place, _ in stops]
    bands = np.array([ImageColor.getrgb(colour) for _, colour in stops], dtype=np.float64)
    return np.stack([np.interp(share, at, bands[:, band]) for band in range(3)], axis=1)
