"""From test files to the readings a fit sees: what is kept, what is left out and why."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from hyperfab.arrays import Array, Flags, Ints
from hyperfab.chapters.fit.identify import near_zero
from hyperfab.chapters.fit.prepare import Steps, prepare, settled
from hyperfab.chapters.look import per_width, remarks, understood, unused_columns
from hyperfab.curve import TestCurve
from hyperfab.errors import InputError, UsageError
from hyperfab.io.csv_tests import TestData, read_tests
from hyperfab.io.layout import Layout
from hyperfab.io.specimen import Geometry
from hyperfab.materials.hyperfoam import ORDERS
from hyperfab.materials.identification.quality import Figures, figures
from hyperfab.materials.modes import SIMPLE_SHEAR
from hyperfab.numerics.hygiene import ZERO

if TYPE_CHECKING:
    from hyperfab.chapters.job import Job

#: Tests closer than this in temperature [K] are tests at one temperature; where such a chain of readings is longer than
#: ``LONG_CHAIN`` [K], one temperature is too few, and that is said.
SAME_TEMPERATURE, LONG_CHAIN = 5.0, 10.0
#: How far specimens that are compared may be from their median in thickness, as a share (ISO 37:2017).
_ONE_PLATE = 0.075


#: Temperatures [degC] that are taken for one: the lowest and the highest reading, and the mean.
Cluster = tuple[float, float, float]


@dataclass
class Readings:
    """All curves of a fit, and what is to be said about them."""

    curves: list[TestCurve]
    volumetric: list[TestData]
    thickness: float | None
    nominal: bool
    left_out: Counter[str] = field(default_factory=Counter)
    preparation: list[str] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)

    @property
    def bulk_modulus(self) -> float | None:
        """Mean stress over change of volume [MPa], by least squares; pressure counted either way."""
        return abs(self._bulk[0]) if self.volumetric else None

    @property
    def bulk_figures(self) -> Figures | None:
        """How well the bulk modulus carries the volumetric tests; None without one."""
        if not self.volumetric:
            return None
        slope, change, stress = self._bulk
        return figures(stress, slope * change)

    @property
    def _bulk(self) -> tuple[float, Array, Array]:
        """Slope [MPa] of the mean stress against the change of volume, and both of all volumetric tests."""
        change = np.concatenate([test.stretch - 1.0 for test in self.volumetric])
        stress = np.concatenate([test.stress for test in self.volumetric])
        square = float(change @ change)
        return float(change @ stress) / square if square > 0.0 else 0.0, change, stress

    @property
    def modes(self) -> list[str]:
        """The tests at hand, in the order of the options."""
        return list(dict.fromkeys(curve.mode for curve in self.curves))


def read_all(
    job: Job,
    files: Mapping[str, Sequence[str]],
    geometry: Geometry,
    columns: Layout,
    told: list[str],
) -> list[TestData]:
    """Read every file as the test its option says, or as what it is itself under no name; say how each was read.

    UsageError where there is none, or one is given twice.
    """
    names = [name for group in files.values() for name in group]
    if not any(files.get(test) for test in ("", "uniaxial", "shear", "biaxial")):
        raise UsageError("no test to fit; give one as FILE, or with --uniaxial, --shear or --biaxial")
    twice = [name for name, count in Counter(names).items() if count > 1]
    if twice:
        raise UsageError(f"{twice[0]} is given twice; its rows would count double")
    found = []
    for test, group in files.items():
        for name in group:
            data = job.inputs.read(name)
            found += read_tests(data, name, test=test or None, geometry=geometry, columns=columns, clock=False)
    unused_columns(columns, found)
    lines = understood(found)
    job.console.note(*lines)
    told += lines
    return found


def gather(
    tests: Sequence[TestData],
    steps: Steps,
    relative: bool,
    kinds: Sequence[str],
    sheet: bool,
    noise: float | None,
) -> Readings:
    """Return the curves of ``tests``: nominal stress in MPa, one temperature each, after ``steps``.

    Specimens of a ``sheet`` as thick as each other tell its thickness; of a body, as foam, blocks and strips may be
    cut, and none is its own.

    With ``relative``, rows whose measured stress says nothing about a ratio are left out and counted, but for those
    that its ``noise`` [MPa] accounts for; so are tests other than the ``kinds`` that the law carries.
    """
    sheets = [test for test in tests if test.mode != "volumetric"]
    volumetric = [test for test in tests if test.mode == "volumetric"]
    thickness, unlike, nominal = _thickness(sheets)
    found = Readings([], volumetric, thickness, nominal)
    if found.bulk_modulus == 0.0:
        raise InputError(
            "shows no bulk modulus: its mean stress does not go with its change of volume",
            file=volumetric[0].source,
            remedy="correct the test, or leave it out",
        )
    for counts in {id(test.left_out): test.left_out for test in tests}.values():
        found.left_out.update(counts)
    carried = [test for test in sheets if test.mode in kinds]
    for test in sheets:
        if test.mode not in kinds:
            found.left_out[f"{test.mode}: only {_carriers(test.mode)} carry this test"] += len(test.stretch)
    if not carried:
        sheared = bool(sheets) and sheets[0].mode == SIMPLE_SHEAR
        other = "such a law: --model all" if sheared else f"a law of a foam: --model {next(iter(ORDERS))}"
        raise InputError(
            f"is a test in {sheets[0].mode.replace('-', ' ')}, which only {_carriers(sheets[0].mode)} carry"
            if sheets
            else "is a volumetric test alone",
            file=tests[0].source,
            remedy="give uniaxial, shear or biaxial tests" + (f", or {other}" if sheets else ""),
        )
    clusters = _temperatures(carried)
    split = [(mean, test.take(rows)) for test in carried for mean, rows in _by_temperature(test, clusters)]
    prepared = prepare([test for _, test in split], steps, found.left_out, found.preparation)
    for test in prepared:
        [(temperature, _)] = _by_temperature(test, clusters)
        found.curves.append(replace(test, temperature=temperature, warmth=_warmth(test)))
    if relative:
        found.curves = [_without_zeros(curve, found.left_out, noise) for curve in found.curves]
    found.curves = [curve for curve in found.curves if len(curve.stretch)]
    if not found.curves:
        raise InputError("no row is left to fit", file=tests[0].source, remedy="is the stress zero in all rows?")
    # Pulls at several temperatures are no cycles of one test.
    apart = [test for _, test in split] + [test for test in sheets if test.mode not in kinds]
    found.warnings += remarks(apart, settled(steps))
    found.warnings += [
        f"readings between {low:.4g} and {high:.4g} degC are taken together, as at {mean:.4g} degC: nowhere between "
        f"them is a gap of {SAME_TEMPERATURE:g} K; fit them apart, or give tests at temperatures that stand apart"
        for low, high, mean in clusters
        if high - low > LONG_CHAIN
    ]
    if unlike and sheet:
        thin, thick = unlike
        found.warnings.append(
            f"{thin.source} is {thin.thickness_mm:g} mm thick, {thick.source} {thick.thickness_mm:g} mm: each stress "
            "is that of its own specimen, and the document states no thickness; fit specimens of one material together"
        )
    if found.nominal:
        found.preparation.append(
            "no thickness is known: 1 mm is taken, and a constant in MPa is force per width in N/mm"
        )
    return found


def _carriers(mode: str) -> str:
    """Return in words which laws carry a kind of test that not all do."""
    foams = " and ".join(ORDERS).replace(" and ", ", ", len(ORDERS) - 2)
    return f"isotropic laws that keep their volume, {foams}" if mode == SIMPLE_SHEAR else foams


def _thickness(tests: Sequence[TestData]) -> tuple[float | None, tuple[TestData, TestData] | None, bool]:
    """Return the thickness of all tests, or the thinnest and the thickest where none is that of all; and whether it is
    the nominal 1 mm of N/mm.

    Each stress is that of its own specimen: planar tests are cut of a thinner plate than dumbbells.
    """
    if per_width(tests, "give --thickness, so that all tests are in MPa"):
        return 1.0, None, True
    known = sorted((test.thickness_mm, place) for place, test in enumerate(tests) if test.thickness_mm is not None)
    sizes = [size for size, _ in known]
    if sizes and max(sizes[-1] / float(np.median(sizes)), float(np.median(sizes)) / sizes[0]) > 1.0 + _ONE_PLATE:
        return None, (tests[known[0][1]], tests[known[-1][1]]), False
    return (float(np.mean(np.unique(sizes))) if sizes else None), None, False


def _temperatures(tests: Sequence[TestData]) -> list[Cluster]:
    """Return the clusters of temperatures met in the tests: both ends and the mean of each."""
    every = [test.temperature_degC for test in tests if test.temperature_degC is not None]
    if not every:
        return []
    values = np.sort(np.concatenate(every))
    parts = np.split(values, np.flatnonzero(np.diff(values) > SAME_TEMPERATURE) + 1)
    return [(float(part[0]), float(part[-1]), round(float(part.mean()), 1)) for part in parts]


def _by_temperature(test: TestData, clusters: Sequence[Cluster]) -> list[tuple[float | None, Ints]]:
    if test.temperature_degC is None:
        return [(None, np.arange(len(test.stretch)))]
    number = np.searchsorted([high for _, high, _ in clusters], test.temperature_degC)
    split = [(mean, np.flatnonzero(number == k)) for k, (_, _, mean) in enumerate(clusters)]
    return [(mean, rows) for mean, rows in split if len(rows)]


def _warmth(test: TestData) -> tuple[float, float] | None:
    if test.temperature_degC is None:
        return None
    return float(test.temperature_degC.min()), float(test.temperature_degC.max())


def _without_zeros(curve: TestCurve, left_out: Counter[str], noise: float | None) -> TestCurve:
    """Leave out rows that have no ratio of model to measured stress.

    Readings near zero whose noise is known count by their absolute error, on both sides of it.
    """
    floor = near_zero(curve, noise)

    def nothing(stress: Array) -> Flags:
        return np.asarray((np.abs(stress) <= ZERO * float(np.abs(stress).max(initial=0.0))) & (floor == 0.0))

    zero = nothing(curve.stress)
    moved = curve.principal - 1.0
    rest = (moved == 0.0) & ~zero
    against = ~zero & ~rest & (moved * curve.stress < 0.0) & (np.abs(curve.stress) > floor)
    if curve.mode == "biaxial-general":
        assert curve.stress2 is not None
        assert curve.stretch2 is not None
        zero |= nothing(curve.stress2)
        rest = (curve.stretch == 1.0) & (curve.stretch2 == 1.0) & ~zero
        against = np.zeros_like(zero)
    for reason, rows in (
        ("stress is zero, a relative error has no meaning", zero),
        ("stretch is 1, every law gives zero stress", rest),
        ("stress against the stretch, no elastic law gives that", against),
    ):
        if rows.any():
            left_out[reason] += int(rows.sum())
    bad = zero | rest | against
    return curve.take(np.flatnonzero(~bad)) if bad.any() else curve


def contractions(curves: Sequence[TestCurve], fitted: bool) -> list[str]:
    """Say how much the uniaxial specimens contract, where it was measured, and whether that is ``fitted``."""
    told = []
    measured = [curve for curve in curves if curve.mode == "uniaxial" and curve.stretch2 is not None]
    for direction in dict.fromkeys(curve.direction_name for curve in measured):
        own = [curve for curve in measured if curve.direction_name == direction]
        along = np.log(np.concatenate([curve.stretch for curve in own]))
        across = np.log(np.concatenate([curve.stretch2 for curve in own if curve.stretch2 is not None]))
        if along @ along > 0.0:
            where = f" along the {direction}" if direction else ""
            told.append(
                f"measured contraction{where}: lateral stretch = stretch^{float(along @ across / (along @ along)):.3f} "
                f"(-0.5 keeps the volume){'' if fitted else '; it takes no part in the fit'}"
            )
    return told
