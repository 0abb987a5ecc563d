"""The recipe of ``hf fit``: read, prepare, identify, judge, write."""

from __future__ import annotations

import math
from collections.abc import Sequence

from hyperfab.cases.fit import FitCase
from hyperfab.chapters.fit import describe
from hyperfab.chapters.fit.doubts import doubts, outliers, replicates, rows_of
from hyperfab.chapters.fit.identify import Identified, Setting, reach, tested
from hyperfab.chapters.fit.judge import Judged, Sets, closer, judge, law_spread
from hyperfab.chapters.fit.prepare import steps_of
from hyperfab.chapters.fit.readings import CARRIED, Readings, gather, read_all
from hyperfab.chapters.fit.specimens import aspect_warnings, geometry
from hyperfab.chapters.job import Job
from hyperfab.console import NEGATIVE_VERDICT
from hyperfab.documents.material import FitFigures, MaterialDocument, TestFigures
from hyperfab.errors import InputError, UsageError
from hyperfab.io.layout import layout
from hyperfab.io.output import Output
from hyperfab.io.specimen import Geometry
from hyperfab.io.units import quantity
from hyperfab.materials import law, laws
from hyperfab.materials.hyperfoam import ORDERS
from hyperfab.materials.hyperfoam import TESTS as FOAM_TESTS
from hyperfab.materials.identification.quality import Figures
from hyperfab.materials.law import Law


def run(job: Job, case: FitCase) -> int:
    """Identify constants and write the material document; 1 where no law is accepted."""
    out = job.opened(job.target, (".csv", ".png"))
    model, relative = case.model, case.objective == "relative"
    candidates = [one for one in laws().values() if one.isotropic] if model == "all" else []
    if model not in ("all", "orthotropic", *ORDERS):
        candidates = [law(model)]
    named = {
        "": case.files,
        "uniaxial": case.uniaxial,
        "shear": case.shear,
        "biaxial": case.biaxial,
        "volumetric": case.volumetric,
    }
    sizes, steps = geometry(case), steps_of(case)
    told: list[str] = []
    tests = read_all(job, named, sizes, layout(case.columns, case.skip_rows, case.decimal), told)
    out.refuse_inputs(job.inputs)
    foam = model in ORDERS
    # A foam's rows count by their share of the largest stress: none is without meaning.
    readings = gather(tests, steps, relative and not foam, FOAM_TESTS if foam else CARRIED)
    readings.preparation += told
    readings.warnings[:0] = aspect_warnings(tests)
    chosen = _chosen(case.fit_on, readings)
    floor = _stress(case.noise, "--noise", sizes)
    if floor is not None:
        readings.preparation.append(f"noise of {floor:g} MPa taken into account in the weights")
    setting = Setting(chosen, relative, case.stable, case.accept, floor)
    if foam:
        return _fit_foam(job, out, readings, setting, model)
    if model == "orthotropic":
        return _fit_sheet(job, out, readings, setting, case)
    sets = _sets(readings)
    judged = _judge_all(job, candidates, sets, setting)
    best = judged[0]
    if best.failure is not None:
        raise InputError(
            f"no constants of {best.law.name}: {best.failure}",
            file=readings.curves[0].source,
            remedy="give more rows or tests, or a law with fewer constants",
        )
    document = _document(best, judged if model == "all" else None, readings, sets, setting, case.plane)
    _tell(job, judged, document, setting)
    for curve in sets[None]:
        way = curve.direction if curve.direction in (document.directions or {}) else None
        known = document.tested_stretch(way)
        job.ranges.used("stretch", curve.stretch, known=known, source=curve.source, direction=way)
    if out.wants_files:
        from hyperfab.chapters.fit.siblings import curves_csv, picture

        out.add(".csv", curves_csv(best, sets, setting))
        out.add(".png", picture(best, sets, setting))
    job.write(out, document, case, thickness_mm=document.thickness_mm)
    return 0 if best.accepted else NEGATIVE_VERDICT


