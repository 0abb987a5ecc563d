"""What should make a user careful: constants the tests do not determine, readings that do not belong."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from hyperfab.chapters.fit.identify import NOISY, Identified, Setting
from hyperfab.chapters.fit.judge import Judged, Sets
from hyperfab.curve import TestCurve
from hyperfab.documents.material import OutlierReading
from hyperfab.materials.modes import SIMPLE_SHEAR
from hyperfab.numerics.doubt import scatter
from hyperfab.report.bands import determined

#: A reading so many standard deviations off is no chance; laws that fit poorly leave up to 5 at the ends of a curve.
FAR = 6.5
#: Below this share of the reading (of the largest stress in an absolute fit) an error is rounding, not a mistake.
SMALL = 0.05
#: Readings beyond the constants that it takes to judge one of them by the others.
ENOUGH = 8
#: From so many rows on a curve shows its own noise.
DENSE = 40
#: A share that is most: of what decides one constant, and of the readings that are missed.
MOST = 0.5
#: An error to be feared that is as much as what is foretold.
AS_MUCH = 1.0
#: So many readings are named in warnings; the document has all.
SHOWN = 5


def doubts(best: Judged, sets: Sets, setting: Setting) -> list[str]:
    """Say why the constants should be used with care."""
    found = _untold(best, setting)
    if not best.accepted and any(curve.mode == "biaxial-general" for curve in sets.get(None, ())):
        found.append(
            f"{best.law.name} is the same along both axes of these tests, and not accepted; --model orthotropic tells "
            "them apart"
        )
    for name, part in best.parts:
        where = f" ({name})" if name else ""
        if not part.stable:
            found.append(f"not Drucker-stable over the data{where}{_first_unstable(part)}")
        if part.fit.at_bound and part.along != "weft":
            found.append(
                f"at the edge of its box{where}: {', '.join(part.fit.at_bound)}; the tests ask for more than it may be,"
                " or do not tell it"
            )
        sure = part.certainty
        if len(part.fit.problem.rows.stress) <= len(sure.names):
            found.append(
                f"as many constants as readings{where}: nothing is left that tells how good the law is, or how sure "
                "they are"
            )
        weak = [
            f"{constant} ± {100 * sd / abs(value):.0f} %" if determined(value, sd) else f"{constant} not at all"
            for constant, value, sd in zip(sure.names, part.material.parameters.values(), sure.sd, strict=True)
            if value != 0.0 and sd > 0.5 * abs(value)
        ]
        if weak:
            found.append(f"constants the tests hardly determine{where}: {', '.join(weak)}")
        if not np.isfinite(sure.condition_number):
            found.append(
                f"some constants move nothing in these tests{where}: a law with fewer would carry them as well"
            )
        elif sure.condition_number > 1e4:
            found.append(f"ill-conditioned{where}: the condition number is {sure.condition_number:.1e}")
        found += _wild(part, setting, where)
        found += _single_readings(part, rows_of(part, sets, name), setting)
        found += _near_zero(part, rows_of(part, sets, name), setting, where)
    return found


def _untold(best: Judged, setting: Setting) -> list[str]:
    """Say where tests of one kind leave open what a law bears in the others."""
    one_kind = all(len(part.tests) == 1 for _, part in best.parts)
    if not (one_kind and best.accepted and best.stable and best.law.isotropic and best.carry_over > AS_MUCH):
        return []
    error = f"an error of {best.carry_over:.2g} times the stress" if math.isfinite(best.carry_over) else "any error"
    return [
        f"{setting.fit_on[0]} tests alone do not tell what {best.law.name} bears in other states: {error} is to be "
        "feared there; a law of fewer or other constants may carry over (--model all ranks them by that), tests of "
        "another kind would tell"
    ]


def _near_zero(part: Identified, curves: Sequence[TestCurve], setting: Setting, where: str) -> list[str]:
    """Say where readings that are little but noise decide a relative fit, and the others are missed for them."""
    if not setting.relative or setting.noise is not None:
        return []
    rows, leverage = part.fit.problem.rows, part.certainty.leverage
    noise = np.array([scatter(one.stress) if len(one.stress) >= DENSE else 0.0 for one in setting.used(curves)])
    own = noise[rows.curve]
    near = np.abs(rows.stress) < NOISY * own
    others = ~near & (own > 0.0)
    missed = np.abs(part.fit.residual * rows.stress) > FAR * own
    # One constant decided by them is enough: what they tell of it the others cannot put right.
    if leverage[near].sum() < MOST or not others.any() or np.mean(missed[others]) < MOST:
        return []
    return [
        f"{near.sum()} of {len(near)} readings near zero, below ten times what neighbours scatter by, decide the "
        f"constants{where}, and most others are missed: --noise {noise.max():.2g}MPa lets them count by their absolute "
        "error, --preload takes slack out"
    ]


def _first_unstable(part: Identified) -> str:
    """Return the first unstable stretch of each mode, at the temperature where it comes first."""
    ends = [
        {mode: one.first_unstable for mode, one in ranges.items() if one.first_unstable is not None}
        for ranges in part.every_range
    ]
    number = min(range(len(ends)), key=lambda k: min(ends[k].values(), default=math.inf))
    if not ends[number]:
        return ""
    at = f" at {part.temperatures[number]:g} degC" if len(ends) > 1 else ""
    return f"{at}: first unstable stretch " + ", ".join(f"{m} {s:.3f}" for m, s in ends[number].items())


def _wild(part: Identified, setting: Setting, where: str) -> list[str]:
    wild = [
        mode
        for mode, (figures, _, predicted) in part.tests.items()
        if predicted and (figures is None or not figures.relative_rms <= 1.0)
    ]
    if not wild:
        return []
    return [
        f"not identifiable from {' and '.join(setting.fit_on)} data alone{where}: "
        f"the prediction for {' and '.join(wild)} is wild"
    ]


def rows_of(part: Identified, sets: Sets, name: str | None) -> Sequence[TestCurve]:
    """Return the curves that were fitted for a direction: all of them where the law has directions of its own."""
    return sets[name] if part.law.isotropic else sets[None]


def outliers(part: Identified, curves: Sequence[TestCurve], setting: Setting) -> list[OutlierReading]:
    """Return the readings far from where all others say they should be, farthest first.

    A residual is judged with its reading left out: in a relative fit a reading far too low pulls the constants to
    itself and hides among the others.
    """
    sure = part.certainty
    used = setting.used(curves)
    rows = part.fit.problem.rows
    residual = part.fit.residual
    if len(residual) < part.fit.jacobian.shape[1] + ENOUGH:
        return []
    scale = 1.0 if setting.relative else float(np.abs(part.fit.problem.b).max())
    large = np.abs(residual) > SMALL * scale * np.clip(1.0 - sure.leverage, 1e-3, None)
    found = []
    for k in np.flatnonzero((np.abs(sure.studentised) > FAR) & large):
        number = int(rows.curve[k])
        place = int(k) - int(np.flatnonzero((rows.curve == number) & (rows.along == rows.along[k]))[0])
        curve = used[number]
        dense = setting.relative and len(curve.stress) >= DENSE and curve.mode != "biaxial-general"
        if dense and abs(residual[k] * curve.stress[place]) < FAR * scatter(curve.stress):
            continue  # near zero load the noise of the load cell is many times the reading, and no mistake
        found.append(
            OutlierReading(
                source=curve.source,
                line=None if curve.lines is None else int(curve.lines[place]),
                test=curve.mode,
                stretch=float(curve.stretch[place]),
                stress_MPa=float(curve.stress[place]),
                studentised=float(sure.studentised[k]),
                leverage=float(sure.leverage[k]),
            )
        )
    return sorted(found, key=lambda one: -abs(one.studentised))


def _single_readings(part: Identified, curves: Sequence[TestCurve], setting: Setting) -> list[str]:
    found = []
    for one in outliers(part, curves, setting)[:SHOWN]:
        line = f", line {one.line}" if one.line is not None else ""
        what = "shear strain" if one.test == SIMPLE_SHEAR else "stretch"
        found.append(
            f"{one.source}{line}: {one.stress_MPa:.4g} MPa at {what} {one.stretch:.4g} does not belong to the other "
            f"readings ({abs(one.studentised):.0f} of its standard deviations away); check the reading"
        )
    return found
