"""The first screen: one sentence, five figures and two pictures that one can put before a customer."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

from hyperfab.report.page.parts import Chart, Figure, Scene, Section, Source, rounded
from hyperfab.report.page.still import still

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
