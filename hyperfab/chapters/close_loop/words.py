"""A finding in sentences an engineer can act on."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from hyperfab.arrays import Array, Ints
from hyperfab.chapters.close_loop.left_out import missed_by_more, not_added, refused, silent, size_of, told_of
from hyperfab.chapters.close_loop.origins import another_frame, another_zero, late_force, off_the_sheet, untared
from hyperfab.chapters.close_loop.sure import caution
from hyperfab.documents.loop import AddedEffect, Errors, LoopDocument, NoiseFigures
from hyperfab.loop.belief import allowed
from hyperfab.loop.catalogue.heat import CLOCK, CLOCK_SHOWN_BY
from hyperfab.loop.dependence import period
from hyperfab.loop.engine import Finding
from hyperfab.loop.problem import HAS_IT, Problem
from hyperfab.loop.thresholds import TOLD

#: Differences of BIC from which evidence is called so: Kass & Raftery (1995), doi:10.1080/01621459.1995.10476572.
_STRENGTHS = ((10.0, "decisive"), (6.0, "strong"), (2.0, "weak"))

#: Readings so many times what the model says, or so many times less, are asked about: newtons in a kilogram-force, less
#: some; where the model has less than this share of its largest value they are not. Of the readings themselves, from
#: this share of their largest on, all but a tenth have to be as far off: a law beyond its tests misses there alone.
_ANOTHER_UNIT, _LITTLE, _NEAREST = 8.0, 0.1, 0.1
#: States that say where a reading was taken; they stand beside it in the table.
PLACES = ("x0_mm", "y0_mm", "x_mm", "y_mm", "z_mm")
#: Times as far, or as little, as the others that a probe moves beside the model before it is at fault: degF makes 1.8.
_OTHER_PROBE = 1.5
#: What shows that a constant of the model is far from what its document says.
_OWN = "gauge it by itself: it would be further off than what is known of it"
#: An entry is told beside what was found from this probability on.
_MIGHT = 0.1
#: An error that falls by less than this share does not show what was added.
_HIDDEN = 0.1
_END = ", the farthest it may go"


def strength(lowered: float) -> str:
    """Return in a word how much a difference of BIC says.

    >>> strength(300.0), strength(7.0), strength(3.0), strength(-5.0)
    ('decisive', 'strong', 'weak', 'none')
    """
    return next((word for least, word in _STRENGTHS if lowered >= least), "none")


def summary(problem: Problem, found: Finding, document: LoopDocument) -> list[str]:
    """Return what came out: how far off, what lacks, how sure, what is left, what to measure next."""
    lines = [_how_far(problem, found, document), *_far_from_known(problem, found, document)]
    if document.verdict == "noise":
        lines.append(_noise(found, document))
    lines += [_effect(problem, effect) for effect in document.effects]
    if document.effects:
        lines.append(f"With that it misses by {size_of(document.error.after, document.error.unit)}.")
        lines += _beside_scatter(problem, found, document)
    if document.contraction is not None:
        lines.append(_contraction(document.contraction))
    if document.held_out is not None:
        lines.append(told_of(document.held_out, document.domain))
    if document.verdict == "effect":
        lines.append(f"{_left(found, document)}, and {_no_other(found)}.")
    if document.verdict == "ambiguous":
        lines.append(f"{_left(found, document)}.")
    if document.indistinguishable:
        sets = "; ".join(" or ".join(one) for one in document.indistinguishable)
        lines.append(f"These data cannot tell apart: {sets}.")
    if document.verdict == "unexplained":
        lines += _unexplained(problem, found, document)
    for look in (another_frame, off_the_sheet, another_zero, untared, late_force):
        lines += look(problem, found)
    if document.indistinguishable:
        by = {row.id: row.shown_by for row in document.candidates} | {CLOCK: CLOCK_SHOWN_BY}
        told = "; ".join(f"{name}: {by.get(name, _OWN)}" for name in document.indistinguishable[0])
        lines.append(f"What shows each of them: {told}.")
    if document.next_measurement is not None:
        sure = "" if document.next_measurement.decisive else " (it may not settle the matter at this noise)"
        # Looking at the cause itself settles it at less cost than one more test, whose answer has to be inferred.
        lead = "Or measure next" if document.indistinguishable else "Measure next"
        lines.append(f"{lead}: {document.next_measurement.text}{sure}.")
    hidden: dict[str, list[str]] = {}
    for row in document.candidates:
        if not row.visible and row.not_sought != HAS_IT:
            hidden.setdefault(row.not_sought or "", []).append(row.id)
    if hidden:
        parts = (", ".join(names) + (f" ({reason})" if reason else "") for reason, names in hidden.items())
        lines.append(f"These data cannot show: {'; '.join(parts)}.")
    return [*lines, *_doubts(found)]


def _effect(problem: Problem, effect: AddedEffect) -> str:
    """Return what lacks: its law with its constants, and whether these are all there is."""
    values = ", ".join(f"{key} {value:.4g}" for key, value in effect.parameters.items())
    values += ", added to what the model has" * (bool(values) and problem.effect(effect.id).added)
    form = f"{effect.form}: {values}" if values else effect.form
    return f"{effect.id}: {effect.title} ({form}); the evidence is {strength(effect.evidence.delta_bic)}."


def doubts(problem: Problem, found: Finding, document: LoopDocument) -> list[str]:
    """Return what is to be warned of: a guess for the noise, constants at their bounds, predictions that got worse."""
    told = []
    if found.noise.source.startswith("assumed"):
        told.append(
            f"the noise is {found.noise.source}: the verdict rests on it; state it with --noise, or read more rows"
        )
    if found.worse:
        told.append(not_added(found.worse, document.domain))
    told += [text for text in (caution(found),) if text]
    told += [f"{one}: the data ask for more than it may be" for one in _at_bounds(found)]
    fit = found.after.fit
    asked = problem.forbidden(fit.x[: fit.own], fit.terms)
    told += [
        f"{what} is held at what nature allows: these data ask for more than that"
        for what, off in asked.items()
        if off > 0.0
    ]
    told += another_unit(problem)
    if document.verdict == "unexplained":
        told += strange_probes(problem)
    held = document.held_out
    if held is not None and held.after.rms > held.before.rms:
        told.append(missed_by_more(held, document.domain))
    return told


def another_unit(problem: Problem) -> list[str]:
    """Return which kinds of reading are so many times what the model says that their unit is the nearest reason."""
    told, given = [], problem.delivered
    for channel, unit in enumerate(problem.units):
        rows = problem.channel == channel
        # Where the model has next to nothing a ratio says nothing of units.
        size, read = np.abs(np.where(np.isfinite(given), given, 0.0)), np.abs(problem.measured)
        large = rows & (size > 0.0) & (read > _LITTLE * np.max(read[rows], initial=0.0))
        rows &= size > _LITTLE * np.max(size[rows], initial=0.0)
        ratio = float(np.median(read[rows] / size[rows])) if rows.any() else 1.0
        off = np.abs(np.log(read[large] / size[large]))
        alike = large.any() and np.quantile(off, _NEAREST) >= np.log(_ANOTHER_UNIT)
        if ratio > 0.0 and alike and max(ratio, 1.0 / ratio) >= _ANOTHER_UNIT:
            told.append(
                f"readings in {unit} are {ratio:.3g} times what the model says as delivered: check the units in the "
                "heads of the columns, and those of the model"
            )
    return told


def strange_probes(problem: Problem) -> list[str]:
    """Return which thermocouples move so much more or less beside the model than the others that they are at fault.

    Of three or more: of two nobody knows which. Where the model has next to nothing a ratio is one of noise.
    """
    if "probe" not in problem.states or len(problem.curves) < 3:
        return []
    given = problem.delivered
    moved = np.array([[np.ptp(row[curve.rows]) for curve in problem.curves] for row in (problem.measured, given)])
    beside = moved[0] / np.maximum(moved[1], 1e-12)
    beside /= max(float(np.median(beside)), 1e-12)
    return [
        f"{curve.name} moves by {far:.3g} K, where the model as delivered does by {said:.3g} K, unlike the others: "
        "check its wiring, its unit and its place, or leave its column out"
        for curve, far, said, ratio in zip(problem.curves, *moved, beside, strict=True)
        if said > _LITTLE * np.max(moved[1]) and not 1.0 / _OTHER_PROBE < ratio < _OTHER_PROBE
    ]


def _how_far(problem: Problem, found: Finding, document: LoopDocument) -> str:
    error = document.error
    unit = error.unit
    noise = f"the noise of the data is {error.noise.rms:.3g} {unit}{_shares(document.noise)}"
    if document.noise.correlation:
        noise += f", neighbouring readings alike by {document.noise.correlation:.2g}"
    if "at least" in document.noise.source:
        noise += f" ({document.noise.source})"
    if document.noise.switching is not None:
        size = f"{document.noise.switching:.2g} {unit}"
        noise += f"; when the heaters switched between two readings ({size} here) is taken from the probes"
    noise += silent(problem, found)
    answers = np.isfinite(problem.delivered[problem.channel == 0])
    given = ""
    if error.delivered is not None:
        given = f"As delivered the model misses by {size_of(error.delivered, unit)}. "
    elif lost := np.count_nonzero(~answers):
        given = f"As delivered the model has no answer at {lost} of {len(answers)} readings. "
    return f"{given}With its own constants refitted the model misses by {size_of(error.before, unit)} (rms), {noise}."


def _far_from_known(problem: Problem, found: Finding, document: LoopDocument) -> list[str]:
    """Return which of the model's own constants the data move far from what is known of them, or which they moved most
    where that was all that the model as delivered lacked.

    A heater that gives half its power is refitted as well as one that gives all of it: the fit is good, the document
    is not.
    """
    fit, given = found.after.fit, document.error.delivered
    moved = []
    for one, value in zip(problem.expected, fit.x, strict=False):
        if np.isfinite(one.prior_sd):
            away = abs(value - one.value) / one.prior_sd
            far = f"{away:.2g} standard deviations{_END * one.ends(value)}"
            moved.append((away, f"{one.name} from {one.value:.4g} to {value:.4g} ({far})"))
    if told := [text for away, text in moved if away > TOLD]:
        return [
            f"The fit moves constants far from what is known of them: {', '.join(told)}. Check them, and what the "
            "document says."
        ]
    most = max((away for away, _ in moved), default=0.0)
    if given is None or found.verdict != "noise" or given.rms <= TOLD * document.error.before.rms:
        return []
    told = [text for away, text in moved if 0.0 < 0.5 * most <= away]
    return [f"That takes {', '.join(told)}, no farther than they may be."] if told else []


def _shares(noise: NoiseFigures) -> str:
    scatters = ((noise.specimen_scatter, "stiffness"), (noise.contraction_scatter, "contraction"))
    shares = [f"{100.0 * one:.2g} % in {of}" for one, of in scatters if one is not None]
    if not shares:
        return ""
    taken = ", as those of one cloth scatter" if noise.assumed_scatter else ""
    return f" ({noise.sd:.2g} within a specimen, {' and '.join(shares)} between specimens{taken})"


def _beside_scatter(problem: Problem, found: Finding, document: LoopDocument) -> Iterator[str]:
    """Yield what is missed beside how specimens differ in stiffness, where that hides what the effects explain."""
    error = document.error
    if found.noise.gain_sd == 0.0 or error.after.rms < (1.0 - _HIDDEN) * error.before.rms:
        return
    before, after = (
        _rms_beside_stiffness(problem.measured, one.fit.predicted, found.noise.groups)
        for one in (found.before, found.after)
    )
    if after < (1.0 - _HIDDEN) * before:
        yield (
            f"Most of that is how specimens differ: each taken to be as stiff as it is by itself, the model misses by "
            f"{before:.3g} {error.unit} without, by {after:.3g} {error.unit} with what was added."
        )


def _rms_beside_stiffness(measured: Array, predicted: Array, specimens: Sequence[Ints]) -> float:
    """Return the rms of what is left of stresses once those of each specimen are scaled to its readings."""
    left = []
    for rows in specimens:
        model, own = predicted[rows], measured[rows]
        # Of a specimen that is slack to the model throughout nothing is scaled.
        left.append(own - model * (own @ model) / max(float(model @ model), 1e-300))
    return float(np.sqrt(np.mean(np.concatenate(left) ** 2)))


def _least(document: LoopDocument) -> tuple[str, float]:
    """Return the test of noise that says no most clearly, and its probability."""
    left = document.residual
    tests = {
        "lack of fit": left.p_lack_of_fit,
        "neighbouring readings miss alike": left.p_autocorrelation,
        "it points at an entry": left.p_greatest_score,
    }
    what = min(tests, key=lambda name: tests[name])
    return what, tests[what]


def _no_other(found: Finding) -> str:
    """Return that nothing else could stand for what was found, and what might that takes more to say it."""
    added, models = frozenset(found.after.ids), found.belief.models if found.belief else {}
    instead: dict[str, float] = {}
    for ids, probability in models.items():
        for name in ids - added if added - ids else ():
            instead[name] = instead.get(name, 0.0) + probability
    likely = [f"{name} ({chance:.2g})" for name, chance in sorted(instead.items()) if chance >= _MIGHT]
    if not likely:
        return "no other entry of the catalogue could stand in its place"
    return (
        "no other entry of the catalogue could stand in its place with as few constants, though with more of them "
        f"{', '.join(likely)} might (probability)"
    )


def _left(found: Finding, document: LoopDocument) -> str:
    if document.residual.is_noise:
        return "What is left is noise"
    what, chance = _least(document)
    beyond = document.residual.structured
    size = " is no larger than the noise"
    if beyond:
        is_large = beyond > allowed(found.before.judgement.structured)
        beside = "no more than a testing machine may be off" if is_large else "small beside it"
        size = f", {beyond:.2g} of a standard deviation of the noise, is {beside}"
    return f"What is left{size}, though not noise to the tests ({what}: p = {chance:.1g})"


def _noise(found: Finding, document: LoopDocument) -> str:
    if found.assumed and not document.residual.is_noise:
        return (
            f"What is left is a stiffness of each specimen, {100.0 * found.assumed:.2g} % (rms), as specimens of one "
            "cloth scatter: these data show nothing else that the model lacks. Test replicates to be sure."
        )
    if document.residual.is_noise:
        return "What is left is noise: these data show nothing that the model lacks."
    return f"{_left(found, document)}: too little to name anything for."


def _contraction(error: Errors) -> str:
    before, after = (f"{100.0 * one.relative_rms:.2g} %" for one in (error.before, error.after))
    if error.before.rms == error.after.rms:
        return f"How much narrower specimens become it misses by {before}."
    return f"How much narrower specimens become it misses by {before} without, by {after} with what was added."


def _unexplained(problem: Problem, found: Finding, document: LoopDocument) -> list[str]:
    strained = problem.strained(found.after.fit.x[: found.after.fit.own])
    if strained and found.after.judgement.is_small:
        return [
            f"That takes {' and '.join(strained)} to the end of what is known: something else is lacking that no entry "
            "of the catalogue explains, and what was added may stand for it."
        ]
    shares: Mapping[str, float] = document.residual.rides_on
    riding = [f"{key} ({share:.0%})" for key, share in shares.items() if share > 0.02][:3]
    what, chance = _least(document)
    more = "Something more" if found.added else "Something"
    lines = [
        f"{more} is lacking that no entry of the catalogue explains "
        f"({document.residual.structured:.2g} standard deviations of the noise beyond it; {what}: p = {chance:.1g})"
        + (f"; what is left rides on {', '.join(riding)}." if riding else ".")
    ]
    if document.something_else is not None and document.something_else > 0.5 and found.added:
        names = " and ".join(found.added)
        lines.append(f"That something else is lacking is likelier ({document.something_else:.0%}) than {names}.")
    lines += refused(found, document.domain)
    lines.append(_where(problem, found))
    if document.residual.suggestion:
        left, share = document.residual, document.residual.suggestion_share or 0.0
        lines.append(
            f"A hint, not a law: {share:.0%} of what is left [{document.error.unit}] goes as {left.suggestion}"
        )
    return lines


def _where(problem: Problem, found: Finding) -> str:
    """Return which test is missed most, and where in it."""
    square = found.after.fit.residual**2
    curves = [curve for curve in problem.curves if not curve.beforehand]
    worst = max(curves, key=lambda curve: float(np.sum(square[curve.rows])))
    share = float(np.sum(square[worst.rows])) / max(float(np.sum(square)), 1e-300)
    at = int(np.argmax(square[worst.rows]))
    row = worst.start + at
    # Where a place is known it says more than a row: those of a part of a file are not its lines.
    known = [name for name in (*PLACES, "depth_mm") if row < len(problem.states.get(name, ()))]
    spot = ", ".join(f"{name.removesuffix('_mm')} {problem.states[name][row]:.4g} mm" for name in known)
    part = "Most" if share > 0.5 else "The largest part"
    told = f"{part} of it ({share:.0%}) is in {worst.name}, there most "
    told += f"at {spot}" if spot else f"in row {at + 1} of {len(worst.places)}"
    times = np.full(len(square), np.nan)
    if "time_s" in problem.states:
        times[problem.channel == 0] = problem.states["time_s"]
    swing = period(found.after.fit.residual[worst.rows], times[worst.rows])
    return f"{told}." if swing is None else f"{told}; it swings there once in {swing[0]:.3g} s ({swing[1]:.0%} of it)."


def _at_bounds(found: Finding) -> list[str]:
    """Return the constants of added effects that stand at a bound which is not their null."""
    told, fit = [], found.after.fit
    for name, form in fit.forms.items():
        for constant, value in zip(form.constants, fit.x[fit.place(name)], strict=True):
            away = [
                abs(value - one) <= 1e-9 * max(abs(one), constant.scale)
                for one in (constant.low, constant.high)
                if np.isfinite(one)
            ]
            if any(away) and value != constant.value and constant.low < constant.high:
                told.append(f"{constant.name} of {name} is at its bound {float(value):.4g}")
    return told


def _doubts(found: Finding) -> list[str]:
    """Return what the scatter of specimens may hide, and what would show it."""
    share = 100.0 * found.noise.gain_sd
    more = "two or three specimens of each kind of test would tell."
    if found.doubted:
        seen = f"a little more than the {share:.2g} % in stiffness seen here"
        how = seen if share and not found.assumed else "as those of one cloth do"
        return [f"Not added: {', '.join(found.doubted)}. Specimens that scatter {how} would explain as much: {more}"]
    if found.hidden and share:
        names = " or ".join(
            f"{name} ({100.0 * beside:.2g} % beside it, {100.0 * without:.2g} % without)"
            for name, (beside, without) in found.hidden.items()
        )
        return [
            f"Specimens scatter so much in stiffness that {names} may be hidden there. It is not added, for so few do "
            f"as much by chance: {more}"
        ]
    if found.verdict == "noise" and share:
        return [
            f"Tests that differ in stiffness by the {share:.2g} % that specimens scatter by count as noise. Should "
            f"temperature, rate or direction do less than that, {more}"
        ]
    return []
