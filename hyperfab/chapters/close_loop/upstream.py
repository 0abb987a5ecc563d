"""A misfit traced upstream: which of the documents behind a model is off, and that document put right."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Protocol

import numpy as np

from hyperfab.arrays import Array, Flags
from hyperfab.chapters.close_loop.describe import errors_of
from hyperfab.chapters.close_loop.domain import Given
from hyperfab.chapters.close_loop.upstream_written import Corrected, write
from hyperfab.chapters.job import Job
from hyperfab.documents.loop import ChapterTried, LoopDocument, MovedConstant, Upstream
from hyperfab.errors import NotConverged
from hyperfab.io.output import Output
from hyperfab.loop.upstream import ELSE, STATED, Chapter, Readings, Trace, run_anew, trace

#: How often the chain is run anew with a chapter put right, each time nearer to its best.
_RUNS = 3
#: What shows a chapter by itself.
CHECKS = {
    "fabric": "test the fabric along warp and weft again (hf fit), or mark the sheet and look where it drapes",
    "temperature": "a thermocouple on each mold's work surface when the press closes",
    "foam": "press the foam alone between plates (force over travel), and gauge its thickness",
    "mounting": "dial gauges at four sides of the female's mounting face, and a feeler gauge at the datum",
    "sheet": "mark the sheet, and trace the drape (hf close-loop DRAPE.json MARKERS.csv --upstream)",
    "mold": "the mold's width and height, by a calliper",
    "friction": "pull a strip of the fabric over the mold's material (ISO 8295)",
}
#: The chapter that has what an entry of the catalogue adds: both are one finding.
_HAS = {
    **dict.fromkeys(("tilt", "lateral-shift", "pretension"), "mounting"),
    **dict.fromkeys(("foam-shrinkage", "foam-relaxation", "foam-softening", "thickness-variation"), "foam"),
    **dict.fromkeys(("set", "fabric-compression"), "foam"),
    "thermal-expansion": "temperature",
    "friction": "friction",
    "mold-size": "mold",
}


@dataclass(frozen=True)
class Link(Chapter):
    """A chapter of a model with its ``document``, and the ``numbers`` (k) of that which may be off, as its chain has
    them: each with its name."""

    document: str
    numbers: tuple[Any, ...]


class Chain(Protocol):
    """A model and the documents behind it."""

    left_out: list[str]

    def links(self, readings: Sequence[Any]) -> tuple[Array, list[Link]]:
        """Return what the model shows at readings (n,) as its documents are, and each chapter."""

    def run_anew(self, link: Link, change: Array, readings: Sequence[Any]) -> tuple[Corrected, Array]:
        """Return the chain with a chapter's constants changed, and what that shows at the readings (n,), run anew;
        NotConverged where it has no answer."""


@dataclass(frozen=True)
class Traced:
    """What came out: the verdict, the likeliest link at fault and the chain with it put right, None where it is none,
    and what is shown then (n,)."""

    trace: Trace
    verdict: str
    link: Link | None = None
    corrected: Corrected | None = None
    shown: Array | None = None


def follow(chain: Chain, readings: Sequence[Any], read: Readings) -> tuple[Traced, list[Link]]:
    """Return which document behind a model is off; the chapter that is named is one with which the whole chain, run
    anew, misses by less. Each that is suspected is weighed by what the chain shows with it."""
    stated, links = chain.links(readings)
    found = trace(read, stated, links)
    by_name = {link.name: link for link in links}
    runs: dict[str, list[tuple[Corrected, Array]]] = {}
    suspected, failed, moving = [*found.suspects], set[str](), list[str]()
    # Where one falls short as it is run others come under suspicion: the list grows.
    for name in suspected:
        if name == ELSE:
            continue
        done = runs.setdefault(name, [])
        for number in range(_RUNS):
            try:
                done.append(chain.run_anew(by_name[name], found.blamed[name].change, readings))
            except NotConverged as error:
                chain.left_out.append(f"{name}: the chain with it put right has no answer: {error}")
                failed.add(name)
                break
            found, at_best = run_anew(found, name, done[-1][1], last=number == _RUNS - 1)
            suspected += [one for one in found.suspects if one not in suspected]
            if at_best:
                break
        else:
            moving.append(name)
    if not found.suspects or found.suspects[0] == ELSE:
        return Traced(found, found.verdict), links
    if found.suspects[0] in failed:
        return Traced(found, ELSE), links
    missed = {name: [_missed(read, one) for _, one in each] for name, each in runs.items()}
    least = missed[found.suspects[0]][-1]
    # What would be there with one more step like its last is not ruled out.
    nearer = [
        name for name in moving if name not in found.suspects and 2.0 * missed[name][-1] - missed[name][-2] <= least
    ]
    chain.left_out += [
        f"{name}: still nearer with each run of the chain; it may be likelier than told" for name in nearer
    ]
    found = replace(found, suspects=(*found.suspects, *nearer))
    link = by_name[found.suspects[0]]
    put_right, shown = runs[link.name][-1]
    if least >= _missed(read, stated):
        return Traced(found, ELSE), links
    return Traced(found, found.verdict, link, put_right, shown), links


def _missed(read: Readings, shown: Array) -> float:
    """Return how far readings are missed: mean square, in standard deviations of their noise."""
    return float(np.mean(((read.measured - shown) / read.sd) ** 2))


def add(
    job: Job,
    given: Given,
    out: Output,
    result: LoopDocument,
    chain: Chain,
    readings: Sequence[Any],
    read: Readings,
    first: Flags,
) -> list[str]:
    """Trace the misfit, say it in ``result``, and queue the corrected document; return what is to be said.

    ``first`` (n,) are the rows whose error is told: those of one unit.
    """
    traced, links = follow(chain, readings, read)
    found = traced.trace
    unit = result.error.unit

    def errors(after: Array) -> Any:
        return errors_of(read.measured[first], found.stated[first], after[first], read.sd[first], unit)

    told = Upstream(
        verdict=traced.verdict,
        probability=dict(found.probability),
        chapters=[
            ChapterTried(
                chapter=link.name,
                document=link.document or None,
                probability=found.probability[link.name],
                off=found.blamed[link.name].off,
                error=errors(found.blamed[link.name].predicted),
                constants=_constants(link, found),
                shown_by=CHECKS.get(link.name.rpartition(" ")[2], ""),
            )
            for link in links
        ],
        indistinguishable=list(found.suspects) if traced.verdict == "ambiguous" else [],
        left_out=list(chain.left_out),
    )
    if traced.link is not None and traced.corrected is not None and traced.shown is not None:
        told.chapter = traced.link.name if traced.verdict == "chapter" else None
        told.document = traced.link.document or None
        told.error = errors(traced.shown)
        if out.wants_files:
            told.written, commands = write(job, given, out, traced.link.document, traced.corrected)
            told.command, told.then = (commands[0], commands[1:]) if commands else (None, [])
    told.instead_of = instead_of(result, found.suspects)
    # What is not told from a document that is off is not sure to lack.
    if told.instead_of and result.verdict == "effect":
        result.verdict = "ambiguous"
    result.upstream = told
    return [*_say(told), *_both(told, result.verdict)]


def instead_of(result: LoopDocument, suspects: Sequence[str]) -> list[str]:
    """Return the effects in whose place a document may be off that does not have what they add, or what is not told
    from them."""
    if not suspects or ELSE in suspects:
        return []
    chapters = {one.rpartition(" ")[2] for one in suspects}
    alike = {names[0]: names for names in result.indistinguishable}
    named = {one.id: {_HAS.get(name, "") for name in alike.get(one.id, [one.id])} for one in result.effects}
    return [name for name, own in named.items() if not chapters <= own]


def _both(told: Upstream, verdict: str) -> list[str]:
    """Return in a sentence how what lacks and what is off go together."""
    chapters = " or ".join(told.indistinguishable or [told.chapter or ""])
    if told.instead_of:
        names = " and ".join(told.instead_of)
        return [
            f"Upstream: {names} and {chapters} are no two findings: with the document put right {names} is not needed, "
            "and these data cannot tell which it is. Make the check upstream before anything is added to the model."
        ]
    if verdict == "unexplained" and (told.chapter or told.indistinguishable) and ELSE not in told.indistinguishable:
        return [f"Upstream: {chapters} explains what no entry of the catalogue does: put that right, and add nothing."]
    return []


def _constants(link: Link, found: Trace) -> list[MovedConstant]:
    best = found.blamed[link.name]
    known = np.sqrt(np.diag(link.covariance))
    return [
        MovedConstant(name=_bare(number.name), change=float(by), sd=float(sd), known_sd=float(before))
        for number, by, sd, before in zip(link.numbers, best.change, best.sd, known, strict=True)
    ]


def _bare(name: str) -> str:
    """Return a number's name with its document as it is called, wherever it was made anew.

    >>> _bare("build/mold.toml: heater.0.power"), _bare("gap_mm")
    ('mold.toml: heater.0.power', 'gap_mm')
    """
    file, mark, key = name.partition(": ")
    return f"{os.path.basename(file)}{mark}{key}"


def _say(told: Upstream) -> list[str]:
    """Return the finding in sentences."""
    likely = max(told.chapters, key=lambda one: one.probability)
    if told.verdict == STATED:
        return ["Upstream: nothing says that one of the documents behind the model is off."]
    if told.verdict == ELSE:
        return [
            "Upstream: no one document behind the model explains the misfit with constants near what it states; the "
            f"nearest is {likely.chapter} ({_percent(likely.probability)})."
        ]
    error, lines = told.error, []
    how = moved(likely.constants)
    begins = f"{likely.chapter} is off ({_percent(likely.probability)})"
    if told.verdict == "ambiguous":
        checks = {one.chapter: one.shown_by for one in told.chapters}
        ways = "; ".join(f"{name}: {checks[name]}" for name in told.indistinguishable if name in checks)
        lines = [f"Upstream: {' or '.join(told.indistinguishable)}; these data cannot tell. Measure next: {ways}."]
        begins = f"if {likely.chapter} is off"
    if error is None:
        return lines
    text = (
        f"Upstream: {begins}, {how}; the chain, run anew, then misses by {error.after.rms:.3g} {error.unit} instead of "
        f"{error.before.rms:.3g} {error.unit}."
    )
    if told.written:
        what = os.path.basename(told.document) if told.document else "the model"
        text += f" {told.written} is {what} put right: {'; then '.join([told.command or '', *told.then])}"
    return [*lines, text]


def moved(constants: Sequence[MovedConstant]) -> str:
    """Return which constant of a chapter is off and by how much, or between which ones these data cannot tell."""
    ranked = sorted(constants, key=lambda one: -abs(one.change) / max(one.known_sd, 1e-300))
    how = ranked[0]
    others = [one for one in ranked[1:] if abs(one.change) > 0.25 * abs(how.change) * one.known_sd / how.known_sd]
    if others and abs(how.change) < 2.0 * how.sd:
        each = " and ".join(f"{one.name} (by {one.change:.3g} ± {one.sd:.2g})" for one in [how, *others])
        return f"these data see {each} together and do not tell one from another"
    return f"it is most of all {how.name}, by {how.change:.3g} ± {how.sd:.2g}"


def _percent(probability: float) -> str:
    return "over 99.9 %" if probability > 0.999 else f"{100.0 * probability:.3g} %"
