"""Blind trials of the drape: ``python -m loop.blind_drape [trials] [protocol] [effects]``."""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Sequence
from functools import cache
from pathlib import Path

import numpy as np
from loop.generators import drape as truths
from loop.trials import Case, Trials, main

from hyperfab.cases.drape import DrapeCase
from hyperfab.cases.like import earlier
from hyperfab.cases.options import read
from hyperfab.chapters.close_loop.drape import Forward, pose_sheet
from hyperfab.chapters.close_loop.readings import Files
from hyperfab.chapters.job import Job
from hyperfab.chapters.rerun import rerun
from hyperfab.console import Console
from hyperfab.io.json_io import dump_json
from hyperfab.loop.design import NextMeasurement
from hyperfab.loop.drape import Draped, Markers, drape_problem


def document(folder: Path) -> str:
    """Write the model's files and its document; return the document's name."""
    (folder / "ball.stl").write_bytes(truths.ball_stl())
    (folder / "warp.csv").write_text(truths.thread_csv(truths.WARP))
    (folder / "weft.csv").write_text(truths.thread_csv(truths.WEFT))
    side, n = truths.SIDE, truths.NODES
    words = ["--mold", f"{folder}/ball.stl", "--warp", f"{folder}/warp.csv", "--weft", f"{folder}/weft.csv"]
    words += ["--grid", f"{n}x{n}", "--size", f"{side}mmx{side}mm", "--depth", f"{truths.DEPTH}mm"]
    words += ["--thickness", f"{truths.THICK}mm"]
    name = str(folder / "drape.json")
    made = rerun(read(DrapeCase, words), name)
    Path(name).write_bytes(dump_json(made.document))
    return name


@cache
def model() -> tuple[Draped, Forward]:
    """Return the sheet as its document has it, emulated once for all trials."""
    from hyperfab.io.json_io import load_json

    name = document(Path(tempfile.mkdtemp()))
    job = Job("close-loop", [], Console(True))
    data = load_json(Path(name).read_bytes(), name)
    forward = Forward(job, earlier(DrapeCase, data, name).case, None)
    return pose_sheet(forward, lambda share: None), forward


def posed(truth: truths.Truth, noise: float, protocols: Sequence[str], seed: int) -> Case:
    """Return the case of a truth with markers of one protocol after the other."""
    draped, forward = model()
    files = [
        Markers(f"{number}.csv", *truths.measure(truth, np.random.default_rng([seed, number, 1]), noise, protocol))
        for number, protocol in enumerate(protocols)
    ]
    problem = drape_problem(draped, files)
    sd = np.ones(len(problem.measured))
    sd[: 3 * sum(len(one.flat) for one in files)] = noise

    def again(what: NextMeasurement | None) -> Case:
        kind = protocols[-1] if what is None else next(key for word, key in _NEXT.items() if word in what.text)
        return posed(truth, noise, [*protocols, kind], seed)

    return Case(problem, Files(list(files)).noise, sd, forward.corrected, again)


#: What the next measurements are in the generator's words.
_NEXT = {"all over": "all", "hangs free": "free", "on the top": "top"}


def case(effects: tuple[str, ...], seed: int, protocol: str, larger: float, finer: float) -> Case:
    """Return the case of a seed."""
    random = np.random.default_rng([seed, sum(map(ord, "".join(effects)))])
    truth = truths.draw(random, effects, larger)
    return posed(truth, finer * (0.03 if protocol == "rich" else 0.06), [protocol], seed)


TRIALS = Trials(
    ids=truths.IDS,
    pairs=(
        "pretension+gravity",
        "shear-stiffness+gravity",
        "friction+pretension",
        "shear-stiffness+pretension",
    ),
    outside=truths.OUTSIDE,
    case=case,
    poor=truths.IDS,
)

if __name__ == "__main__":
    sys.exit(main(TRIALS))
