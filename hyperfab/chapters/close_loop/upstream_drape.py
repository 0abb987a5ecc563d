"""The documents behind a drape: its fabric, how it is mounted, what it rubs on; each put right."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from hyperfab.arrays import Array
from hyperfab.cases.drape import DrapeCase
from hyperfab.chapters.close_loop.domain import Given
from hyperfab.chapters.close_loop.drape import Forward
from hyperfab.chapters.close_loop.extended_sheet import drape_applied, sized
from hyperfab.chapters.close_loop.softening import scaled_material
from hyperfab.chapters.close_loop.unsure import STRETCH_SD, TOGETHER
from hyperfab.chapters.close_loop.upstream import Link, add
from hyperfab.chapters.close_loop.upstream_written import Corrected
from hyperfab.documents.loop import LoopDocument
from hyperfab.io.json_io import dump_json
from hyperfab.io.output import Output
from hyperfab.loop.drape import ASIDE, DEPTH_SD, SIZES, DrapeProblem, Markers, at_markers
from hyperfab.loop.engine import Finding
from hyperfab.loop.upstream import Readings

#: What the friction, the mold's size (a share of it) and its place [mm] are off by, where nothing is stated.
_FRICTION, _LARGER, _ASIDE = 0.1, 0.01, 1.0
#: Chapters whose numbers err together in part: constants of one fabric, the ways of one mold.
_ALIKE = ("fabric", "mold")


@dataclass(frozen=True)
class Moved:
    """A number of the fabric (a factor on it) or of the set-up that the emulator of the drape moves."""

    name: str
    sd: float
    size: float = 1.0


class DrapeChain:
    """A drape and the fabric behind it, by the emulator that the loop has made of it."""

    def __init__(self, forward: Forward, problem: DrapeProblem, share: float) -> None:
        self.forward, self.problem, self.share = forward, problem, share
        self.left_out = ["the mold's shape: but for its size the surface is taken as it is drawn"]
        if forward.material is None:
            self.left_out.append("fabric: tests that are taken as laws as they stand; hf fit makes a document of them")

    def _chapters(self) -> dict[str, list[Moved]]:
        draped, material = self.problem.draped, self.forward.material
        fabric = []
        if material is not None:
            fabric = [
                Moved(name, self.share * float(far), float(material.parameters.get(name, 1.0)))
                for name, far in zip(draped.names, self.forward.widths, strict=True)
            ]
        return {
            "fabric": fabric,
            "mounting": [
                Moved("depth", DEPTH_SD),
                Moved("prestretch", STRETCH_SD),
                Moved("weft more", STRETCH_SD),
                *(Moved(way, _ASIDE) for way in ASIDE if way in draped.axes),
            ],
            "friction": [Moved("friction", _FRICTION)] if draped.friction else [],
            "mold": [Moved(way, _LARGER) for way in SIZES if way in draped.axes],
        }

    def links(self, readings: Sequence[Markers]) -> tuple[Array, list[Link]]:
        """Return where the markers are as the documents have them (n,), and each chapter."""
        links = []
        for chapter, numbers in self._chapters().items():
            sd = np.array([one.sd * one.size for one in numbers])
            alike = TOGETHER if chapter in _ALIKE else 0.0
            covariance = alike * np.outer(sd, sd) + (1.0 - alike) * np.diag(sd**2)
            if numbers:
                document = {"fabric": self.forward.case.material, "mold": self.forward.case.mold[0]}.get(chapter)
                predict = self._predict(numbers)
                links.append(Link(chapter, covariance, predict, document or "", tuple(numbers)))
        return self._at(self.problem.given, {}), links

    def _predict(self, numbers: Sequence[Moved]) -> Callable[[Array], Array]:
        def predict(change: Array) -> Array:
            own, amounts = self._moved(numbers, change)
            if amounts.get("friction", 0.0) < -self.forward.case.friction or np.any(own[:-1] <= 0.0):
                return np.full(sum(one.values.size for one in self.problem.files), np.nan)
            return self._at(own, amounts)

        return predict

    def _moved(self, numbers: Sequence[Moved], change: Array) -> tuple[Array, dict[str, float]]:
        """Return the loop's own constants, and what is added to the emulator's settings."""
        by = {one.name: float(v) / one.size for one, v in zip(numbers, change, strict=True)}
        own = np.array([one.value + by.pop(one.name, 0.0) for one in self.problem.own])
        return own, by

    def _at(self, own: Array, amounts: dict[str, float]) -> Array:
        return np.concatenate(self.problem.at(own, amounts)[: len(self.problem.files)])

    def run_anew(self, link: Link, change: Array, readings: Sequence[Markers]) -> tuple[Corrected, Array]:
        """Return the drape with a chapter's constants changed, and where the markers are, draped anew on the whole grid
        (n,)."""
        own, amounts = self._moved(link.numbers, change)
        draped, sheet = self.problem.draped, self.forward.sheet
        corrected = self._corrected(link, own, amounts)
        nodes = self.forward.nodes(own[:-1], {"depth": float(own[-1]), **amounts}, (sheet.n, sheet.m))
        there = replace(draped, base=nodes, finer=())
        return corrected, np.concatenate([at_markers(there, one.flat)[0][0].T.ravel() for one in readings])

    def _corrected(self, link: Link, own: Array, amounts: dict[str, float]) -> Corrected:
        case: DrapeCase = drape_applied(self.forward.case, {"depth": float(own[-1]), **amounts})
        material = self.forward.material
        if link.name == "mold":
            case, data = sized(case, link.document, self.forward.placed(amounts))
            return Corrected(case, {link.document: data}, data, case)
        if material is None or link.name != "fabric":
            return Corrected(case, {}, None, case)
        factors = dict(zip(self.problem.draped.names, map(float, own), strict=False))
        document = dump_json(scaled_material(material, factors).to_json())
        return Corrected(case, {link.document: document}, document, case)


def tracing(
    forward: Forward, problem: DrapeProblem, given: Given, out: Output
) -> Callable[[Finding, LoopDocument], list[str]]:
    """Return what traces a finding on a drape to the documents behind it."""
    files = problem.files
    places = np.concatenate([np.tile(one.flat, (3, 1)) for one in files])
    kind = np.concatenate([np.repeat([0, 1, 2], len(one.flat)) for one in files])

    def traced(found: Finding, result: LoopDocument) -> list[str]:
        rows = len(places)
        read = Readings(problem.measured[:rows], found.noise.sd[:rows], places, kind, found.noise.dof)
        chain = DrapeChain(forward, problem, given.surely)
        return add(forward.job, given, out, result, chain, files, read, np.ones(rows, dtype=bool))

    return traced
