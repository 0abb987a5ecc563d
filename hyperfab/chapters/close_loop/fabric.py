"""The loop on tests of a fabric: a material document against what a testing machine read."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from hyperfab.chapters.close_loop.describe import curves_csv, describe, say
from hyperfab.chapters.close_loop.domain import Given
from hyperfab.chapters.close_loop.extended import extend, held_terms, in_terms
from hyperfab.chapters.close_loop.finalise import errors_apart, picture, ticking, write
from hyperfab.chapters.close_loop.measured_tests import Measured, given_as, read_measured
from hyperfab.chapters.close_loop.readings import Apart, check_fixed, stated_size
from hyperfab.chapters.close_loop.sure import mark, tell_sure
from hyperfab.chapters.fabric import ORTHOTROPIC, FabricDocument
from hyperfab.chapters.job import Job
from hyperfab.chapters.look import tested_by
from hyperfab.chapters.validity import Ranges
from hyperfab.documents.base import Validity, parse_document
from hyperfab.documents.material import MaterialDocument
from hyperfab.errors import InputError
from hyperfab.io.json_io import dump_json
from hyperfab.io.output import Output
from hyperfab.loop.catalogue.fabric import bare_effects
from hyperfab.loop.catalogue.fabric.context import is_slanted
from hyperfab.loop.engine import Finding, close
from hyperfab.loop.fabric import FabricProblem, fabric_problem
from hyperfab.loop.gauges import misread
from hyperfab.loop.no_worse import none_apart
from hyperfab.materials.effects.fabric import AT_A_TEMPERATURE
from hyperfab.materials.effects.path import MODE_NAMES
from hyperfab.materials.hyperfoam import ORDERS
from hyperfab.materials.modes import OF_A_SHEET, SIMPLE_SHEAR
from hyperfab.materials.registry import carried_by, law_of, stiffness_at_rest
from hyperfab.materials.rest import beyond_isotropy
from hyperfab.materials.stability import stable_ranges

#: Work of a usual run, in refits, for the progress line.
_REFITS = 60.0
#: Rows needed beyond the model's own constants.
_SPARE = 9


def run(job: Job, given: Given) -> int:
    """Close the loop on a material document."""
    out = job.opened(".model.json", ".png", ".csv")
    document = parse_document(given.data, given.case.model, MaterialDocument)
    before = given_as(given.data, given.case.model, document.provenance)
    # A thickness that was only taken for the sake of a number makes no stress of a force per width.
    thickness = None if document.thickness_nominal else document.thickness_mm
    foam = document.model in ORDERS
    # Whatever a law carries, a volumetric test is no way that a specimen is led.
    kinds = OF_A_SHEET if document.directions else carried_by(document.model)
    carries = [kind for kind in kinds if kind in MODE_NAMES]
    how = (given.layout, thickness, before, given.how, carries)
    tests = read_measured(job, given.case.readings, *how)
    held_out = read_measured(job, given.case.held, *how, beside=tests) if given.case.held else None
    for one in (tests, held_out):
        if one is not None and not foam:
            _unturn(one)
    level = stated_size(given.case.noise, "membrane-stress" if tests.unit == "N/mm" else "stress")
    out.refuse_inputs(job.inputs)
    document = in_terms(document, given.case.model, tests.tests)
    asked = (given.case.model, tests, given.case.fix, given.case.prior)
    problem = pose(document, *asked)
    if problem.both and not document.effects and is_slanted(problem.fabric.path.angle_deg).any():
        document = document.model_copy(update={"directions": None})
        problem = replace(pose(document, *asked), as_delivered=problem.delivered)
        tests.warnings.append(
            "constants along warp and weft tell nothing of what lies between, which these tests show: the loop starts "
            "from one law for all directions"
        )
    tests.warnings += map(str, misread(problem.curves, problem.measured))
    stiff = beyond_isotropy(tests.tests) if foam else None
    tests.warnings += [] if stiff is None else [stiff]
    rows, free = len(problem.measured), len(problem.own)
    if rows < free + _SPARE:
        raise InputError(
            f"has too few rows ({rows}) to tell noise from a residual: the model has {free} constants of its own",
            file=given.case.readings[0],
            remedy=f"give {free + _SPARE} or more",
        )
    _warn(job, document, tests)
    _note_ranges(job, document, given.case.model, tests)
    apart = None if held_out is None else _set_apart(problem, held_out)
    with job.console.progress("Closing the loop") as advance:
        misses = none_apart if apart is None else apart.misses
        found = close(problem, noise=level, tick=ticking(advance, 0.0, _REFITS), apart=misses)
    model = extend(document, problem, found.after.fit, problem.law)
    tell_sure(model, found, lambda fit: extend(document, problem, fit, problem.law), len(problem.tests))
    model.format = model.format_name()
    mark(model.effects or [], found)
    doubts = [*_nearly(model), *(list(_soft(model)) or _falls(model))]
    tests.warnings += doubts
    job.console.warn(*doubts)
    result = describe(problem, found, tests.left_out, tests.warnings)
    result.preparation = tests.preparation
    if apart is not None and held_out is not None:
        result.held_out = errors_apart(apart, found, len(held_out.tests))
    say(job.console, problem, found, result)
    if out.wants_files:
        model.validity = _closed_on(given.case.readings, tests)
        out.add(".model.json", dump_json(job.stated(model, out.target, given.case)))
        result.model = out.path(".model.json").name
        _files(job, out, problem, found)
    return write(job, out, given, found, result)


def _unturn(measured: Measured) -> None:
    """Take simple shear for planar tension, which it is to a law that keeps its volume."""
    sheared = [test.source for test in measured.tests if test.mode == SIMPLE_SHEAR]
    if sheared:
        measured.tests = [test.in_planar_tension() if test.mode == SIMPLE_SHEAR else test for test in measured.tests]
        measured.preparation.append(
            f"{', '.join(sheared)}: simple shear is taken as planar tension at the same principal stretches, its "
            "stress as that along them"
        )


def pose(
    document: MaterialDocument,
    name: str,
    tests: Measured,
    fix: Sequence[str] = (),
    prior: float | None = None,
) -> FabricProblem:
    """Return the problem of a material document and measured tests."""
    directions = document.directions or {}
    warp_document = directions.get("warp")
    weft_document = directions.get("weft")
    warp = document.parameters if warp_document is None else warp_document.parameters
    # Beside a term that constants of two directions tell only nearly, those of the law without it.
    item = next((item for item in document.effects or [] if item.get("ground")), {})
    ground = item.get("ground")
    law = law_of(str(item.get("law", document.model)), ground or warp, foam=True)
    constants = [float((ground or warp)[key]) for key in law.names]
    weft = None
    if warp_document is not None and weft_document is not None and ground is None:
        law_of(document.model, weft_document.parameters)
        weft = [float(weft_document.parameters[key]) for key in law.names]
    held = {}
    if document.effects:
        held = held_terms(document, name, *bare_effects(law, constants, tests.tests))
    known = set(law.names) | {f"warp {key}" for key in law.names} | {f"weft {key}" for key in law.names}
    known |= {constant.name for _, constants_ in held.values() for constant in constants_}
    check_fixed(fix, sorted(known), "model")
    reference = document.temperature_degC
    for item in document.effects or []:
        if item.get("id") in AT_A_TEMPERATURE and "reference_degC" in item:
            reference = float(item["reference_degC"])
    return fabric_problem(
        law,
        constants,
        tests.tests,
        weft=weft,
        held=held,
        fixed=tuple(fix),
        prior=prior,
        reference_degC=reference,
        units=(tests.unit, ""),
    )


def _note_ranges(job: Job, document: MaterialDocument, name: str, tests: Measured) -> None:
    """Note where the model was used as it was delivered: an extended one carries the ranges of these tests."""
    for test in tests.tests:
        way = test.direction_name if test.direction_name in (document.directions or {}) else None
        known = document.tested_stretch(way)
        for range_ in (tested_by([test]) or {}).values():
            job.ranges.used("stretch", range_.stretch, known=known, source=name, direction=way)
            warm = range_.temperature_degC or ()
            job.ranges.used("temperature_degC", warm, known=FabricDocument(document, name).known or None, source=name)


def _closed_on(files: Sequence[str], tests: Measured) -> list[Validity]:
    """Return where the extended model was used, and is known: at stretches and temperatures of the files it was closed
    on."""
    ranges = Ranges()
    for name in files:
        read = tested_by([test for test in tests.tests if test.source.startswith(name)]) or {}
        met = [end for range_ in read.values() for end in range_.stretch]
        warm = [end for range_ in read.values() for end in range_.temperature_degC or ()]
        for of, ends in (("stretch", met), ("temperature_degC", warm)):
            ranges.used(of, ends, known=ends, source=os.path.basename(name))
    return ranges.entries


def _warn(job: Job, document: MaterialDocument, tests: Measured) -> None:
    softens = any(item.get("id") == "thermal-softening" for item in document.effects or [])
    if document.temperatures and not softens:
        tests.warnings.append(
            "the model's constants at other temperatures are set aside: the loop starts from those of its own"
        )
    if not any(np.isfinite(test.angle_deg) for test in tests.tests) and document.directions:
        tests.warnings.append("the tests state no direction: they are taken as pulled along the warp")
    job.console.warn(*tests.warnings)


def _nearly(model: MaterialDocument) -> Iterator[str]:
    """Yield where constants of warp and weft tell a term only nearly."""
    for item in model.effects or []:
        if item.get("ground") and item.get("told_by") == "directions":
            yield (
                f"anisotropy: other commands compute with the constants of warp and weft that come nearest to "
                f"{item['form']}; the term itself stands in effects, and hf close-loop goes on from it"
            )


def _soft(model: MaterialDocument) -> Iterator[str]:
    """Yield where the constants that these data ask for give a fabric that other commands must refuse."""
    if model.model == ORTHOTROPIC:
        return  # none of its constants is below zero
    ways = {f" along the {way}": one.parameters for way, one in (model.directions or {}).items()}
    ways = ways or {"": model.parameters}
    for way, parameters in ways.items():
        law = law_of(model.model, parameters, foam=True)
        modulus = stiffness_at_rest(law, parameters)
        if not 0.0 < modulus < np.inf:
            yield (
                f"the constants of {model.model} these data ask for have no stiffness at rest{way} (Young's modulus "
                f"{modulus:.3g} MPa): no other command takes the extended model; fit a law with fewer constants"
            )


def _falls(model: MaterialDocument) -> Iterator[str]:
    """Yield where a law takes less stress for more strain within the tests: whatever they show beside it."""
    if model.model == ORTHOTROPIC or model.model in ORDERS:
        return  # the one is stable, and the plateau of the other is flat
    read = FabricDocument(model, "the extended model")
    ways = {way: one.tested for way, one in (model.directions or {}).items()} or {"": model.tested}
    for direction, kinds in ways.items():
        ends = {kind: one.first_unstable for kind, one in stable_ranges(read.material(direction or None)).items()}
        for kind, tested in (kinds or {}).items():
            end, last = ends.get(kind), tested.stretch[1]
            if end is not None and end < last:
                along = f" along the {direction}" * bool(direction)
                yield (
                    f"the law of the extended model{along} loses Drucker stability at a stretch of {end:.5g} in "
                    f"{kind} tests, which went to {last:.4g}: commands that stretch it so far may end with status 4; "
                    "begin with a law that is stable there, as of hf fit --model all"
                )


def _set_apart(problem: FabricProblem, tests: Measured) -> Apart:
    """Return tests that take no part beside those of a problem."""
    wider = problem.remake([*problem.tests, *tests.tests])
    measured = np.concatenate([test.stress for test in tests.tests])
    begin = sum(len(test.stretch) for test in problem.tests)
    return Apart(wider, slice(begin, begin + len(measured)), measured)


def _files(job: Job, out: Output, problem: FabricProblem, found: Finding) -> None:
    out.add(".csv", curves_csv(job, problem, found))
    widths = [curve for curve in problem.curves if curve.channel == 1]
    out.add(".png", picture(problem, found, "stretch", problem.units[0], {"mode": MODE_NAMES}, widths))
