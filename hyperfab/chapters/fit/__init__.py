"""The recipe of ``hf fit``: read, prepare, identify, judge, write."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

from hyperfab.arrays import Array
from hyperfab.cases.fit import FitCase
from hyperfab.chapters.fit import describe
from hyperfab.chapters.fit.doubts import doubts, outliers, rows_of
from hyperfab.chapters.fit.identify import Identified, Setting, reach, tested
from hyperfab.chapters.fit.judge import Judged, Sets, closer, judge, law_spread
from hyperfab.chapters.fit.prepare import steps_of
from hyperfab.chapters.fit.readings import Readings, contractions, gather, read_all
from hyperfab.chapters.fit.replicates import next_specimens, replicates
from hyperfab.chapters.fit.specimens import aspect_warnings, geometry
from hyperfab.chapters.fit.whole import WholeFit
from hyperfab.chapters.job import Job
from hyperfab.chapters.look import met_degC, stated_noise
from hyperfab.console import NEGATIVE_VERDICT
from hyperfab.curve import TestCurve
from hyperfab.documents.material import FitFigures, MaterialDocument, TestFigures
from hyperfab.errors import InputError, UsageError
from hyperfab.io.layout import layout
from hyperfab.io.output import Output
from hyperfab.io.specimen import Geometry
from hyperfab.io.text import number_of_rows
from hyperfab.materials import law, laws
from hyperfab.materials.hyperfoam import ORDERS
from hyperfab.materials.identification.quality import Figures
from hyperfab.materials.law import Law
from hyperfab.materials.registry import carried_by


def run(job: Job, case: FitCase) -> int:
    """Identify constants and write the material document; 1 where no law is accepted."""
    out = job.opened(".csv", ".png", *((_TABLE,) if case.model in ORDERS else ()))
    model, relative = case.model, case.objective == "relative"
    # What was typed wrong is told before what the files are wrong in.
    if model not in ("all", "orthotropic", *ORDERS):
        law(model)
    named = {"": case.files} | {kind: getattr(case, kind) for kind in ("uniaxial", "shear", "biaxial", "volumetric")}
    sizes, steps = geometry(case), steps_of(case)
    noise = _noise(case.noise, sizes)
    told: list[str] = []
    tests = read_all(job, named, sizes, layout(case.columns, case.skip_rows, case.decimal), told)
    out.refuse_inputs(job.inputs)
    foam = model in ORDERS
    # A foam's rows count by their share of the largest stress: none is without meaning.
    readings = gather(tests, steps, relative and not foam, carried_by(model), not foam, noise)
    whole = foam or model == "orthotropic"
    readings.preparation += contractions(readings.curves, fitted=whole)
    job.console.note(*readings.preparation)
    readings.preparation += told
    readings.warnings[:0] = aspect_warnings(tests)
    chosen = _chosen(case.fit_on, readings)
    if noise is not None:
        # What a reading of a foam counts hangs on its test alone.
        counts = "how sure the constants are" if foam else "the weights"
        readings.preparation.append(f"noise of {noise:g} MPa taken into account in {counts}")
    setting = Setting(chosen, relative and not foam, case.stable, case.accept, noise)
    fitted = _whole if whole else _by_direction
    document, beside = fitted(job, readings, setting, case)
    if not foam:
        _tell_bulk(job, readings)
    if out.wants_files:
        for suffix, data in beside().items():
            out.add(suffix, data)
    job.write(out, document, case, thickness_mm=document.thickness_mm)
    return 0 if document.accepted else NEGATIVE_VERDICT


#: The document, and what makes the tables and the picture beside it, by suffix.
_Fitted = tuple[MaterialDocument, Callable[[], dict[str, bytes]]]
#: Of the table that the press takes where no law has a foam's plateau.
_TABLE = ".compression.csv"
#: A table that was levelled by less only scatters.
_LEVELLED = 0.01


def _by_direction(job: Job, readings: Readings, setting: Setting, case: FitCase) -> _Fitted:
    """Identify laws with constants for each direction."""
    ranked = case.model == "all"
    candidates = [one for one in laws().values() if one.isotropic] if ranked else [law(case.model)]
    sets = _sets(readings)
    judged = _judge_all(job, candidates, sets, setting)
    best = judged[0]
    if best.failure is not None:
        raise InputError(
            f"no constants of {best.law.name}: {best.failure}",
            file=readings.curves[0].source,
            remedy="give more rows or tests, or a law with fewer constants",
        )
    document = _document(best, judged if ranked else None, readings, sets, setting, case.plane)
    _tell(job, judged, document, setting)
    for curve in sets[None]:
        way = curve.direction_name if curve.direction_name in (document.directions or {}) else None
        _note_ranges(job, document, curve, curve.principal, document.tested_stretch(way), way)

    def beside() -> dict[str, bytes]:
        from hyperfab.chapters.fit.siblings import law_csv, law_picture

        return {".csv": law_csv(best, sets, setting), ".png": law_picture(best, sets, setting)}

    return document, beside


def _whole(job: Job, readings: Readings, setting: Setting, case: FitCase) -> _Fitted:
    """Identify one energy for all tests: that of a foam, or of the whole sheet."""
    with job.console.progress("Identifying") as advance:
        advance(0.0, case.model)
        from hyperfab.chapters.fit.hyperfoam import FoamFit, fit_foam

        if case.model in ORDERS:
            fit: WholeFit[Any] = fit_foam(readings, setting, ORDERS[case.model])
        else:
            from hyperfab.chapters.fit.orthotropic import along_axes, fit_sheet

            before = len(readings.preparation)
            sheet = fit_sheet(along_axes(readings), setting)
            readings.preparation += sheet.gripped
            job.console.note(*readings.preparation[before:])
            fit = sheet
    document = fit.document(readings)
    parts = {n: d.fit for n, d in (document.directions or {}).items()} or {"": document.fit}
    named = ["direction"] if case.model not in ORDERS else []
    rows = [
        [
            *([name or "-"] if named else []),
            test,
            f"{one.relative_rms:.4g}",
            f"{one.nrmse:.4g}",
            str(one.points),
        ]
        for name, figures in parts.items()
        for test, one in (figures.tests if figures else {}).items()
        if isinstance(one, TestFigures)
    ]
    _tell_data(job, document, describe.table([*named, "test", "rel. rms", "NRMSE", "rows"], rows))
    if case.model in ORDERS and not any((c.stretch < 1.0).any() for c in fit.curves if c.mode != "simple-shear"):
        job.console.warn(
            "no row presses the foam: all count as pulled, and its law in compression is a guess; where they were "
            'pressed, let --columns or the table say so, as "compressive strain [-]" and "compressive stress [MPa]"'
        )
    for unknown in fit.undetermined:
        job.console.note(
            f"{unknown.constant}: not told by these tests, {unknown.value:g} taken; it takes {unknown.test}"
        )
    for curve, known in fit.ranges(document):
        _note_ranges(job, document, curve, curve.stretch, known, curve.direction_name)

    def beside() -> dict[str, bytes]:
        found = {".csv": fit.curves_csv(), ".png": fit.picture()}
        table = fit.table() if isinstance(fit, FoamFit) else None
        if table is not None:
            found[_TABLE] = table[0]
            _tell_table(job, Output(job.target).path(_TABLE).name, table[1])
        return found

    return document, beside


def _note_ranges(
    job: Job,
    document: MaterialDocument,
    curve: TestCurve,
    stretch: Array,
    known: tuple[float, float] | None,
    way: str | None,
) -> None:
    """Note where the law was used on a test, and at which temperature, beside the tests that it was fitted to."""
    job.ranges.used("stretch", stretch, known=known, source=curve.source, direction=way)
    warmth = met_degC(curve)
    job.ranges.used("temperature_degC", warmth, known=document.tested_degC(way), source=curve.source, direction=way)


def _tell_bulk(job: Job, readings: Readings) -> None:
    """Say the bulk modulus, how well it carries the volumetric tests, and over which changes of volume."""
    bulk = readings.bulk_figures
    if bulk is None:
        return
    job.console.note(
        f"volumetric: bulk modulus {readings.bulk_modulus:.4g} MPa, rel. rms {bulk.relative_rms:.4g}, "
        f"NRMSE {bulk.nrmse:.4g}, {number_of_rows(bulk.points)}"
    )
    for test in readings.volumetric:
        job.ranges.used("volume_ratio", test.stretch, known=test.stretch, source=test.source)


def _tell_table(job: Job, name: str, levelled: float) -> None:
    """Say how the press takes what no law has."""
    why = f", levelled by {100.0 * levelled:.1f} % of its peak where it falls" if levelled > _LEVELLED else ""
    job.console.note(
        f'{name} is the loading as a table{why}. In foam.toml: compression = {{ table = "{name}" }} and thickness = '
        '"10 mm", that of the foam; then: hf press-contact --male m.stl --female f.stl --foam foam.toml --gap 3mm'
    )


def _noise(text: str | None, sizes: Geometry) -> float | None:
    """Return a noise [MPa] stated as a stress, or as force per width (over the thickness, where it is known)."""
    told = stated_noise(text, ("stress", "membrane-stress"))
    if told is None:
        return None
    kind, value = told
    return value if kind == "stress" else value / (sizes.thickness or 1.0)


def _chosen(fit_on: str | None, readings: Readings) -> tuple[str, ...]:
    """Return the tests that take part, as the data name them."""
    if fit_on is None:
        return tuple(readings.modes)
    wanted = [word.strip() for word in fit_on.split(",") if word.strip()]
    found: list[str] = []
    for word in wanted:
        same = [mode for mode in readings.modes if mode.removesuffix("-general") == word.removesuffix("-general")]
        if not same:
            raise UsageError(f"--fit-on {fit_on}: no {word} test is given; there is {', '.join(readings.modes)}")
        found += [mode for mode in same if mode not in found]
    if not found:
        raise UsageError("--fit-on: name at least one test, as uniaxial,shear")
    return tuple(found)


def _sets(readings: Readings) -> Sets:
    """Return all curves, and those of each direction where tests were cut both ways.

    A test without a direction belongs to each.
    """
    names = list(dict.fromkeys(curve.direction_name for curve in readings.curves if curve.direction_name is not None))
    if len(names) < 2:
        return {None: readings.curves}
    return {
        None: readings.curves,
        **{name: [c for c in readings.curves if c.direction_name in (name, None)] for name in names},
    }


def _judge_all(job: Job, candidates: Sequence[Law], sets: Sets, setting: Setting) -> list[Judged]:
    judged = []
    with job.console.progress("Identifying") as advance:
        for number, candidate in enumerate(candidates):
            advance(number / len(candidates), candidate.name)
            judged.append(judge(candidate, sets, setting))
    return sorted(judged, key=lambda one: one.best_first)


def _document(
    best: Judged,
    ranking: Sequence[Judged] | None,
    readings: Readings,
    sets: Sets,
    setting: Setting,
    with_plane: bool,
) -> MaterialDocument:
    whole = best.results[None]
    assert isinstance(whole, Identified)

    def figures(name: str | None, part: Identified) -> FitFigures:
        """With what does not belong, where one more specimen is to be expected, and what the choice of the law adds."""
        found = describe.fit_figures(part, reach(sets[name]))
        found.outliers = outliers(part, rows_of(part, sets, name), setting) or None
        if found.uncertainty is not None:
            if name is not None or len(sets) == 1:
                found.uncertainty.next_specimen = next_specimens(sets[name]) or None
            found.uncertainty.law = None if ranking is None else law_spread(ranking, name)
        return found

    directions = {
        name: describe.direction(part, figures(name, part), reach(sets[name]), with_plane, tested(sets[name], setting))
        for name, part in best.parts
        if name is not None
    }
    data_reach = reach(sets[None])
    warnings = [*readings.warnings, *doubts(best, sets, setting)]
    if ranking is not None and (told := closer(ranking)):
        warnings.append(told)
    return describe.document_of(
        readings,
        setting,
        model=best.law.name,
        parameters=whole.material.parameters,
        temperature_degC=whole.temperatures[whole.reference],
        directions=directions or None,
        temperatures=describe.temperatures(whole),
        fit=figures(None, whole),
        stability=describe.stability(whole, data_reach),
        stability_plane=describe.plane(whole, data_reach, with_plane),
        stable=best.stable,
        accepted=best.accepted,
        carry_over=best.carry_over if math.isfinite(best.carry_over) else None,
        replicates=replicates(readings.curves) or None,
        warnings=warnings or None,
        models=None if ranking is None else [describe.model_row(one, data_reach) for one in ranking],
        tested=tested(sets[None], setting),
    )


def _tell_data(job: Job, document: MaterialDocument, figures: str) -> None:
    """Say what is wrong with the data, what of them was left out, and how well they are met."""
    job.console.warn(*(document.warnings or ()))
    for reason, count in (document.left_out or {}).items():
        job.console.note(f"{number_of_rows(count)} left out: {reason}")
    job.console.note(figures)


def _tell(job: Job, judged: Sequence[Judged], document: MaterialDocument, setting: Setting) -> None:
    columns = ["model", "E2", "rel. rms", "NRMSE", "unseen", "stable", "accepted"]
    if not setting.relative:
        columns[-1] += " by NRMSE"
    rows = []
    for one in judged:
        cells = describe.figures_cells(_written(one))
        unseen = f"{one.carry_over:.4g}" if one.carry_over < 1e300 else "-"
        flags = ["-", "-"] if one.failure else ["yes" if one.stable else "no", "yes" if one.accepted else "no"]
        rows.append([one.law.name, *cells, unseen, *flags])
    _tell_data(job, document, describe.table(columns, rows))
    degrees = sorted({t for part in judged[0].results.values() if isinstance(part, Identified)
                      for t in part.temperatures if t is not None})  # fmt: skip
    if len(degrees) > 1:
        job.console.note(f"constants at {', '.join(f'{t:g}' for t in degrees)} degC; those shown hold at "
                         f"{document.temperature_degC:g} degC")  # fmt: skip
    for name, part in judged[0].parts:
        job.console.note(f"{name + ': ' if name else ''}{describe.parameters_line(part)}")


def _written(one: Judged) -> Figures | None:
    """Return the figures of what is written: of both directions together, where each has constants of its own."""
    parts = [part.total for _, part in one.parts]
    if one.failure is not None:
        return None
    E2, points = sum(part.E2 for part in parts), sum(part.points for part in parts)
    return Figures(E2, math.sqrt(E2 / max(points, 1)), max(part.nrmse for part in parts), points)
