"""A model with some terms, fitted and judged, and the evidence for a term."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

from hyperfab.loop.fitting import Fit
from hyperfab.loop.heldout import Forecast, HeldOut, Help, forecast, leave_curves_out
from hyperfab.loop.judge import Judgement, judge
from hyperfab.loop.noise import Noise
from hyperfab.loop.problem import Problem
from hyperfab.loop.score import Signature, signatures
from hyperfab.loop.thresholds import MARGIN, MOST, SHARE


@dataclass
class Candidate:
    """A model with some terms, fitted; judged when asked."""

    problem: Problem
    noise: Noise
    fit: Fit
    #: The noise it was fitted under, where that is another.
    under: Noise | None = None

    @cached_property
    def found(self) -> list[Signature]:
        """What the entries that are not in the model would do to its prediction."""
        others = [
            effect for effect in self.problem.effects if effect.id not in self.fit.forms and not effect.not_sought
        ]
        return signatures(self.problem, self.noise, self.fit, others)

    @cached_property
    def judgement(self) -> Judgement:
        """Whether what is left is noise."""
        return judge(self.problem, self.noise, self.fit, self.found)

    @cached_property
    def held_out(self) -> HeldOut:
        """Each test predicted from the others."""
        return leave_curves_out(self.fit, self.problem.curves)

    @cached_property
    def forecast(self) -> Forecast:
        """Each test predicted by a fit to the others."""
        return forecast(self.problem, self.under or self.noise, self.fit)

    @property
    def excess(self) -> float:
        """Mean square of what is left, in squared standard deviations of the noise."""
        return self.fit.chi2 / max(len(self.fit.residual) - len(self.fit.x), 1)

    @property
    def ids(self) -> tuple[str, ...]:
        """The effects in it, in the order they were added."""
        return tuple(self.fit.forms)


@dataclass(frozen=True)
class Evidence:
    """Why a term was added, or not.

    ``restores``: it leaves noise, and brings the constants back to what is known of them beforehand by more than the
    margin. Readings that are predicted as well without it then say nothing against it.
    """

    delta_bic: float
    variance_share: float
    help: Help | None
    certain: bool
    restores: bool = False

    def accepted(self) -> bool:
        """Whether the term pays, and helps most of the tests that can tell, or takes most of what they miss by."""
        if self.help is None or self.restores:
            return self.pays()
        return self.pays() and max(self.help.helped, self.help.taken) >= MOST

    def foretells(self) -> bool:
        """Whether the term takes its share of what lacks, on most of the tests left out too, if by little in BIC."""
        helps = self.help is not None and self.help.helped >= MOST and self.help.taken >= SHARE
        return helps and self.certain and self.delta_bic > 0.0 and self.variance_share >= SHARE

    def pays(self) -> bool:
        """Whether the term is worth its constants: in likelihood, in size, and on tests left out."""
        pays = self.delta_bic >= MARGIN and self.variance_share >= SHARE and self.certain
        return pays and (self.help is None or self.restores or self.help.taken >= SHARE)
