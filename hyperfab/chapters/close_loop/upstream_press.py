"""The documents behind a press: what each may be off by, what the press then shows, and each one put right."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy.linalg import block_diag

from hyperfab.arrays import Array
from hyperfab.cases.case import Case, tolerances
from hyperfab.cases.drape import DrapeCase
from hyperfab.cases.mold import MoldCase
from hyperfab.cases.press import PressCase
from hyperfab.chapters.close_loop.domain import Given
from hyperfab.chapters.close_loop.extended_sheet import drape_applied
from hyperfab.chapters.close_loop.handing import More, handing, hands_on, slope, warmer
from hyperfab.chapters.close_loop.press import closed_press
from hyperfab.chapters.close_loop.unsure import STRETCH_SD, is_length, mounted, of_sandwich, unsure_fabric, unsure_mold
from hyperfab.chapters.close_loop.upstream import Link, add
from hyperfab.chapters.close_loop.upstream_readings import is_traced, placed, seen_in
from hyperfab.chapters.close_loop.upstream_written import Corrected, names_layer
from hyperfab.chapters.job import Job
from hyperfab.chapters.press_contact import solve
from hyperfab.chapters.press_contact.heat import file_of
from hyperfab.chapters.press_contact.model import model_of, read_files
from hyperfab.chapters.press_contact.nearby import beside
from hyperfab.chapters.rerun import Listener, Overlay, rerun, unchanged
from hyperfab.chapters.uncertainty.changed import Changed, Kept
from hyperfab.chapters.uncertainty.handed import Handed, join
from hyperfab.chapters.uncertainty.sources import (
    Entry,
    Number,
    Origin,
    Origins,
    Setting,
    Stiffness,
    origins,
    read_as,
    together,
)
from hyperfab.chapters.validity import Ranges
from hyperfab.documents.base import parse_document
from hyperfab.documents.loop import LoopDocument
from hyperfab.documents.material import MaterialDocument
from hyperfab.documents.mold import MoldDocument
from hyperfab.errors import NotConverged, UsageError
from hyperfab.io.json_io import dump_json
from hyperfab.io.output import Output
from hyperfab.io.toml_io import dump_toml
from hyperfab.loop.engine import Finding
from hyperfab.loop.press import GAP_SD, PressProblem
from hyperfab.loop.press_reading import Reading

#: What both molds' temperature is off by [K], where nothing is stated, and one that is known as a whole only.
_KELVINS = 5.0
#: The chapter of how a drape's sheet was mounted, and its numbers; what both molds are off by together.
SHEET, MOUNTED, _BOTH = "sheet", ("prestretch", "weft more"), "both molds: temperature_K"


@dataclass(frozen=True)
class _Behind:
    """A document that hands a field on: its file, the case it was made by, and the document that case reads."""

    file: str
    case: Case
    source: str
    chapter: str


class PressChain:
    """A press and the documents behind it, each as unsure as one at fault may be."""

    def __init__(self, job: Job, case: PressCase, share: float) -> None:
        self.job, self.case, self.share = job, replace(case, uncertainty=None), share
        self.asked = case
        self.behind = self._documents()
        self.sources = {one.chapter: one.source for one in reversed(self.behind)}
        self.left_out: list[str] = []
        if case.drape is not None:
            self.left_out.append(
                "what the drape's sheet rubs on: foam may stand for that. Mark the sheet, and trace the drape"
            )
        #: The sandwich as it is, with a place for all that may be off.
        self.foam: dict[str, bytes] = {}
        given: dict[str, bytes] = {}
        for one in self.behind:
            given |= self._unsure(one)
        #: The chapters of numbers that documents are made to hand on, by the numbers' ids.
        self.more: dict[str, str] = {}
        given |= self._mounted_sheet(given) | self._warmer_molds(given)
        if case.foam.endswith(".toml"):
            self.foam[case.foam] = dump_toml(mounted(job.inputs.plain(case.foam), case))
            self.case = replace(self.case, tilt=None)
        given |= self.foam
        self.quiet = replace(job, console=Listener(), inputs=Overlay(given))
        model = model_of(self.quiet, self.case, read_files(self.quiet, self.case))
        self.result = solve(self.quiet, model)
        #: What may be off, and the chapter of each.
        self.origins, self.chapters = Origins(), list[str]()
        self._own()
        self._handed()
        near = beside(self.quiet, model, self.result.closed, self.origins)
        if near is None:
            raise UsageError(
                "--upstream: molds that a field of temperature deforms are traced from a sure reference only: state "
                f"expansion.reference in {case.foam} without its tolerance"
            )
        self.near = near

    def _documents(self) -> list[_Behind]:
        """Return the documents whose fields the press takes, and what they were made from."""
        found, case = [], self.case
        if case.drape is not None:
            made = self._made(DrapeCase, case.drape)
            if made.material is not None:
                found.append(_Behind(case.drape, made, made.material, "fabric"))
        heat = [(side, file_of(name)[0]) for side, name in (("male", case.male_heat), ("female", case.female_heat))
                if name is not None]  # fmt: skip
        sides = {name: side for side, name in reversed(heat)}
        molds = {name: self._made(MoldCase, name) for name in sides}
        alone = len({made.mold for made in molds.values()}) == 1
        for name, made in molds.items():
            found.append(_Behind(name, made, made.mold, "temperature" if alone else f"{sides[name]} temperature"))
        return found

    def _made(self, cls: Any, name: str) -> Any:
        return unchanged(cls, self.job.inputs.plain(name), name).case

    def _unsure(self, one: _Behind) -> dict[str, bytes]:
        """Return a document made anew from a source that states how unsure it is, and its field: files by name."""
        plain = self.job.inputs.plain(one.source)
        fabric = one.chapter == "fabric"
        source = dump_json(unsure_fabric(plain, self.share)) if fabric else dump_toml(unsure_mold(plain, self.share))
        # A steady run hands nothing on, whatever its inputs state.
        steady = not fabric and self.job.inputs.plain(one.file).get("steady", False)
        return {one.source: source} | _made_again(one, {one.source: source}, "none" if steady else "linear")

    def _mounted_sheet(self, given: Mapping[str, bytes]) -> dict[str, bytes]:
        """Return the drape and its field with how its sheet was stretched handed on too."""
        if self.case.drape is None:
            return {}
        case, name = self._made(DrapeCase, self.case.drape), self.case.drape
        numbers = []
        for key in MOUNTED:
            try:
                low, high = (
                    Overlay(_run_anew(name, drape_applied(case, {key: by * STRETCH_SD}))) for by in (-1.0, 1.0)
                )
            except NotConverged as error:
                self.left_out.append(f"{SHEET}: {key}: {error}; foam may stand for that")
                continue
            numbers.append(More(f"{name}: {key}", key, STRETCH_SD, slope((low, high), name, STRETCH_SD)))
        self.more |= {one.id: SHEET for one in numbers}
        self.sources[SHEET] = name
        return handing(Overlay(given), name, numbers) if numbers else {}

    def _warmer_molds(self, given: Mapping[str, bytes]) -> dict[str, bytes]:
        """Return heat documents that hand nothing on, as those of a steady run, with how hot each is as a whole handed
        on, and how hot both are."""
        inputs, found = Overlay(given), dict[str, bytes]()
        molds = [one for one in self.behind if one.chapter.endswith("temperature")]
        silent = [one for one in molds if not hands_on(inputs, one.file)]
        for one in silent:
            by = warmer(inputs, one.file)
            key = f"{one.file}: temperature_K"
            numbers = [More(key, key, _KELVINS, by)]
            self.more[key] = one.chapter
            self.sources[one.chapter] = one.file
            if len(silent) > 1:
                numbers.append(More(_BOTH, _BOTH, _KELVINS, by))
                self.more[_BOTH] = "temperature"
            found |= handing(inputs, one.file, numbers)
        if len(molds) > max(len(silent), 1):
            self.left_out.append(
                "both molds off together, by the room or by what feeds both: each is looked at by itself; foam may "
                "stand for that"
            )
        return found

    def _own(self) -> None:
        """Add what the press itself and its sandwich may be off by."""
        name, case = self.case.foam, self.case
        if self.foam:
            for chapter, one in of_sandwich(self.quiet.inputs, name, self.share, case.drape is not None):
                self._add(chapter, one)
            self._layers(name)
        else:
            material, _ = read_as(self.quiet.inputs, name, MaterialDocument)
            thick = Entry(name, ("thickness_mm",), 0.0)
            self._add("foam", together([Stiffness(name, (("parameters",),), "")], self.share))
            self._add("foam", together([thick], self.share * float(material.thickness_mm or 0.0)))
            self.left_out.append(
                "mounting: a foam's material document has no place for tilt and offset; write a foam.toml"
            )
        for field, chapter, sd in (
            ("gap", "mounting", GAP_SD),
            ("temperature", "temperature", _KELVINS),
        ):
            value = getattr(case, field)
            if value is not None:
                key = case.settings()[field].key
                self._add(chapter, together([Setting(key)], tolerances(value, key).get(key, sd)))

    def _layers(self, name: str) -> None:
        """Add the thickness of fabrics that the sandwich takes from their documents."""
        layers = self.quiet.inputs.plain(name).get("fabric", {})
        named = (layers.get(key) for key in ("above", "below"))
        for text in dict.fromkeys(text for text in named if text and not is_length(text)):
            file = self.job.inputs.beside(name, text)
            thick = read_as(self.quiet.inputs, file, MaterialDocument)[0].thickness_mm
            if thick is not None:
                self._add("fabric", together([Entry(file, ("thickness_mm",), 0.0)], self.share * thick))
                self.sources.setdefault("fabric", file)

    def _handed(self) -> None:
        """Add what the documents behind hand on; a number that acts by way of several is one."""
        for one in self.behind:
            join(self.origins, self.quiet.inputs, [one.file])
            new = self.origins.found[len(self.chapters) :]
            self.chapters += [self.more.get(origin.ids[0], one.chapter) for origin in new]
        # A document that hands nothing on cannot be at fault here.
        self.left_out += self.origins.left_out

    def _add(self, chapter: str, one: Origin) -> None:
        self.chapters.append(chapter)
        self.origins.found.append(one)

    def links(self, readings: Sequence[Reading]) -> tuple[Array, list[Link]]:
        """Return what the press shows at readings as its documents are, and each chapter."""
        seen = seen_in(self.result, readings)

        def shown(changes: Mapping[int, Array]) -> Array:
            found, sandwich = self.near.close(changes)
            return seen(sandwich, found.gap, found.touch, found)

        links = []
        for chapter in dict.fromkeys(self.chapters):
            owned = [k for k, one in enumerate(self.chapters) if one == chapter]
            sources = [self.origins.found[k] for k in owned]
            cuts = np.cumsum([len(one.numbers) for one in sources])[:-1]

            def predict(change: Array, owned: list[int] = owned, cuts: Array = cuts) -> Array:
                try:
                    return shown(dict(zip(owned, np.split(change, cuts), strict=True)))
                except NotConverged:  # no press stands there: constants that far off are none
                    return np.full(sum(len(one.values) for one in readings), np.nan)

            numbers = tuple(number for one in sources for number in one.numbers)
            covariance = block_diag(*(one.source.covariance for one in sources))
            links.append(Link(chapter, covariance, predict, self._document(chapter), numbers))
        return shown({}), links

    def _document(self, chapter: str) -> str:
        return self.sources.get(chapter) or (self.case.foam if chapter in ("foam", "mounting") else "")

    def run_anew(self, link: Link, change: Array, readings: Sequence[Reading]) -> tuple[Corrected, Array]:
        """Return the press with a chapter's constants changed, and what it shows at the readings, the whole chain run
        anew."""
        corrected = self._corrected(link, change)
        case: PressCase = corrected.case  # type: ignore[assignment]
        job = replace(self.job, inputs=Overlay(corrected.files), ranges=Ranges())
        told = closed_press(job, case)[0]
        closed = told.closed
        return corrected, seen_in(told, readings)(closed.press.sandwich, closed.contact.gap, closed.touch)

    def _corrected(self, link: Link, change: Array) -> Corrected:
        """Return the chain put right: its case and the files that are other than on disk."""
        if link.name == SHEET:
            by_name = {number.name: float(by) for number, by in zip(link.numbers, change, strict=True)}
            made = drape_applied(self._made(DrapeCase, link.document), by_name)
            return Corrected(self.case, self.foam | _run_anew(link.document, made), None, self.asked, made)
        if link.name in self.more.values():
            hotter = Changed(self.case, self.quiet.inputs, Kept())
            for number, by in zip(link.numbers, change, strict=True):
                number.move(hotter, float(by))
            return Corrected(self.case, hotter.files, None, None)
        moved = Changed(self.case, Overlay(self.foam), Kept())
        for number, by in zip(link.numbers, change, strict=True):
            own = number.own if isinstance(number, Handed) else number
            if own is not None:
                own.move(moved, float(by))
        case: PressCase = moved.case
        written = dict(moved.files)
        upstream: dict[str, bytes] = {}
        for one in self.behind:
            if one.chapter != link.name:
                continue
            source = upstream.get(one.source) or self._put_right(one, link.numbers, change, written)
            upstream[one.source] = source
            written |= {one.source: source} | _made_again(one, {one.source: source}, "none")
        document = upstream.get(link.document) or written.get(link.document)
        between = {one.file: one.case for one in self.behind if one.chapter == link.name}
        # A tilt of the command's words stands in the sandwich that is put right, and there alone.
        command = case if link.document == self.case.foam else replace(case, tilt=self.asked.tilt)
        return Corrected(case, written, document, command, between=between, sandwich=self._taking(link.document))

    def _taking(self, document: str) -> str | None:
        """Return the sandwich's document where it takes a layer from that document."""
        layers = self.quiet.inputs.plain(self.case.foam).get("fabric", {}) if self.foam else {}
        named = any(names_layer(layers.get(key), self.case.foam, document) for key in ("above", "below"))
        return self.case.foam if named else None

    def _put_right(self, one: _Behind, numbers: Sequence[Number], change: Array, written: Mapping[str, bytes]) -> bytes:
        """Return the document behind a field, as ``written`` so far, with the numbers changed that it hands on."""
        unsure = self.quiet.inputs
        if one.chapter == "fabric":
            asked: float | None = one.case.temperature  # type: ignore[attr-defined]
            own = origins(unsure, one.case, {one.source: asked}).numbers
        else:
            own = origins(unsure, one.case, documents={one.source: MoldDocument}).numbers
        moved = Changed(one.case, Overlay(written), Kept())
        for number, by in zip(numbers, change, strict=True):
            if isinstance(number, Handed) and number.at.get(one.file, len(own)) < len(own):
                own[number.at[one.file]].move(moved, float(by))
        data = moved.document(one.source)
        if one.chapter == "fabric":
            return dump_json(parse_document(data, one.source, MaterialDocument).refitted().to_json())
        return dump_toml(data)


