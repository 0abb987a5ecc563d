"""A finding in numbers and in words."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from hyperfab.arrays import Array, Ints
from hyperfab.chapters.close_loop.left_out import parts_of
from hyperfab.chapters.close_loop.sure import errors_of_constants
from hyperfab.chapters.close_loop.words import doubts, strength, summary
from hyperfab.chapters.job import Job
from hyperfab.console import Console
from hyperfab.documents.loop import (
    AddedEffect,
    Candidate,
    Errors,
    Evidence,
    Judged,
    LoopDocument,
    Misfit,
    NextMeasurement,
    NoiseFigures,
    Residual,
)
from hyperfab.io.csv_write import csv_bytes
from hyperfab.loop.engine import Finding
from hyperfab.loop.fabric import FabricProblem
from hyperfab.loop.judge import Judgement
from hyperfab.loop.problem import Problem


def describe(
    problem: Problem,
    found: Finding,
    left_out: Mapping[str, int],
    warnings: Sequence[str],
    domain: str = "fabric",
) -> LoopDocument:
    """Return the finding as a document."""
    before, after = found.before.fit, found.after.fit
    return LoopDocument(
        domain=domain,
        verdict=found.verdict,
        effects=_added(problem, found),
        constants={
            "given": problem.as_stated(problem.given),
            "refitted": problem.as_stated(before.x[: before.own]),
            "with_effects": problem.as_stated(after.x[: after.own]),
        },
        noise=NoiseFigures(
            sd=_rms(found.noise.sd[problem.channel == 0]),
            unit=problem.units[0],
            source=found.noise.source,
            degrees_of_freedom=found.noise.dof if math.isfinite(found.noise.dof) else None,
            specimen_scatter=found.noise.gain_sd or None,
            contraction_scatter=found.noise.across_sd or None,
            correlation=float(np.max(np.where(problem.channel == 0, found.noise.correlation, 0.0))) or None,
            switching=_rms(found.noise.common_sd) or None,
            assumed_scatter=found.assumed or None,
        ),
        error=_error(problem, found, 0),
        contraction=_error(problem, found, 1)
        if isinstance(problem, FabricProblem) and len(problem.transverse_rows)
        else None,
        held_out=_held_out(problem, found, domain),
        residual=Residual(
            **_judged(found.after.judgement),
            before=Judged(**_judged(found.before.judgement)),
            rides_on=found.rides_on,
            suggestion=found.suggestion[0] if found.suggestion else None,
            suggestion_share=found.suggestion[1] if found.suggestion else None,
        ),
        candidates=_candidates(problem, found),
        something_else=found.belief.something_else if found.belief else None,
        indistinguishable=found.indistinguishable,
        next_measurement=_next(found),
        left_out=dict(left_out),
        warnings=list(warnings),
    )


def errors_of(
    measured: Array,
    before: Array,
    after: Array,
    sd: Array,
    unit: str,
    tests: int | None = None,
    source: str | None = None,
    whitened: tuple[Array, Array] | None = None,
    spread: Array | None = None,
    curves: Sequence[Ints] = (),
    delivered: Array | None = None,
) -> Errors:
    """Return the residual's size before and after, beside that of the noise.

    ``spread`` is the noise with what the readings of a specimen have in common, where that is more than ``sd``;
    ``curves`` are the rows of each test, where more than one is compared; ``delivered`` is what the model predicts as
    it was given, absent where that is not finite.
    """
    old, new = whitened if whitened is not None else ((measured - before) / sd, (measured - after) / sd)

    def misfit(raw: Array, chi2: float) -> Misfit:
        size, top = _rms(measured) or 1.0, float(np.max(np.abs(measured), initial=0.0)) or 1.0
        each = [_rms(raw[rows]) / (float(np.max(np.abs(measured[rows]))) or 1.0) for rows in curves]
        return Misfit(
            rms=_rms(raw),
            relative_rms=_rms(raw) / size,
            nrmse=_rms(raw) / top,
            nrmse_of_tests=float(np.mean(each)) if len(each) > 1 else None,
            chi2_reduced=chi2,
        )

    return Errors(
        unit=unit,
        before=misfit(measured - before, float(np.mean(old**2))),
        after=misfit(measured - after, float(np.mean(new**2))),
        noise=misfit(sd if spread is None else spread, 1.0),
        delivered=None
        if delivered is None or not np.all(np.isfinite(delivered))
        else misfit(measured - delivered, float(np.mean(((measured - delivered) / sd) ** 2))),
        tests=tests,
        source=source,
    )


def _error(problem: Problem, found: Finding, channel: int) -> Errors:
    """Return the errors in the readings of a channel; a transverse stretch counts by how much it is narrower."""
    rows, rest = problem.channel == channel, float(channel)
    place = np.cumsum(rows) - 1  # of a row among those of the channel
    before, after = found.before.fit, found.after.fit
    return errors_of(
        problem.measured[rows] - rest,
        before.predicted[rows] - rest,
        after.predicted[rows] - rest,
        found.noise.sd[rows],
        problem.units[channel],
        spread=found.noise.spread(after.predicted)[rows],
        whitened=(before.residual[rows], after.residual[rows]),
        curves=[place[curve.rows] for curve in problem.curves if curve.channel == channel],
        delivered=(problem.delivered + found.noise.owed(problem.measured - problem.delivered))[rows] - rest,
    )


def _judged(judgement: Judgement) -> dict[str, Any]:
    return {name: getattr(judgement, name) for name in Judged.model_fields}


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2))) if len(values) else 0.0


def _held_out(problem: Problem, found: Finding, domain: str) -> Errors | None:
    """Return the plain errors of each test predicted by a fit to the others, over those that both models can tell."""
    first = problem.channel == 0
    old, new = found.before.forecast, found.after.forecast
    known = first & np.isfinite(old.predicted) & np.isfinite(new.predicted)
    if not np.any(known):
        return None
    spread = found.noise.spread(found.after.fit.predicted)[known]
    return errors_of(
        problem.measured[known],
        old.predicted[known],
        new.predicted[known],
        spread,
        problem.units[0],
        len(set(old.tests) & set(new.tests)),
        f"each {parts_of(domain, many=False)} predicted from all others",
    )


def _added(problem: Problem, found: Finding) -> list[AddedEffect]:
    fit = found.after.fit
    if not fit.forms:
        return []
    deviations = np.sqrt(np.maximum(np.diag(sum(errors_of_constants(found))), 0.0))
    return [
        AddedEffect(
            id=name,
            title=problem.effect(name).title,
            form=form.name,
            source=problem.effect(name).source,
            parameters=form.named(fit.x[fit.place(name)]),
            parameters_sd=form.named(deviations[fit.place(name)]),
            evidence=evidence_of(found, name),
            tentative=found.verdict == "unexplained",
        )
        for name, form in fit.forms.items()
    ]


def evidence_of(found: Finding, name: str) -> Evidence:
    """Return the evidence of an added effect."""
    gained = found.added[name]
    return Evidence(
        delta_bic=gained.delta_bic,
        variance_share=gained.variance_share,
        held_out_share=None if gained.help is None else gained.help.taken,
        tests_helped=None if gained.help is None else gained.help.helped,
    )


def _candidates(problem: Problem, found: Finding) -> list[Candidate]:
    rows, gains = [], lowered(found)
    for effect in problem.effects:
        alike = {name for one in found.indistinguishable if effect.id in one for name in one}
        gain = gains.get(effect.id, float(found.worth.get(effect.id, 0.0)))
        rows.append(
            Candidate(
                id=effect.id,
                title=effect.title,
                visible=effect.id in found.scores or effect.id in gains,
                not_sought=effect.not_sought or None,
                score=float(found.scores.get(effect.id, 0.0)),
                delta_bic=gain,
                strength=strength(gain),
                refitted=effect.id in gains,
                probability=found.belief.of.get(effect.id) if found.belief else None,
                confounded_with=sorted(alike - {effect.id}),
                shown_by=effect.shown_by,
            )
        )
    return sorted(rows, key=lambda row: (not row.visible, -row.delta_bic, -row.score))


def _next(found: Finding) -> NextMeasurement | None:
    if not found.measurements:
        return None
    best = found.measurements[0]
    return NextMeasurement(
        text=best.text,
        details=dict(best.details),
        misfit=best.misfit,
        decisive=best.decisive,
        instead=[other.text for other in found.measurements[1:3]],
    )


def lowered(found: Finding) -> dict[str, float]:
    """Return what each effect that was tried lowers BIC by: beside the other added ones, or else alone."""
    return {name: float(one.delta_bic) for name, one in (found.tried | found.added).items()}


def say(console: Console, problem: Problem, found: Finding, document: LoopDocument) -> None:
    """Put the finding into words, in the document and to the person."""
    told = doubts(problem, found, document)
    document.warnings += told
    document.summary = summary(problem, found, document)
    console.warn(*told)
    console.note(f"verdict: {document.verdict}")
    console.note(*document.summary)
    rows = [
        [row.id, row.strength, f"{row.delta_bic:.0f}" if row.refitted else f"~{row.delta_bic:.0f}",
         ", ".join(row.confounded_with)]
        for row in document.candidates
        if row.visible
    ]  # fmt: skip
    console.table("What the model might lack", ["effect", "evidence", "BIC lowered by", "not told from"], rows)


def column(name: str, unit: str) -> str:
    """Return a column's header, its unit at its end.

    >>> column("measured", "N/mm"), column("from the middle", "mm"), column("stretch", "-")
    ('measured_N_mm', 'from_the_middle_mm', 'stretch')
    """
    words = [*name.split(), *(unit.split("/") if unit.strip("-") else [])]
    return "_".join(words)


def curves_csv(job: Job, problem: FabricProblem, found: Finding) -> bytes:
    """Return measured and predicted stresses, row by row, and beside them the transverse stretch where it was read."""
    unit = problem.units[0]
    quantity = "membrane stress" if unit == "N/mm" else "stress"
    head = ["test", "stretch", *(column(name, unit) for name in (quantity, "before", "after", "noise sd"))]
    stretch = problem.fabric.path.stretch
    figures = np.column_stack([problem.measured, found.before.fit.predicted, found.after.fit.predicted, found.noise.sd])
    count, across = len(stretch), problem.transverse_rows
    table = np.column_stack([stretch, figures[:count]])
    if len(across):
        head += [f"transverse_{name}" for name in ("stretch", "before", "after", "noise_sd")]
        beside = np.full((count, 4), np.nan)
        beside[across] = figures[problem.channel == 1]
        table = np.column_stack([table, beside])
    rows = [
        (job.named(curve.name), *table[i])
        for curve in problem.curves
        if curve.channel == 0
        for i in range(curve.start, curve.stop)
    ]
    return csv_bytes(head, rows, digits=8)
