"""From test files to the curves of the loop: one curve a specimen and setting, nothing dropped in silence."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from hashlib import sha256
from itertools import pairwise
from typing import Any

import numpy as np

from hyperfab.cases.fit import FitCase
from hyperfab.cases.like import asked
from hyperfab.chapters.close_loop.domain import How
from hyperfab.chapters.close_loop.readings import told_left_out
from hyperfab.chapters.fit.prepare import Steps, prepare, settled, whole
from hyperfab.chapters.job import Job
from hyperfab.chapters.look import per_width, remarks, states, understood, unused_columns
from hyperfab.curve import TestCurve
from hyperfab.documents.provenance import Provenance
from hyperfab.errors import InputError
from hyperfab.io.csv_tests import TestData, read_tests
from hyperfab.io.layout import Layout
from hyperfab.io.role_words import UnknownTest
from hyperfab.loop.fabric_tests import thinned
from hyperfab.materials.modes import OF_A_SHEET
from hyperfab.numerics.doubt import moving
from hyperfab.numerics.hygiene import look
from hyperfab.numerics.spikes import under_dead_load

#: Readings that no specimen gave, by the kind of what is odd, and how they are counted.
_UNSOUND = {
    "lost": "where the stretch was lost",
    "step-back": "after the stretch stepped back in mid-pull",
    "spike": "off its neighbours",
    "ringing": "where the machine rings",
    "saturation": "at the end of the range",
    "doubled": "stands twice",
}
#: Readings below which two tests may be alike by chance.
_TWIN = 6


@dataclass
class Measured:
    """The curves, the unit their stresses are reported in, and what is to be said about them.

    ``given`` are the kinds of tests that the files were given as, None where one of them was not.
    """

    tests: list[TestCurve]
    unit: str
    given: set[str | None] = field(default_factory=set)
    left_out: Counter[str] = field(default_factory=Counter)
    warnings: list[str] = field(default_factory=list)
    preparation: list[str] = field(default_factory=list)


def read_measured(
    job: Job,
    names: Sequence[str],
    layout: Layout,
    thickness: float | None,
    given: Mapping[str, str],
    how: How,
    carries: Sequence[str],
    beside: Measured | None = None,
) -> Measured:
    """Read test files; stress in N/mm becomes MPa by ``thickness`` [mm], or counts as that of 1 mm without one.

    ``carries`` are the kinds of tests that the model has a say in.
    A file is the test that it was ``given`` as for the model's fit, where ``how`` does not say it. Files held out are
    read ``beside`` the others: one that does not say its test is of the one kind that all those were given as. How each
    was read is said, and kept in ``preparation``.
    """
    found = Measured([], "MPa")
    every: list[TestData] = []
    for name in names:
        data = job.inputs.read(name)
        kind = how.kinds.get(name) or given.get(sha256(data).hexdigest())
        found.given.add(kind)
        try:
            every += read_tests(data, name, test=kind, geometry=how.sizes, columns=layout)
        except UnknownTest as error:
            if beside is None:
                raise
            kind = _like_all(beside, error)
            every += read_tests(data, name, test=kind, geometry=how.sizes, columns=layout)
            found.preparation.append(f"{name}: {kind}, as all measured files were given")
    unused_columns(layout, every)
    found.preparation += understood(every, aside=False)
    job.console.note(*found.preparation)
    silent = settled(how.steps) | {"unloading", "cycles"}
    found.warnings += remarks(every, silent)
    remedy = "state the thickness in the model (thickness_mm), so that all stresses are in MPa"
    if thickness is None and per_width(every, remedy):
        found.unit = "N/mm"
    for part in {id(test.left_out): test for test in every}.values():
        for reason, count in part.left_out.items():
            found.left_out[f"{part.source}: {reason}"] += count
    for test in every:
        if len(test.stress) > 1 and not np.any(np.diff(test.stress)):
            creeps = under_dead_load(test.stretch, np.arange(len(test.stress)), test.time_s)
            raise InputError(
                f"the stress is {test.stress[0]:g} in all {len(test.stress)} rows",
                file=test.source,
                column="stress",
                remedy="export the reading of the load cell" + creeps * ", and the rows in which the load comes on",
            )
    every = _sound(every, found)
    stated = [states(test) for test in every]
    told = {(test.source, key) for test, own in zip(every, stated, strict=True) for key in own}
    # What is the same in all tests tells none of them apart.
    one = {key for _, key in told if len({own.get(key) for own in stated}) == 1}
    if rides := sorted(f"{source}: {key}" for source, key in told if key not in one):
        found.warnings.append(f"no law knows {', '.join(rides)}: taken as states that what is left may ride on")
    if one:
        job.console.note(f"stated and not used: {', '.join(sorted(one))}")
    for test in every:
        if test.mode not in carries:
            kind = test.mode.replace("-", " ")
            found.left_out[f"{test.source}: {kind} test, the model's law has no say in it"] += len(test.stretch)
            found.warnings.append(f"{test.source} is left out: the model's law has no say in a {kind} test")
            continue
        factor = 1.0 / thickness if test.membrane and thickness else 1.0
        found.tests += _curves(test, factor, how.steps, found)
    if not found.tests:
        raise InputError("has no test of a sheet", file=names[0], remedy="give uniaxial, shear or biaxial tests")
    return found


def _like_all(measured: Measured, unknown: UnknownTest) -> str:
    """Return the one kind that all measured files were given as; the error that a file held out says none otherwise."""
    kind = next(iter(measured.given)) if len(measured.given) == 1 else None
    if kind is None:
        raise InputError(
            unknown.message,
            file=unknown.file,
            remedy='add a first line "# test: uniaxial" (shear, biaxial); held out it takes the kind of the measured '
            "files where all of them are given by one option, as --uniaxial",
        )
    return kind


def _sound(tests: Sequence[TestData], found: Measured) -> list[TestData]:
    """Return the tests without readings that no specimen can have given, each counted in ``found``.

    Those after a specimen broke or an extensometer slipped, rows in which it had lost its marks, single readings off
    the curve, a machine that rings, a reading that stands at the end of its range, rows and tests that stand twice.
    """
    kept, seen = [], set()
    for test in tests:
        print_of = sha256(test.stretch.tobytes() + test.stress.tobytes()).digest()
        if print_of in seen and len(test.stretch) >= _TWIN:
            found.left_out[f"{test.source}: the readings of another test once more"] += len(test.stretch)
            continue
        seen.add(print_of)
        test = whole(test, found.left_out, f"{test.source}: ")
        sound = np.ones(len(test.stretch), dtype=bool)
        across = test.stretch2 if test.mode == "biaxial-general" else None
        for doubt in look(
            test.stretch, test.stress, stretch2=across, time=test.time_s, branch=test.branch, cycle=test.cycle
        ):
            if doubt.kind not in _UNSOUND or test.mode == "volumetric":
                continue
            gone = slice(doubt.rows[0], None) if doubt.kind == "step-back" else list(doubt.rows)
            found.left_out[f"{test.source}: {_UNSOUND[doubt.kind]}"] += int(np.count_nonzero(sound[gone]))
            sound[gone] = False
        if sound.all():
            kept.append(test)
        elif np.count_nonzero(sound) > 1:
            kept.append(test.take(sound))
    found.warnings += told_left_out(found.left_out)
    return kept


def given_as(data: Mapping[str, Any], name: str, fitted: Provenance | None) -> dict[str, str]:
    """Return, by the SHA-256 of the files the model ``name`` was ``fitted`` to, which test each was given as."""
    if fitted is None or fitted.command != FitCase.COMMAND:
        return {}
    values, hashes = asked(FitCase, data, name, fitted)
    known = {one.name: one.sha256 for one in fitted.inputs}
    found = {}
    for kind in OF_A_SHEET:
        names = values.get(kind, ())
        for file, hashed in zip(names, hashes.get(kind) or [None] * len(names), strict=False):
            found[hashed or known.get(file, "")] = kind
    return found


def _curves(test: TestData, factor: float, steps: Steps, measured: Measured) -> list[TestCurve]:
    """Split a test where a new run begins, and a general biaxial one into its two axes."""
    found: list[TestCurve] = []
    parts = [(number, test.take(rows)) for number, rows in enumerate(_runs(test))]
    if steps != Steps():
        told: list[str] = []
        prepared = [
            (number, one)
            for number, part in parts
            for one in prepare([part], steps, measured.left_out, told, nothing_left=True)
        ]
        if not prepared:
            prepare([test], steps, Counter(), [])  # says why
        measured.preparation += [one for one in dict.fromkeys(told) if one not in measured.preparation]
        parts = prepared
    for number, whole_run in parts:
        run = thinned(whole_run)
        if fewer := len(whole_run.stretch) - len(run.stretch):
            measured.left_out[f"{test.source}: between readings that tell as much"] += fewer
        curve = _curve(run, factor, number)
        if test.mode == "biaxial-general" and curve.direction is None:
            # Its two axes are across each other whether or not the file says which is the warp.
            curve = replace(curve, direction=0.0)
        found.append(curve)
        if run.mode == "biaxial-general" and run.stress2 is not None and run.stretch2 is not None:
            found.append(
                replace(
                    curve,
                    source=f"{curve.source}, second axis",
                    stretch=run.stretch2,
                    stretch2=run.stretch,
                    stress=factor * run.stress2,
                    direction=(curve.angle_deg + 90.0) % 180.0,
                )
            )
    return found


def _curve(test: TestData, factor: float, number: int) -> TestCurve:
    words = [test.source]
    words += [text for text in (test.direction_name, test.specimen and f"specimen {test.specimen}") if text]
    if number:
        words.append(f"run {number + 1}")
    return replace(
        test,
        source=", ".join(words),
        stress=factor * test.stress,
        specimen=f"{test.source} {test.specimen or number} {test.direction_name}",
        stress_sd=None if test.stress_sd is None else factor * test.stress_sd,
        others=states(test),
    )


def _runs(test: TestData) -> list[slice]:
    """Return the rows of each run: a clock that goes back, or without a clock a new rate or temperature, begins one."""
    count = len(test.stretch)
    cut = np.zeros(count, dtype=bool)
    if test.time_s is not None:
        cut[1:] |= np.diff(test.time_s) < 0.0
    else:
        for column, size in ((test.rate_1_s, 1e-9), (test.temperature_degC, 2.0)):
            if column is not None:
                cut[1:] |= np.abs(np.diff(column)) > size
        if test.branch is None and test.cycle is None:
            # A file of several pulls one after another: back to the start in one row.
            stretch = test.stretch
            if test.mode == "biaxial-general" and test.stretch2 is not None:
                stretch = moving(stretch, test.stretch2)
            cut[1:] |= np.diff(stretch) < -0.5 * float(np.ptp(stretch))
    if test.cycle is not None and test.time_s is None:
        cut[1:] |= np.diff(test.cycle) < 0
    edges = [0, *(int(i) for i in np.flatnonzero(cut)), count]
    return [slice(a, b) for a, b in pairwise(edges) if b - a > 0]
