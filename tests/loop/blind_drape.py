"""Blind trials of the drape: ``python -m loop.blind_drape [trials] [protocol] [effects]``."""

from __future__ import annotations

import sys
import tempfile
from functools import cache
from pathlib import Path

import numpy as np
from loop.blind_press import table
from loop.generators import drape as truths

from hyperfab.chapters.close_loop.closing import close_rounds
from hyperfab.chapters.close_loop.drape import Forward, noise_of, pose, pose_sheet
from hyperfab.chapters.close_loop.recall import recall
from hyperfab.chapters.close_loop.rerun import rerun
from hyperfab.chapters.job import Job
from hyperfab.cli.steps import chapter_words
from hyperfab.console import Console
from hyperfab.io.json_io import dump_json
from hyperfab.loop.drape import Draped, Markers
from hyperfab.loop.engine import Finding


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
    made = rerun("drape", words, chapter_words("drape", [*words, "-o", name, "--quiet"]))
    Path(name).write_bytes(dump_json(made.document))
    return name


@cache
def model() -> tuple[Draped, Forward]:
    """Return the sheet as its document has it, emulated once for all trials."""
    from hyperfab.io.json_io import load_json

    name = document(Path(tempfile.mkdtemp()))
    job = Job("close-loop", [], Console(True))
    data = load_json(Path(name).read_bytes(), name)
    forward = Forward(recall(job, name, data, "drape", chapter_words), None)
    return pose_sheet(forward, lambda share: None), forward


def trial(effects: tuple[str, ...], seed: int, protocol: str) -> Finding:
    """Close the loop on one truth."""
    draped, forward = model()
    random = np.random.default_rng([seed, sum(map(ord, "".join(effects)))])
    truth = truths.draw(random, effects)
    flat, found = truths.measure(truth, random, 0.03 if protocol == "rich" else 0.06, protocol)
    files = [(Markers("markers.csv", flat, found), None)]
    problem = pose(draped, [one for one, _ in files], 0.10, [])
    return close_rounds(problem, noise_of(files, None), forward.corrected, design=False)[1]


def main() -> None:
    """Print the tables."""
    trials = int(sys.argv[1]) if len(sys.argv) > 1 else 8
    protocol = sys.argv[2] if len(sys.argv) > 2 else "rich"
    only = sys.argv[3:] or [*truths.IDS, "none"]
    for word in only:
        table(trial, tuple(part for part in word.split("+") if part != "none"), trials, protocol)


if __name__ == "__main__":
    main()
