"""Blind trials of the press: ``python -m loop.blind_press [trials] [protocol] [effects]``."""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Sequence
from functools import cache
from itertools import combinations
from pathlib import Path

import numpy as np
from loop.generators import press as truths
from loop.trials import Case, Trials, main

from hyperfab.cases.options import read
from hyperfab.cases.press import PressCase
from hyperfab.chapters.close_loop.press import closed_press, pose
from hyperfab.chapters.close_loop.readings import Files
from hyperfab.chapters.job import Job
from hyperfab.chapters.press_contact.result import PressResult
from hyperfab.console import Console
from hyperfab.loop.design import NextMeasurement
from hyperfab.loop.press_reading import Reading


@cache
def told(more: str = "", options: tuple[str, ...] = (), foam: str = truths.FOAM_TOML) -> PressResult:
    """The press as its document has it; with ``more`` lines of foam.toml, or with its own ``options`` for the gap."""
    folder = Path(tempfile.mkdtemp())
    for which in ("male", "female"):
        (folder / f"{which}.stl").write_bytes(truths.stl(which))
    (folder / "foam.toml").write_text(foam + more)
    words = [
        "--male",
        f"{folder}/male.stl",
        "--female",
        f"{folder}/female.stl",
        "--foam",
        f"{folder}/foam.toml",
    ]
    words += options or ("--gap", f"{truths.GAP}mm")
    return closed_press(Job("press-contact", [], Console(True)), read(PressCase, words))[0]


#: A press whose molds are hot and do not grow.
HOT = (
    'expansion = { male = "0 1/K", female = "0 1/K" }\n',
    ("--gap", f"{truths.GAP}mm", "--temperature", f"{truths.HOT_DEGC}degC"),
)


def as_readings(read: Sequence[truths.Read]) -> list[Reading]:
    """Return the readings as the loop takes them: nothing of the truth goes along."""
    return [
        Reading(
            f"{i}.csv",
            one.kind,
            one.values,
            places=one.places,
            stroke=one.stroke,
            time_s=one.time,  # type: ignore[arg-type]
            load=one.load,
            temperature=one.temperature,
        )
        for i, one in enumerate(read)
    ]


def posed(truth: truths.Truth, noise: float, protocols: Sequence[str], seed: int) -> Case:
    """Return the case of a truth read by one protocol after the other."""
    read = [
        one
        for number, protocol in enumerate(protocols)
        for one in truths.measure(truth, np.random.default_rng([seed, number, 1]), noise, protocol)
    ]
    files = as_readings(read)
    model = told(*HOT) if protocols[0] == "hot" else told()
    problem = pose(model, files, 0.10, [])[0]
    loud = {one.name: noise * truths.sd_of(kind) for one, kind in zip(files, read, strict=True)}
    sd = np.ones(len(problem.measured))
    for part, curve in zip(problem.files, problem.curves, strict=False):
        sd[curve.rows] = loud[part.name]

    def again(what: NextMeasurement | None) -> Case:
        kind = protocols[-1] if what is None else f"next {what.details['reading']}"
        if what is not None and "temperature_degC" in what.details:
            kind = "next cold"
        return posed(truth, noise, [*protocols, kind], seed)

    return Case(problem, Files(list(files)).noise, sd, next=again)


def case(effects: tuple[str, ...], seed: int, protocol: str, larger: float, finer: float) -> Case:
    """Return the case of a seed."""
    random = np.random.default_rng([seed, sum(map(ord, "".join(effects)))])
    truth = truths.draw(random, effects, larger)
    return posed(truth, finer, [protocol], seed)


TRIALS = Trials(
    ids=truths.IDS,
    pairs=tuple("+".join(pair) for pair in combinations(truths.IDS, 2)),
    outside=truths.OUTSIDE,
    case=case,
    poor=truths.IDS,
)

if __name__ == "__main__":
    sys.exit(main(TRIALS))
