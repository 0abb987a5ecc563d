"""What the loop on a contact, drape or press document has in common: run the engine, tell, write."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, Generic, TypeVar

import numpy as np

from hyperfab.arrays import Array
from hyperfab.cases.case import Case
from hyperfab.chapters.close_loop.describe import column, describe, errors_of, lowered, say
from hyperfab.chapters.close_loop.domain import Given, signed
from hyperfab.chapters.close_loop.left_out import OF_FILES
from hyperfab.chapters.close_loop.readings import Apart, Files, check_fixed, set_apart, told_left_out
from hyperfab.chapters.close_loop.sure import caution, noted
from hyperfab.chapters.close_loop.words import PLACES
from hyperfab.chapters.job import Job
from hyperfab.chapters.rerun import command_line, rerun
from hyperfab.console import NEGATIVE_VERDICT
from hyperfab.documents.base import Document, stated_kind
from hyperfab.documents.loop import Errors, LoopDocument
from hyperfab.errors import HyperfabError
from hyperfab.io.csv_write import csv_bytes
from hyperfab.io.json_io import dump_json
from hyperfab.io.output import Output
from hyperfab.loop.dependence import dependence
from hyperfab.loop.engine import Finding, close
from hyperfab.loop.fitting import Fit
from hyperfab.loop.known import FilesProblem
from hyperfab.loop.no_worse import none_apart
from hyperfab.loop.noise import Noise
from hyperfab.loop.problem import Curve, Problem
from hyperfab.loop.search import Search
from hyperfab.loop.thresholds import MARGIN, TOLD

P = TypeVar("P", bound=Problem)
R = TypeVar("R", bound=FilesProblem[Any])

#: Files the extended model may have beside it.
MODEL_SUFFIXES = (".model.json", ".model.vtu", ".model.csv", ".model.png")


@dataclass(frozen=True)
class Extension:
    """The case of the extended model, and files it reads that are not written yet (by suffix)."""

    case: Case
    files: Mapping[str, bytes | Document]
    notes: Sequence[str]


#: Noise that is less by as much is another: the loop is closed again with that, so often at most.
_LESS, _POINTED = 0.85, 3
#: What moves the progress line on, with what is being done; and what traces a finding to the documents behind a model.
Ticks = Callable[[str], None]
Traces = Callable[[Finding, LoopDocument], Sequence[str]]


@dataclass(frozen=True)
class Instead(Generic[P]):
    """Another kind of model that carries what was read where the one that was given does not: its ``problem``, what was
    ``found`` on it (with the given one as the state before), how it is extended and traced, and ``tell``, which says in
    the document what was changed for it."""

    problem: P
    found: Finding
    extend: Callable[[Finding], Extension]
    upstream: Traces
    tell: Callable[[LoopDocument], None]


def finish(
    job: Job,
    out: Output,
    problem: R,
    files: Files[Any],
    *,
    given: Given,
    extend: Callable[[Finding], Extension],
    axis: str = "",
    rounds: Callable[[R, Finding], R | None] = lambda problem, found: None,
    warnings: Sequence[str] = (),
    upstream: Traces | None = None,
    instead: Callable[[R, Finding, Ticks], Instead[R] | None] = lambda problem, found, tick: None,
) -> int:
    """Close the loop, write the finding and the extended model; return the exit status.

    ``axis`` is the state that the curves are drawn over: the first where none is named. ``rounds`` returns the
    problem posed anew around a finding (a better linearisation), or None where it is good. ``upstream`` traces the
    misfit to the documents behind the model and returns what it says. ``instead`` returns another kind of model
    where that carries what this one does not.
    """
    domain, gone, apart = stated_kind(given.data), dict(files.left_out), files.apart
    check_fixed(given.case.fix, [one.name for one in problem.own], "press" if domain == "press" else "sheet")
    warnings = [*warnings, *told_left_out(gone)]
    job.console.warn(*warnings)
    job.console.note(*files.preparation)
    traced: Sequence[str] = ()
    with job.console.progress("Closing the loop") as advance:
        tick = ticking(advance, 0.3)
        problem, found = close_rounds(problem, files.noise, rounds, tick, misses=files.misses)
        other = instead(problem, found, tick)
        if other is not None:
            problem, found, extend, upstream = other.problem, other.found, other.extend, other.upstream
        result = describe(problem, found, gone, warnings, domain=domain)
        result.preparation = files.preparation
        if other is not None:
            other.tell(result)
        if apart:
            result.held_out = errors_apart(set_apart(problem, apart), found)
        if upstream is not None:
            tick("the documents behind the model")
            traced = upstream(found, result)
            found = replace(found, verdict=result.verdict)
        say(job.console, problem, found, result)
        if out.wants_files:
            tick("the extended model")
            _model(job, out, given, extend(found), result, caution(found))
            _files(job, out, problem, found, axis or next(iter(problem.states)))
    result.summary += traced
    job.console.note(*traced)
    return write(job, out, given, found, result)


def write(job: Job, out: Output, given: Given, found: Finding, result: LoopDocument) -> int:
    """Write all; return the exit status."""
    # Constants of a fabric's law are free where no prior is asked for.
    job.write(out, result, given.case, prior=None if result.domain == "fabric" else given.surely)
    return NEGATIVE_VERDICT if found.verdict == "unexplained" else 0


def ticking(advance: Callable[[float, str], None], begun: float, refits: float = 40.0) -> Callable[[str], None]:
    """Return what moves the progress line on with every refit, from the share ``begun``: of about ``refits`` in all."""
    count = 0

    def tick(text: str) -> None:
        nonlocal count
        count += 1
        advance(begun + (1.0 - begun) * (1.0 - float(np.exp(-count / refits))), text)

    return tick


def errors_apart(apart: Apart, found: Finding, tests: int | None = None) -> Errors:
    """Return the error on readings that were set apart, before and after, beside the noise of the others of their kind,
    the first."""
    before, after = (apart.predicted(state.fit) for state in (found.before, found.after))
    start = apart.rows.start
    sd = float(np.sqrt(np.mean(found.noise.sd[:start][apart.problem.channel[:start] == 0] ** 2)))
    # The specimens set apart scatter as the others do.
    spread = np.hypot(sd, found.noise.gain_sd * np.sqrt(np.maximum(after * apart.measured, 0.0)))
    return errors_of(apart.measured, before, after, spread, apart.problem.units[0], tests, OF_FILES)


def close_rounds(
    problem: P,
    noise: Callable[[P, Array | None], Noise],
    rounds: Callable[[P, Finding], P | None] = lambda problem, found: None,
    tick: Callable[[str], None] = lambda text: None,
    misses: Callable[[P], Callable[[Fit], float]] = lambda problem: none_apart,
    design: bool = True,
) -> tuple[P, Finding]:
    """Close the loop, and again on the problem posed anew around what was found, until that no longer changes it.

    Each time once more where what the model leaves between neighbours shows the noise to be less: where a field is
    steep, neighbours differ by more than the noise until the model tells why. That may be one with an entry that is
    small beside the noise as it was taken, and takes much of that.
    """

    def anew(posed: P) -> Finding:
        closed = partial(close, posed, tick=tick, design=design, apart=misses(posed))
        level = noise(posed, None)
        found = closed(noise=level)
        less = noise(posed, found.after.fit.predicted)
        quiet = closed(noise=less) if np.any(less.sd < _LESS * level.sd) else found
        named = quiet
        for _ in range(_POINTED):
            if named.verdict != "noise" or max(named.scores.values(), default=0.0) < TOLD:
                break
            pointed = _pointed(posed, named, noise)
            if pointed is None:
                break
            # In less noise the entry may take a richer form, which leaves less again.
            named = closed(noise=pointed)
        return named if named.after.ids else quiet

    found = anew(problem)
    for _ in range(2):
        again = rounds(problem, found)
        if again is None:
            break
        problem, found = again, anew(again)
    return problem, found


def _pointed(problem: P, found: Finding, noise: Callable[[P, Array | None], Noise]) -> Noise | None:
    """Return the noise that a model with one entry more leaves between neighbours, where that makes what was read much
    likelier; None where none does.

    Where the noise goes with what is predicted, its size is a part of the likelihood.
    """

    def unlikely(fitted: Fit, sd: Array) -> float:
        left = (problem.measured - fitted.predicted) / sd
        return float(left @ left) + 2.0 * float(np.sum(np.log(sd))) + len(fitted.x) * np.log(len(left))

    best, least = None, unlikely(found.after.fit, found.noise.sd) - MARGIN
    for state, _ in Search(problem, found.noise).candidates(found.after):
        less = noise(problem, state.fit.predicted)
        if np.any(less.sd < _LESS * found.noise.sd) and unlikely(state.fit, less.sd) < least:
            best, least = less, unlikely(state.fit, less.sd)
    return best


def _model(job: Job, out: Output, loop: Given, extension: Extension, result: LoopDocument, care: str) -> None:
    """Run the model's own command with the found terms, and queue what it writes as the extended model.

    ``care`` stands at the head of a document that people read, where something stays unexplained.
    """
    target = str(out.path(".model.json"))

    def laid(suffix: str, data: bytes | Document) -> bytes:
        if isinstance(data, Document):
            return signed(job, loop, data, target)
        return noted(care, data) if suffix.endswith(".toml") else data

    files = {suffix: laid(suffix, data) for suffix, data in extension.files.items()}
    given = {str(out.path(suffix)): data for suffix, data in files.items()}
    notes = list(extension.notes)
    for suffix, data in files.items():
        out.add(suffix, data)
    try:
        made = rerun(extension.case, target, given)
    except HyperfabError as error:
        notes.append(f"hf {extension.case.COMMAND} does not run with what was found: {error}")
        result.warnings += notes
        job.console.warn(*notes)
        return
    document = dict(made.document)
    tail: dict[str, Any] = {key: document.pop(key) for key in ("files", "provenance") if key in document}
    document["effects"] = [
        {"id": one.id, "form": one.form, "parameters": one.parameters} | ({"tentative": True} if one.tentative else {})
        for one in result.effects
    ]
    document["constants"] = result.constants.get("with_effects", {})
    document |= tail
    out.add(".model.json", dump_json(document))
    for suffix, data in made.siblings.items():
        out.add(f".model{suffix}", data)
    result.model = out.path(".model.json").name
    result.model_command = command_line(extension.case, target, given, "-o", result.model)
    job.console.warn(*notes)
    result.warnings += [*notes, *(text for text in made.warnings if text not in result.warnings)]


def _files(job: Job, out: Output, problem: Problem, found: Finding, axis: str) -> None:
    figures = np.column_stack([problem.measured, found.before.fit.predicted, found.after.fit.predicted, found.noise.sd])
    quantities = [curve for curve in problem.curves if curve.channel < len(problem.units)]
    units = list(dict.fromkeys(problem.units[curve.channel] for curve in quantities))
    head = [axis.replace(" ", "_")]
    head += [column(name, one) for one in units for name in ("measured", "before", "after", "noise_sd")]
    where = [name for name in (*PLACES, "axis") if name in problem.states and name not in head]
    at = np.full((len(problem.measured), 1 + len(where)), np.nan)
    at[problem.channel == 0] = np.column_stack([problem.states[name] for name in (axis, *where)])
    rows = []
    for curve in quantities:
        # Readings of each unit have columns of their own.
        told = np.full((len(curve.places), len(units), 4), np.nan)
        told[:, units.index(problem.units[curve.channel])] = figures[curve.rows]
        file, places = job.named(curve.name), at[curve.rows]
        rows += [(there[0], *one.ravel(), *there[1:], file) for there, one in zip(places, told, strict=True)]
    out.add(".csv", csv_bytes([*head, *where, "file"], rows, digits=8))
    out.add(".png", picture(problem, found, axis, problem.units[0]))


def picture(
    problem: Problem,
    found: Finding,
    axis: str,
    unit: str,
    value_words: Mapping[str, Sequence[str]] | None = None,
    widths: Sequence[Curve] = (),
) -> bytes:
    """Return the picture of what was found, over the state ``axis``, of the readings of the first channel, and beside
    it of transverse stretches, curve by curve (``widths``)."""
    from hyperfab.report.figures_loop import LoopPicture

    what, _, measure = axis.partition("_")
    first = problem.channel == 0
    # The states first that what the model missed rides on.
    riding = dependence(found.before.fit.residual[first], problem.states)
    before, after = found.before.fit.predicted, found.after.fit.predicted
    states = sorted(problem.states.items(), key=lambda item: -riding.get(item[0], 0.0))
    return LoopPicture(
        abscissa=problem.states[axis],
        label=f"{what} [{measure}]" if measure else what,
        unit=unit,
        curves=[curve.rows for curve in problem.curves if curve.channel == 0],
        measured=problem.measured[first],
        before=before[first],
        after=after[first],
        sd=found.noise.sd[first],
        states=dict(states),
        scores=lowered(found) or found.scores,
        scores_label="BIC lowered by" if found.tried else "score",
        verdict=found.verdict,
        added=found.after.ids,
        value_words=value_words or {},
        delivered=problem.delivered[first],
        widths=[(one.places, problem.measured[one.rows], before[one.rows], after[one.rows]) for one in widths],
    ).png()
