"""What blind trials of molds, presses and sheets have in common: a truth worth naming, its verdict, what comes next."""

from __future__ import annotations

import argparse
import time
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
from loop.blind import in_answer, label

from hyperfab.arrays import Array
from hyperfab.chapters.close_loop.finalise import close_rounds
from hyperfab.loop.design import NextMeasurement
from hyperfab.loop.engine import Finding
from hyperfab.loop.fitting import fit
from hyperfab.loop.noise import Noise
from hyperfab.loop.problem import Problem

#: An effect is worth naming where it raises the rms to this many times the noise, the own constants refitted.
WORTH = 1.5
#: Draws of a truth: each is larger, and read more closely, than the one before.
_DRAWS, _LARGER, _FINER = 12, 1.15, 0.87


@dataclass(frozen=True)
class Case:
    """A problem as an engineer would pose it, what tells its noise, and how it is posed anew around a finding.

    ``sd`` is the true noise of its rows. ``next`` carries out the next measurement, or repeats the old one where
    none is given, and returns the case with that.
    """

    problem: Problem
    noise: Callable[[Problem, Array | None], Noise]
    sd: Array
    rounds: Callable[[Problem, Finding], Problem | None] = lambda problem, found: None
    next: Callable[[NextMeasurement | None], Case] | None = None


@dataclass(frozen=True)
class Trials:
    """The trials of a domain: ``case`` poses effects for a seed and protocol, sizes times one, noise times another."""

    ids: Sequence[str]
    pairs: Sequence[str]
    outside: Sequence[str]
    case: Callable[[tuple[str, ...], int, str, float, float], Case]
    poor: Sequence[str] = field(default_factory=tuple)


def worth(case: Case) -> float:
    """Return the rms over the true noise that the best own constants leave, what is known of them counted."""
    start = [one.value for one in case.problem.own]
    base = fit(case.problem, Noise(case.sd, np.inf, "known"), {}, start)
    return float(np.sqrt(base.chi2 / (len(base.residual) - len(start))))


def drawn(trials: Trials, effects: tuple[str, ...], seed: int, protocol: str) -> tuple[Case, float]:
    """Return a case whose effects, each alone, are worth naming: larger ones, read more closely, until they are."""
    larger, finer = 1.0, 1.0
    for _ in range(_DRAWS):
        alone = [worth(trials.case((name,), seed, protocol, larger, finer)) for name in effects]
        if not alone or min(alone) >= WORTH:
            break
        larger, finer = larger * _LARGER, finer * _FINER
    return trials.case(effects, seed, protocol, larger, finer), min(alone, default=1.0)


def table(trials: Trials, truth: tuple[str, ...], seeds: Sequence[int], protocol: str, follow: bool) -> None:
    """Run trials of one truth, print each and their sums; ``follow`` carries out the next measurement."""
    tally: Counter[str] = Counter()
    for seed in seeds:
        case, size = drawn(trials, truth, seed, protocol)
        began = time.process_time()
        _, found = close_rounds(case.problem, case.noise, case.rounds, design=follow)
        took = time.process_time() - began
        named = found.verdict in ("effect", "ambiguous")
        before, left = found.before.judgement.structured, found.after.judgement.structured
        tally["alone"] += found.verdict == "effect" and set(found.after.ids) == set(truth)
        tally["right or in the set"] += named and all(in_answer(name, found) for name in truth)
        if truth and size >= WORTH:
            tally["worth naming"] += 1
            tally["of these right or in the set"] += named and all(in_answer(name, found) for name in truth)
        tally["one right"] += named and any(in_answer(name, found) for name in truth)
        for verdict in ("noise", "unexplained", "ambiguous"):
            tally[verdict] += found.verdict == verdict
        # What no truth nor a look-alike of one stands behind.
        tally["spurious"] += named and any(
            name not in truth and not any(name in one and set(one) & set(truth) for one in found.indistinguishable)
            for name in found.after.ids
        )
        tally["held out <= 1.2"] += bool(np.nanmean(found.after.held_out.residual**2) <= 1.44)
        told = label(found)
        if follow and found.verdict == "ambiguous" and found.measurements and case.next is not None:
            for key, what in (("next", found.measurements[0]), ("repeated", None)):
                again = case.next(what)
                _, then = close_rounds(again.problem, again.noise, again.rounds, design=False)
                first = then.verdict in ("effect", "ambiguous") and set(then.after.ids) <= set(truth)
                tally[f"{key}: truth first"] += first
                tally[f"{key}: truth alone"] += first and then.verdict == "effect"
                told += f" | {key}: {label(then)}"
        print(
            f"  {seed:3d} {'+'.join(truth) or 'none':24s} worth {size:4.1f} {told:60s} {before:.2f}, {left:.2f}; "
            f"{took:.0f} s",
            flush=True,
        )
    print(
        f"{'+'.join(truth) or 'none'} {protocol} of {len(seeds)}: "
        + ", ".join(f"{key} {value}" for key, value in tally.items()),
        flush=True,
    )


def main(trials: Trials) -> None:
    """Print the tables that the command line asks for."""
    parser = argparse.ArgumentParser()
    parser.add_argument("count", type=int, nargs="?", default=8)
    parser.add_argument("protocol", nargs="?", default="rich")
    parser.add_argument("effects", nargs="*", help="effect, effect+effect or none; all of one where not given")
    parser.add_argument("--two", action="store_true", help="pairs of effects")
    parser.add_argument("--outside", action="store_true", help="what the catalogue does not have")
    parser.add_argument("--next", action="store_true", help="carry out the next measurement")
    parser.add_argument("--first", type=int, default=0, help="the first seed")
    given = parser.parse_args()
    usual = [*(trials.ids if given.protocol in ("rich", "usual", "share") else trials.poor), "none"]
    words = given.effects or (trials.pairs if given.two else trials.outside if given.outside else usual)
    for word in words:
        truth = tuple(part for part in word.split("+") if part != "none")
        table(trials, truth, range(given.first, given.first + given.count), given.protocol, given.next)