def _fit_sheet(job: Job, out: Output, readings: Readings, setting: Setting, case: FitCase) -> int:
    """Identify the orthotropic law of the whole sheet and write it."""
    from hyperfab.chapters.fit.orthotropic import fit_sheet

    with job.console.progress("Identifying") as advance:
        advance(0.0, "orthotropic")
        fit = fit_sheet(readings.curves, setting)
    document = MaterialDocument(
        model="orthotropic",
        parameters=dict(fit.law.parameters),
        thickness_mm=readings.thickness,
        thickness_nominal=readings.nominal or None,
        temperature_degC=fit.temperatures[fit.reference],
        directions={name: fit.direction(name) for name in fit.directions} or None,
        temperatures=fit.at_temperatures,
        fit=fit.figures,
        stability=fit.stability,
        stable=fit.stable,
        accepted=fit.accepted,
        objective="relative" if setting.relative else "absolute",
        fit_on=list(setting.fit_on),
        left_out=dict(sorted(readings.left_out.items())) or None,
        preparation=readings.preparation or None,
        replicates=replicates(readings.curves) or None,
        bulk_modulus_MPa=readings.bulk_modulus,
        undetermined=fit.undetermined or None,
        tested=tested(readings.curves, setting),
        warnings=readings.warnings or None,
        effects=[],
    )
    for text in readings.warnings:
        job.console.warn(text)
    for reason, count in (document.left_out or {}).items():
        job.console.note(f"{count} rows left out: {reason}")
    rows = [
        [name, test, f"{one.relative_rms:.4g}", f"{one.nrmse:.4g}", str(one.points)]
        for name, figures in (
            {n: d.fit for n, d in (document.directions or {}).items()} or {"-": fit.figures}
        ).items()
        for test, one in (figures.tests if figures else {}).items()
        if isinstance(one, TestFigures)
    ]
    job.console.note(describe.table(["direction", "test", "rel. rms", "NRMSE", "rows"], rows))
    for unknown in fit.undetermined:
        job.console.note(
            f"{unknown.constant}: not told by these tests, {unknown.value:g} taken; {unknown.test} tells it"
        )
    for curve in readings.curves:
        known = document.tested_stretch()
        job.ranges.used("stretch", curve.stretch, known=known, source=curve.source, direction=curve.direction)
    if out.wants_files:
        out.add(".csv", fit.curves_csv())
        out.add(".png", fit.picture())
    job.write(out, document)
    return 0 if fit.accepted else NEGATIVE_VERDICT


def _fit_foam(job: Job, out: Output, readings: Readings, setting: Setting, model: str) -> int:
    """Identify the law of a foam and write it."""
    from hyperfab.chapters.fit.hyperfoam import fit_foam

    with job.console.progress("Identifying") as advance:
        advance(0.0, model)
        fit = fit_foam(readings, setting, ORDERS[model])
    document = fit.document(readings)
    for text in readings.warnings:
        job.console.warn(text)
    for reason, count in (document.left_out or {}).items():
        job.console.note(f"{count} rows left out: {reason}")
    rows = [
        [test, f"{one.relative_rms:.4g}", f"{one.nrmse:.4g}", str(one.points)]
        for test, one in fit.figures.tests.items()
        if isinstance(one, TestFigures)
    ]
    job.console.note(describe.table(["test", "rel. rms", "NRMSE", "rows"], rows))
    for unknown in fit.undetermined:
        job.console.note(f"{unknown.constant} stands at {unknown.value:g}: {unknown.test} would tell it")
    for curve in readings.curves:
        if curve.mode in setting.fit_on and curve.mode != "simple-shear":
            known = document.tested_stretch(test=curve.mode)
            job.ranges.used("stretch", curve.stretch, known=known, source=curve.source)
    if out.wants_files:
        out.add(".csv", fit.curves_csv())
        out.add(".png", fit.picture())
    job.write(out, document)
    return 0 if fit.accepted else NEGATIVE_VERDICT


def _stress(text: str | None, option: str, sizes: Geometry) -> float | None:
    """Return a stress [MPa], given as such or as force per width [N/mm] (over the thickness, where it is known)."""
    if text is None:
        return None
    try:
        return quantity(text, "stress", option=option)
    except UsageError:
        return quantity(text, "membrane-stress", option=option) / (sizes.thickness or 1.0)


def _chosen(fit_on: str | None, readings: Readings) -> tuple[str, ...]:
    """Return the tests that take part, as the data name them."""
    if fit_on is None:
        return tuple(readings.modes)
    wanted = [word.strip() for word in fit_on.split(",") if word.strip()]
    found: list[str] = []
    for word in wanted:
        same = [
            mode for mode in readings.modes if mode.removesuffix("-general") == word.removesuffix("-general")
        ]
        if not same:
            raise UsageError(
                f"--fit-on {fit_on}: no {word} test is given; there is {', '.join(readings.modes)}"
            )
        found += [mode for mode in same if mode not in found]
    if not found:
        raise UsageError("--fit-on: name at least one test, as uniaxial,shear")
    return tuple(found)


def _sets(readings: Readings) -> Sets:
    """Return all curves, and those of each direction where tests were cut both ways.

    A test without a direction belongs to each.
    """
    names = list(dict.fromkeys(curve.direction for curve in readings.curves if curve.direction is not None))
    if len(names) < 2:
        return {None: readings.curves}
    return {
        None: readings.curves,
        **{name: [c for c in readings.curves if c.direction in (name, None)] for name in names},
    }


