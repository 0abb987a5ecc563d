"""Markers that a net does not carry, and the same fabric as a membrane does: what lacks is how warp and weft couple."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from hyperfab.chapters.close_loop.describe import errors_of, evidence_of
from hyperfab.chapters.close_loop.domain import Given
from hyperfab.chapters.close_loop.drape import Forward, pose_sheet
from hyperfab.chapters.close_loop.finalise import Extension, Instead, Ticks, Traces, close_rounds
from hyperfab.chapters.close_loop.readings import Files
from hyperfab.chapters.validity import Ranges
from hyperfab.documents.loop import AddedEffect, LoopDocument
from hyperfab.errors import HyperfabError
from hyperfab.loop.drape import DrapeProblem, Markers, drape_problem
from hyperfab.loop.engine import Finding
from hyperfab.loop.fitting import fit
from hyperfab.loop.judge import Candidate
from hyperfab.loop.search import Search

#: What a membrane leaves, over what the net does with all that was added, where coupling is looked for.
_COUPLED = 0.8
COUPLING = "biaxial-coupling"


def membrane_of(forward: Forward) -> Forward:
    """Return the same fabric as a membrane."""
    job = replace(forward.job, ranges=Ranges())
    return Forward(job, replace(forward.case, sheet="membrane"), forward.material)


def misses(forward: Forward, problem: DrapeProblem, files: Sequence[Markers], found: Finding) -> float | None:
    """Return what the fabric's own law as a membrane leaves of the markers as it is (rms) [mm]; None where the net
    carries them, or leaves as little, or the membrane finds no rest; and where the sheet is no net of a known law.

    How warp and weft answer to each other has no amount that could be added to springs: it is another sheet.
    """
    if found.verdict != "unexplained" or forward.sheet.membrane is not None or forward.material is None:
        return None
    coupled = membrane_of(forward)
    try:
        places = coupled.nodes(np.ones(len(coupled.names)), {}, (forward.sheet.n, forward.sheet.m))
    except HyperfabError:
        return None
    posed = drape_problem(replace(problem.draped, base=places), files)
    rows = slice(posed.curves[-1].start)  # the last is what is known of the constants
    left = float(np.sqrt(np.mean((posed.measured - posed.delivered)[rows] ** 2)))
    net = float(np.sqrt(np.mean((found.after.fit.predicted - problem.measured)[rows] ** 2)))
    return left if left < _COUPLED * net else None


@dataclass
class InsteadOfNet:
    """Closes the loop on the same fabric as a membrane, where markers are not a net's but nearer to it.

    ``left`` is what ``misses`` found, once the net was tried; the others are what closing the loop takes.
    """

    forward: Forward
    files: Files[Markers]
    given: Given
    extend: Callable[[Forward, DrapeProblem, Finding], Extension]
    upstream: Callable[[Forward, DrapeProblem], Traces]
    left: float | None = None

    def closed(self, problem: DrapeProblem, found: Finding, tick: Ticks) -> Instead[DrapeProblem] | None:
        """Return the membrane that carries the markers, None where it does not either, or need not."""
        self.left = misses(self.forward, problem, self.files.measured, found)
        if self.left is None:
            return None
        coupled, files = membrane_of(self.forward), self.files
        draped = pose_sheet(coupled, lambda share: tick("the fabric as a membrane"))
        posed = drape_problem(draped, files.measured, prior=self.given.surely, fixed=self.given.case.fix)
        posed, other = close_rounds(posed, files.noise, coupled.corrected, tick, misses=files.misses)
        if other.verdict == "unexplained":
            return None
        own = found.before.fit.x[: found.before.fit.own]
        before = Candidate(problem, other.noise, fit(problem, other.noise, {}, own, iterations=0))
        gained = Search(posed, other.noise).evidence(before, other.after)
        verdict = "effect" if other.verdict == "noise" else other.verdict
        told = replace(other, verdict=verdict, before=before, added={COUPLING: gained, **other.added})
        return Instead(
            posed,
            told,
            lambda finding: self.extend(coupled, posed, finding),
            self.upstream(coupled, posed),
            lambda result: _tell(result, problem, posed, told),
        )

    def said(self, found: Finding) -> list[str]:
        """Return what is to be said of the membrane where neither it nor the net leaves noise."""
        if self.left is None or found.verdict != "unexplained":
            return []
        return [
            f"As a membrane, its law coupling warp and weft, the same fabric misses by {self.left:.3g} mm as it is: "
            f"{COUPLING} is lacking. Drape it with --sheet membrane, and close the loop on that."
        ]


def _tell(result: LoopDocument, net: DrapeProblem, posed: DrapeProblem, found: Finding) -> None:
    """Say of a finding on a membrane that it stands for a net: with coupling as the first that is added."""
    effect, evidence = posed.effect(COUPLING), evidence_of(found, COUPLING)
    coupling = AddedEffect(
        id=COUPLING, title=effect.title, form="membrane", source=effect.source, parameters={}, evidence=evidence
    )
    result.effects.insert(0, coupling)
    for row in result.candidates:
        if row.id == COUPLING:
            row.not_sought = None
    first = net.channel == 0
    delivered = net.delivered[first]
    sd = found.noise.sd[first]
    result.error.delivered = errors_of(net.measured[first], delivered, delivered, sd, net.units[0]).before
