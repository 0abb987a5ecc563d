"""Blind trials of heated molds: ``python -m loop.blind_heat [trials] [protocol] [effects]``.

Protocols: ``rich``, the first mold; ``other``, the second, whose effects come in kinds of their own; ``poor``, the
second with its plate's two probes and a heat-up alone.
"""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

import numpy as np
from loop.generators import heat as truths
from loop.generators import other_heat
from loop.trials import Case, Trials, main

from hyperfab.arrays import Array
from hyperfab.chapters.close_loop import heat
from hyperfab.chapters.job import Job
from hyperfab.chapters.mold_heat.problem import MoldBuilder
from hyperfab.console import Console
from hyperfab.documents.base import parse_document
from hyperfab.documents.mold import MoldDocument
from hyperfab.io.toml_io import load_toml
from hyperfab.loop.design import NextMeasurement
from hyperfab.loop.heat import HeatProblem, Run, heat_problem
from hyperfab.loop.noise_estimate import estimate_noise
from hyperfab.loop.problem import Problem
from hyperfab.loop.thresholds import PRIOR

#: Standard deviation of a reading [K], and readings of a probe.
NOISE, ROWS = 0.3, 200
#: A reading is never finer than this [K]: below, finite volumes and elements differ by more than it.
_FINEST = 0.1
#: An effect is drawn larger up to this size; beyond, some laws of the generators lose their sense.
_LARGEST = 2.0
PAIRS = (
    "radiation+sensor-lag", "contact-resistance+ambient-drift", "base-conduction+property-drift",
    "power-loss+sensor-lag",
)  # fmt: skip


@dataclass(frozen=True)
class Mold:
    """A mold as its document has it, reduced once: its own constants with their kinds, joints and probes."""

    problem: HeatProblem
    own: Sequence[tuple[str, str]]
    names: Sequence[str]


@cache
def mold(protocol: str) -> Mold:
    """Return the mold of a protocol."""
    poor = protocol == "poor"
    text, power = truths.mold_toml() if protocol == "rich" else other_heat.mold_toml(poor)
    duration = truths.DURATION if protocol == "rich" else other_heat.DURATION
    folder = Path(tempfile.mkdtemp())
    (folder / "power.csv").write_text(power)
    name = str(folder / "mold.toml")
    document = parse_document(load_toml(text.encode(), name), name, MoldDocument)
    names = ["T1", "T2", "T3", "T4"][: 2 if poor else 4]
    empty = heat.Thermocouples(np.linspace(0.0, duration, ROWS), np.full((ROWS, len(names)), 20.0), names)
    job = Job("close-loop", [], Console(True))
    posed = heat.pose(MoldBuilder(document, name, job.inputs), empty, [], PRIOR)
    own = [(constant.name, kind) for constant, kind in zip(posed.own, posed.kinds, strict=True)]
    return Mold(posed, own, names)


def measured(
    truth: truths.Truth | other_heat.Truth, noise: float, protocol: str, seed: Sequence[int]
) -> tuple[Array, Array]:
    """Return times and readings of a truth."""
    random = np.random.default_rng(seed)
    if isinstance(truth, other_heat.Truth):
        return other_heat.measure(truth, random, noise, ROWS, protocol == "poor")
    return truths.measure(truth, random, noise, ROWS)


def posed(truth: truths.Truth | other_heat.Truth, noise: float, protocol: str, seed: int) -> Case:
    """Return the case of a truth."""
    one = mold(protocol)
    reduced = one.problem.runs[0].mold
    times, readings = measured(truth, noise, protocol, [seed, 7])
    problem = heat_problem(
        reduced,
        times,
        readings,
        one.names,
        one.own,
        list(one.problem.joints),
        PRIOR,
    )

    def again(what: NextMeasurement | None) -> Case:
        wider: Problem
        if what is None:
            _, more = measured(truth, noise, protocol, [seed, 8])
            rows = len(problem.measured)
            wider = replace(
                problem,
                runs=[*problem.runs, Run.whole(reduced, times)],
                curves=(
                    *problem.curves,
                    *(replace(c, start=c.start + rows, stop=c.stop + rows) for c in problem.curves),
                ),
                states={},
            )
        else:
            wider = next(extra.problem for extra in problem.extras() if extra.text == what.text)
            top = 4.0 * max(float(np.max(table.y)) for _, table in reduced.heaters)
            program = other_heat.Program(
                np.array(what.details["time_s"]),
                top * np.array(what.details["power_share"]),
                bool(what.details["probe_in_each_part"]),
            )
            assert isinstance(truth, other_heat.Truth)
            _, more = other_heat.measure(
                truth, np.random.default_rng([seed, 8]), noise, ROWS, protocol == "poor", program
            )
        wider = replace(wider, measured=np.concatenate([problem.measured, more.T.ravel()]))
        return Case(wider, lambda problem, left: estimate_noise(problem), np.full(len(wider.measured), noise))

    return Case(
        problem,
        lambda problem, left: estimate_noise(problem),
        np.full(len(problem.measured), noise),
        next=None if protocol == "rich" else again,
    )


def case(effects: tuple[str, ...], seed: int, protocol: str, larger: float, finer: float) -> Case:
    """Return the case of a seed."""
    random = np.random.default_rng([seed, len(effects)])
    truth: truths.Truth | other_heat.Truth
    if protocol == "rich":
        truth = truths.draw(random, effects)
    else:
        truth = other_heat.draw(random, effects, seed if len(effects) == 1 else None)
    truth = replace(truth, size={name: min(larger * size, _LARGEST) for name, size in truth.size.items()})
    return posed(truth, max(finer * NOISE, _FINEST), protocol, seed)


TRIALS = Trials(ids=truths.IDS, pairs=PAIRS, outside=other_heat.OUTSIDE, case=case, poor=truths.IDS)

if __name__ == "__main__":
    sys.exit(main(TRIALS))