def _made_again(one: _Behind, given: Mapping[str, bytes], how: str) -> dict[str, bytes]:
    """Return the document behind a field made anew, and what lies beside it, by name."""
    return _run_anew(one.file, replace(one.case, uncertainty=how), given)  # type: ignore[call-arg]


def _run_anew(name: str, case: Case, given: Mapping[str, bytes] = {}) -> dict[str, bytes]:
    """Return the document of that name as a case makes it, and what lies beside it, by name."""
    path = Path(name)
    # Nothing is written, and the document's own folder may be one where nothing can be.
    target = str(Path(tempfile.gettempdir()) / path.name)
    made = rerun(case, target, given)
    beside_it = {str(path.with_name(path.stem + suffix)): data for suffix, data in made.siblings.items()}
    return {name: dump_json(made.document)} | beside_it


def tracing(
    job: Job, case: PressCase, given: Given, out: Output, problem: PressProblem
) -> Callable[[Finding, LoopDocument], list[str]]:
    """Return what traces a finding on a press to the documents behind it; UsageError where nothing can be traced."""
    if case.zero == "hot":
        raise UsageError("--upstream traces no clearance that is set on hot molds: take --zero cold")
    if not any(is_traced(problem, one) for one in problem.files):
        raise UsageError(
            "--upstream traces pressure, thickness or contact at places of the closed press, and force over the stroke "
            "of molds that are guided, and none was measured"
        )

    # What cannot be traced is said before the loop is closed.
    chain = PressChain(job, case, given.surely)

    def traced(found: Finding, result: LoopDocument) -> list[str]:
        readings, read = placed(problem, found.noise)
        return add(job, given, out, result, chain, readings, read, read.kind == read.kind[0])

    return traced
