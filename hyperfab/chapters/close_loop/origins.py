"""Readings that the model meets without any effect, but for where their instrument counts from, or how late it is."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from hyperfab.arrays import Array, Ints
from hyperfab.loop.engine import Finding
from hyperfab.loop.fabric import FabricProblem
from hyperfab.loop.fitting import Fit, fit
from hyperfab.loop.known import FilesProblem
from hyperfab.loop.problem import Constant, Problem
from hyperfab.loop.thresholds import FEWEST, MARGIN, MOST, SHARE, SMALL, TOLD

#: Times that the offset of a load cell is brought nearer to what suits the readings best: the model's own constants go
#: with it, and are linear in it but for their bounds.
_NEARER = 3
#: How far on the flat sheet, as a share of its size, its normals are taken over.
_ASIDE = 0.01
#: How late a force may be, as a share of the time that the shortest test took.
_LATEST = 0.1


def another_frame(problem: Problem, found: Finding) -> list[str]:
    """Return the shift and turn of the frame that markers were read in, and where these are not all the scale too,
    where that is all the model misses them by.

    The motion that brings the model's markers nearest to those read: Kabsch (1976), Acta Cryst. A 32, 922; with the
    scale Umeyama (1991), IEEE Trans. Pattern Anal. Mach. Intell. 13, 376.
    """
    axis = problem.states.get("axis", ())
    count = len(axis)
    if count < 3 * FEWEST:
        return []
    from scipy.spatial.transform import Rotation  # only markers ask for it

    sd = found.noise.sd[:count]
    thought, read = (
        np.stack([rows[:count][axis == way] for way in range(3)], axis=1)
        for rows in (found.before.fit.predicted, problem.measured)
    )
    weight = np.stack([1.0 / sd[axis == way] for way in range(3)], axis=1)
    beyond = float(np.mean(((read - thought) * weight) ** 2)) - 1.0
    centred = read - read.mean(axis=0)
    for hand in (1.0, -1.0):
        handed = thought * np.array([1.0, 1.0, hand])
        turn, _ = Rotation.align_vectors(centred, handed - handed.mean(axis=0))
        turned = turn.apply(handed - handed.mean(axis=0))
        scale = float(np.sum(centred * turned) / max(np.sum(turned**2), 1e-300))
        for larger in (1.0, scale):
            left = float(np.mean(((centred - larger * turned) * weight) ** 2)) - 1.0
            if beyond <= SMALL**2 or left > SHARE * beyond:
                continue
            shifted = read.mean(axis=0) - larger * turn.apply(handed.mean(axis=0))
            shift, angle = ", ".join(f"{one:.3g}" for one in shifted), np.rad2deg(turn.magnitude())
            scaled = "" if larger == 1.0 else f", all {abs(100.0 * (scale - 1.0)):.2g} % too {_size(scale)}"
            mirrored = "" if hand > 0.0 else ", mirrored (z the other way)"
            again = "the frame again at the clamped edge" if larger == 1.0 else "a known length beside the sheet"
            return [
                f"The markers lie where the model has them without any effect, but for their frame{mirrored}, shifted "
                f"by ({shift}) mm and turned by {angle:.2g} deg{scaled}: read {again} before anything is said to lack."
            ]
    return []


def _size(scale: float) -> str:
    return "large" if scale > 1.0 else "small"


def off_the_sheet(problem: Problem, found: Finding) -> list[str]:
    """Return by how much all markers would lie off the sheet, along its normals, where that is all the model misses
    them by: those on the far face of a cloth do."""
    if "axis" not in problem.states or found.verdict == "noise":
        return []
    from hyperfab.loop.drape import DrapeProblem, at_markers  # its splines take a while to load

    if not isinstance(problem, DrapeProblem):
        return []
    normals = []
    for one in problem.files:
        steps = _ASIDE * max(problem.draped.size) * np.eye(2)
        along = [
            at_markers(problem.draped, one.flat + step)[0][0] - at_markers(problem.draped, one.flat - step)[0][0]
            for step in steps
        ]
        normal = np.cross(*along)
        normal *= np.sign(normal[:, 2:]) / np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-300)
        normals.append(normal.T.ravel())
    read = np.arange(sum(map(len, normals)))
    shape = np.zeros(len(problem.measured))
    shape[read] = np.concatenate(normals)
    offset, freed = _off_zero(problem, found, shape)
    if not _is_all(found, freed, read) or freed.chi2 > found.after.fit.chi2 + MARGIN:
        return []
    way = "above" if offset > 0.0 else "below"
    return [
        f"Were the markers {abs(offset):.2g} mm {way} the sheet throughout, along its normals, the model would meet "
        "them without any effect: its sheet has no thickness; look on which face of the cloth they are, and take what "
        "they stand off it off before anything is said to lack."
    ]


def another_zero(problem: Problem, found: Finding) -> list[str]:
    """Return where a machine would count its way from, farther off than is known, where that is all the model misses
    the readings by.

    A soft sheet or foam is touched before a load cell tells: who counts from there, or from anywhere else, counts so.
    """
    ways = [one for one in problem.expected if one.name.endswith(".zero") and one.low < one.high]
    if not ways or not isinstance(problem, FilesProblem) or found.verdict == "noise":
        return []
    before = found.before.fit
    read = np.concatenate([np.arange(c.start, c.stop) for c in problem.curves if not c.beforehand])
    told = []
    for way in ways:
        place = [one.name for one in problem.own].index(way.name)
        loose = problem.counting_from_anywhere(way.name)
        freed = fit(loose, found.noise, {}, before.x)
        zero, farthest = float(freed.x[place]), loose.own[place].high
        if _is_all(found, freed, read) and way.high < abs(zero) < farthest:
            told.append(
                f"Were {way.name} {zero:.3g} mm, though known to {way.prior_sd:.2g} mm, the model would meet "
                "these readings without any effect: look again where the machine counts from before anything is said "
                "to lack."
            )
    return told


def untared(problem: Problem, found: Finding) -> list[str]:
    """Return by how much a load cell would be off its zero, throughout or farther with every reading of a test, where
    that is all the model misses forces by.

    Not where what was found does better: a sheet mounted taut is a little like either.
    """
    if not isinstance(problem, FilesProblem) or found.verdict == "noise":
        return []
    forces = np.concatenate([np.full(len(one.values), one.kind == "force") for one in problem.files])
    if not forces.any():
        return []
    throughout, drifting = np.zeros((2, len(problem.measured)))
    for name in {one.name for one in problem.files}:
        rows = problem.rows_of(name)
        rows = rows[forces[rows]]
        throughout[rows] = 1.0
        drifting[rows] = np.linspace(0.0, 1.0, len(rows))
    ways = [(one, *_off_zero(problem, found, one)) for one in (throughout, drifting)]
    read = np.flatnonzero(throughout)
    largest = 0.5 * float(np.max(np.abs(problem.measured[read])))
    meets = [
        (shape, offset)
        for shape, offset, freed in sorted(ways, key=lambda way: way[2].chi2)
        if _is_all(found, freed, read) and freed.chi2 <= found.after.fit.chi2 + MARGIN and abs(offset) <= largest
    ]
    if not meets:
        return []
    shape, offset = meets[0]
    off, way = f"{abs(offset):.3g} N", "high" if offset > 0.0 else "low"
    if shape is throughout:
        return [
            f"Were the load cell {off} too {way} throughout, the model would meet these readings without any effect: "
            "look at its zero before anything is said to lack."
        ]
    return [
        f"Were the load cell to drift, {off} too {way} at the last reading of a test, the model would meet these "
        "readings without any effect: read it unloaded after a test too before anything is said to lack."
    ]


def _off_zero(problem: Problem, found: Finding, shape: Array) -> tuple[float, Fit]:
    """Return the offset of a load cell, times ``shape`` (rows,), that suits the readings best, and the fit with it."""
    before = found.before.fit
    offset, freed = 0.0, before
    step = float(np.sqrt(np.mean((problem.measured - before.predicted)[shape != 0.0] ** 2)))
    for _ in range(_NEARER):
        last = freed
        freed = fit(problem, found.noise, {}, before.x, data=problem.measured - (offset + step) * shape)
        slope = (freed.residual - last.residual) / step
        offset += step
        step = -float(slope @ freed.residual) / max(float(slope @ slope), 1e-300)
        if abs(step) < 1e-3 * abs(offset):
            break
    return offset, freed


def _is_all(found: Finding, freed: Fit, read: Ints) -> bool:
    """Whether what the rows ``read`` are missed by is hardly there any more once a fit is freed: no more than what was
    found leaves, where that was taken for little."""
    beyond, after, left = (
        float(np.mean(one.residual[read] ** 2)) - 1.0 for one in (found.before.fit, found.after.fit, freed)
    )
    little = after if found.verdict != "unexplained" else 0.0
    return beyond > SMALL**2 and left <= max(SHARE * beyond, SMALL**2, little)


@dataclass(kw_only=True)
class _Late(FabricProblem):
    """Tests whose forces were all read late: the last of the own constants is by how many seconds."""

    def predict(self, own: Array, terms: Mapping[str, tuple[str, Array]]) -> Array:
        shown, late = super().predict(own, terms).copy(), float(own[-1])
        for curve in self.curves:
            if curve.channel == 0:
                clock = self.fabric.path.time_s[curve.rows]
                shown[curve.rows] = np.interp(clock - late, clock, shown[curve.rows])
        return shown


def late_force(problem: Problem, found: Finding) -> list[str]:
    """Return by how much the forces would be read later than the stretches, where that is most of what is missed by.

    A material that is lossy is stiffer on its way out, one whose force comes late is softer there, as if it gave work:
    nothing in the catalogue may be that. A stretch that is read late is a lossy material.
    """
    if not isinstance(problem, FabricProblem) or found.verdict != "unexplained":
        return []
    clocks = [problem.fabric.path.time_s[curve.rows] for curve in problem.curves if curve.channel == 0]
    if not all(np.all(np.isfinite(clock)) and np.all(np.diff(clock) > 0.0) for clock in clocks):
        return []
    most = _LATEST * min(float(np.ptp(clock)) for clock in clocks)
    late = Constant("force.late_s", 0.0, -most, most, 0.01 * most)
    timed, after = _Late.of(problem, [late]), found.after.fit
    start = np.concatenate([after.x[: after.own], [0.0], after.x[after.own :]])
    freed = fit(timed, found.noise, after.forms, start)
    seconds, sd = float(freed.x[after.own]), float(freed.sd[after.own])
    beyond, left = (float(np.mean(one.residual**2)) - 1.0 for one in (after, freed))
    if not TOLD * sd < seconds < most or left > max((1.0 - MOST) * beyond, SMALL**2):
        return []
    rms = [
        float(np.sqrt(np.mean((problem.measured - one.predicted)[problem.channel == 0] ** 2))) for one in (after, freed)
    ]
    return [
        f"Were the force read {seconds:.2g} s later than the stretch, the model would miss these readings by "
        f"{rms[1]:.3g} {problem.units[0]}, {rms[0]:.3g} as they are: look at the filter of the load cell's amplifier "
        "and at both clocks before anything is said to lack."
    ]