def _judge_all(job: Job, candidates: Sequence[Law], sets: Sets, setting: Setting) -> list[Judged]:
    judged = []
    with job.console.progress("Identifying") as advance:
        for number, candidate in enumerate(candidates):
            advance(number / len(candidates), candidate.name)
            judged.append(judge(candidate, sets, setting, ranked=len(candidates) > 1))
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
    directions = {
        name: describe.direction(
            found,
            outliers(found, rows_of(found, sets, name), setting),
            reach(sets[name]),
            with_plane,
            tested(sets[name], setting),
        )
        for name, found in best.results.items()
        if name is not None and isinstance(found, Identified)
    }
    if ranking is not None:
        for name, part in directions.items():
            _of_law(part.fit, law_spread(ranking, name))
    data_reach = reach(sets[None])
    document = MaterialDocument(
        model=best.law.name,
        parameters=whole.material.parameters,
        thickness_mm=readings.thickness,
        thickness_nominal=readings.nominal or None,
        temperature_degC=whole.temperatures[whole.reference],
        directions=directions or None,
        temperatures=describe.temperatures(whole),
        fit=describe.with_outliers(
            describe.fit_figures(whole, data_reach), outliers(whole, sets[None], setting)
        ),
        stability=describe.stability(whole, data_reach),
        stability_plane=describe.plane(whole, data_reach, with_plane),
        stable=best.stable,
        accepted=best.accepted,
        accepted_by="relative_rms" if setting.relative else "nrmse",
        objective="relative" if setting.relative else "absolute",
        fit_on=list(setting.fit_on),
        left_out=dict(sorted(readings.left_out.items())) or None,
        preparation=readings.preparation or None,
        replicates=replicates(readings.curves) or None,
        bulk_modulus_MPa=readings.bulk_modulus,
        warnings=[*readings.warnings, *doubts(best, sets, setting)] or None,
        models=None
        if ranking is None
        else [
            describe.model_row(
                one.law.name,
                one.failure or one.results[None],
                one.carry_over,
                one.stable,
                one.accepted,
                data_reach,
            )
            for one in ranking
        ],
        effects=[],
        tested=tested(sets[None], setting),
    )
    if ranking is not None:
        _of_law(document.fit, law_spread(ranking, None))
        told = closer(ranking)
        document.warnings = [*(document.warnings or []), *([told] if told else [])] or None
    return document


def _of_law(figures: FitFigures | None, spread: float | None) -> None:
    """Note what the choice of the law adds."""
    if figures is not None and figures.uncertainty is not None:
        figures.uncertainty.law = spread


def _tell(job: Job, judged: Sequence[Judged], document: MaterialDocument, setting: Setting) -> None:
    for text in document.warnings or ():
        job.console.warn(text)
    for reason, count in (document.left_out or {}).items():
        job.console.note(f"{count} rows left out: {reason}")
    columns = ["model", "E2", "rel. rms", "NRMSE", "unseen", "stable", "accepted"]
    if not setting.relative:
        columns[-1] += " by NRMSE"
    rows = []
    for one in judged:
        cells = describe.figures_cells(_written(one))
        unseen = f"{one.carry_over:.4g}" if one.carry_over < 1e300 else "-"
        flags = (
            ["-", "-"] if one.failure else ["yes" if one.stable else "no", "yes" if one.accepted else "no"]
        )
        rows.append([one.law.name, *cells, unseen, *flags])
    job.console.note(describe.table(columns, rows))
    degrees = sorted({t for part in judged[0].results.values() if isinstance(part, Identified)
                      for t in part.temperatures if t is not None})  # fmt: skip
    if len(degrees) > 1:
        job.console.note(f"constants at {', '.join(f'{t:g}' for t in degrees)} degC; those shown hold at "
                         f"{document.temperature_degC:g} degC")  # fmt: skip
    for name, part in judged[0].results.items():
        if isinstance(part, Identified) and (name is not None or len(judged[0].results) == 1):
            job.console.note(f"{name + ': ' if name else ''}{describe.parameters_line(part, setting)}")


def _written(one: Judged) -> Figures | None:
    """Return the figures of what is written: of both directions together, where each has constants of its own."""
    named = [part for name, part in one.results.items() if name is not None]
    parts = [part.total for part in named or one.results.values() if isinstance(part, Identified)]
    if not parts or one.failure is not None:
        return None
    E2, points = sum(part.E2 for part in parts), sum(part.points for part in parts)
    return Figures(E2, math.sqrt(E2 / max(points, 1)), max(part.nrmse for part in parts), points)
