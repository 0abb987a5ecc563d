"""Spring laws straight from uniaxial tests: the measured curve as straight pieces."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass

import numpy as np

from hyperfab.arrays import Array
from hyperfab.chapters.job import Job
from hyperfab.cloth import SpringLaw, piecewise_linear
from hyperfab.errors import InputError, placed
from hyperfab.io.csv_tests import TestData, read_tests
from hyperfab.io.specimen import Geometry
from hyperfab.io.text import number_of_rows
from hyperfab.numerics.hygiene import first_loading
from hyperfab.numerics.monotone import never_falling

#: Tests further apart than this in temperature [K] are not of one curve.
ONE_TEMPERATURE = 5.0
#: A specimen whose stress falls below this share of its peak after it has failed.
FAILED = 0.9


@dataclass(frozen=True)
class Curve:
    """A measured law: how far it was tested, where the specimen failed (None: it did not), its thickness in mm.

    ``per_width``: no thickness is known, and the law is force per width in N/mm.
    """

    law: SpringLaw
    tested: float
    fails_at: float | None
    thickness: float | None
    per_width: bool


def read_curve(job: Job, option: str, name: str, direction: float, thickness: float | None) -> Curve:
    """Read the uniaxial test or tests of one direction (degrees from the warp) as one spring law.

    Loading on the first cycle is taken; specimens are averaged over the stretches all of them reach; a stress that
    falls with the stretch is levelled (the nearest rising curve). What is left out or altered is said.
    ``thickness`` in mm, from the command line, turns force per width into stress.
    """
    geometry = Geometry(thickness=thickness)
    tests = read_tests(job.inputs.read(name), name, test="uniaxial", geometry=geometry, clock=False)
    _one_direction(tests, option, name, direction)
    dropped: Counter[str] = Counter()
    for test in tests[:1]:
        dropped.update(test.left_out)
    curves = [_loading(test, name, dropped) for test in tests]
    known = [test.thickness_mm for test in tests if test.thickness_mm is not None]
    stretch, stress = _averaged(curves, dropped)
    peak = int(np.argmax(stress))
    fails = None
    if stress[-1] < FAILED * stress[peak]:
        fails = float(stretch[peak])
        dropped["after the peak stress, the specimen failing"] += len(stretch) - 1 - peak
        stretch, stress = stretch[: peak + 1], stress[: peak + 1]
    level = _rising(stress)
    moved = int(np.count_nonzero(np.abs(level - stress) > 1e-12 * stress.max()))
    if moved:
        most = float(np.abs(level - stress).max() / stress.max())
        job.console.note(
            f"{name}: {moved} of {len(stress)} readings were moved, by up to {100 * most:.2g} % of the peak, so that "
            "the stress does not fall with the stretch"
        )
    for reason, count in sorted(dropped.items()):
        if count:
            job.console.note(f"{name}: {number_of_rows(count)} left out: {reason}")
    with placed(name, remedy="give a uniaxial test in tension"):
        law = piecewise_linear(stretch, level)
    if level[1] <= 0.0:
        raise InputError(
            "the stress does not rise from zero at the first readings",
            file=name,
            remedy="take the slack out of the test (hf fit --preload shows how much)",
        )
    return Curve(law, float(stretch[-1]), fails, float(np.mean(known)) if known else None, tests[0].membrane)


def _one_direction(tests: list[TestData], option: str, name: str, direction: float) -> None:
    for test in tests:
        if test.direction is not None and abs(test.direction - direction) > 1.0:
            raise InputError(
                f"is a test along {test.direction_name}, and {option} takes one at {direction:g} degrees from the warp",
                file=name,
                remedy="exchange the files, or correct the direction the file states",
            )
        if test.temperature_degC is not None and np.ptp(test.temperature_degC) > ONE_TEMPERATURE:
            raise InputError("holds tests at several temperatures", file=name, remedy="give a file of one temperature")
    if len({test.membrane for test in tests}) > 1:
        raise InputError("mixes stress and force per width", file=name, remedy="state the thickness of all")


def _loading(test: TestData, name: str, dropped: Counter[str]) -> tuple[Array, Array]:
    """Stretch and stress of the first loading, by rising stretch, from (1, 0)."""
    keep = first_loading(test.stretch, test.branch, test.cycle)
    later = np.zeros(len(keep), bool)
    if test.cycle is not None:
        later = test.cycle != test.cycle.min()
        dropped["not of the first cycle"] += int(np.count_nonzero(later))
    dropped["unloading and later pulls"] += int(np.count_nonzero(~keep & ~later))
    short = keep & (test.stretch <= 1.0)
    dropped["not stretched"] += int(np.count_nonzero(short))
    keep &= ~short
    if np.count_nonzero(keep) < 2:
        raise InputError(
            "has fewer than two readings of loading in tension", file=name, remedy="give more of the curve"
        )
    stretch, place = np.unique(test.stretch[keep], return_inverse=True)
    stress = np.bincount(place, test.stress[keep]) / np.bincount(place)
    return np.concatenate([[1.0], stretch]), np.concatenate([[0.0], stress])


def _averaged(curves: list[tuple[Array, Array]], dropped: Counter[str]) -> tuple[Array, Array]:
    """Mean of the specimens at all their stretches, as far as each of them goes."""
    if len(curves) == 1:
        return curves[0]
    end = min(float(stretch[-1]) for stretch, _ in curves)
    beyond = sum(int(np.count_nonzero(stretch > end)) for stretch, _ in curves)
    dropped["beyond the stretch that all specimens reach"] += beyond
    at = np.unique(np.concatenate([stretch for stretch, _ in curves]))
    at = at[at <= end]
    return at, np.mean([np.interp(at, stretch, stress) for stretch, stress in curves], axis=0)


def _rising(stress: Array) -> Array:
    """Return the nearest curve from 0 on that does not fall."""
    level = never_falling(stress)
    level[0] = 0.0
    return np.maximum(level, 0.0)
