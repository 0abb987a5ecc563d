"""Blind trials of the sphere test: ``python -m loop.blind_contact [trials] [protocol] [effects]``."""

from __future__ import annotations

import json
import sys
import tempfile
from collections.abc import Sequence
from functools import cache
from itertools import combinations
from pathlib import Path

import numpy as np
from loop.generators import contact as truths
from loop.trials import Case, Trials, main

from hyperfab.cases.contact import ContactCase
from hyperfab.cases.like import earlier
from hyperfab.cases.options import read
from hyperfab.chapters.close_loop.contact import Forward, pose, pose_sheet
from hyperfab.chapters.close_loop.readings import Files
from hyperfab.chapters.job import Job
from hyperfab.chapters.rerun import rerun
from hyperfab.console import Console
from hyperfab.documents.base import parse_document, read_document
from hyperfab.documents.contact import ContactDocument
from hyperfab.documents.material import MaterialDocument
from hyperfab.loop.contact import ForceDepth, Sheet
from hyperfab.loop.design import NextMeasurement


@cache
def model() -> tuple[MaterialDocument, Sheet, Forward]:
    """Return the sheet as its document has it, emulated once for all trials."""
    folder = Path(tempfile.mkdtemp())
    fabric = {
        "format": "hyperfab.material/1",
        "model": "yeoh-2",
        "parameters": {"C10_MPa": truths.C10, "C20_MPa": truths.C20},
        "thickness_mm": truths.THICK,
        "temperature_degC": truths.ROOM,
    }
    (folder / "fabric.json").write_text(json.dumps(fabric))
    words = [
        f"{folder}/fabric.json",
        "--sphere-radius",
        f"{truths.SPHERE}mm",
        "--depth",
        "60mm",
        "--steps",
        "6",
    ]
    name = f"{folder}/contact.json"
    data = rerun(read(ContactCase, words), name).document
    Path(name).write_text(json.dumps(data))
    asked = earlier(ContactCase, data, name).case
    job = Job("close-loop", [], Console(True))
    material = read_document(job.inputs, asked.material, MaterialDocument)
    document = parse_document(data, "contact.json", ContactDocument)
    deepest = ForceDepth("", np.array([60.0]), np.array([0.0]))
    forward = Forward(job, asked, material)
    return material, pose_sheet(forward, document, [deepest], lambda share: None), forward


def posed(truth: truths.Truth, noise: float, protocols: Sequence[str], seed: int, prior: float) -> Case:
    """Return the case of a truth read by one protocol after the other."""
    material, sheet, forward = model()
    files, loud = [], []
    for number, protocol in enumerate(protocols):
        random = np.random.default_rng([seed, number, 1])
        for depth, force, temperature in truths.measure(truth, random, noise, protocol):
            coefficient = 0.0 if protocol == "oiled" else None
            files.append(ForceDepth(f"{len(files)}.csv", depth, force, temperature, friction=coefficient))
            finer = 0.1 / 0.2 if protocol == "begin" else 1.0
            even = np.full(len(depth), 0.002 * noise * finer * float(force.max()))
            loud.append(0.01 * noise * np.abs(force) if protocol == "share" else even)
    problem = pose(sheet, files, material, prior, [])
    sd = np.ones(len(problem.measured))
    sd[: sum(map(len, loud))] = np.concatenate(loud)

    def again(what: NextMeasurement | None) -> Case:
        kind = protocols[-1] if what is None else next(key for word, key in _NEXT.items() if word in what.text)
        return posed(truth, noise, [*protocols, kind], seed, prior)

    return Case(problem, Files(list(files)).noise, sd, forward.corrected, again)


#: What the next measurements are in the generator's words.
_NEXT = {"warmer": "warm", "first fifth": "begin", "five times": "often", "oiled": "oiled"}


def case(effects: tuple[str, ...], seed: int, protocol: str, larger: float, finer: float) -> Case:
    """Return the case of a seed."""
    random = np.random.default_rng([seed, sum(map(ord, "".join(effects)))])
    poor, usual = protocol == "poor", protocol in ("usual", "share")
    # Whoever has measured well often knows the fabric from its own tests, but not always.
    known = 0.10 if poor or usual else 0.02
    truth = truths.draw(random, effects, 0.65 * known, larger)
    return posed(truth, finer * (4.0 if poor else 1.0), ["rich" if protocol == "usual" else protocol], seed, known)


TRIALS = Trials(
    ids=truths.IDS,
    pairs=tuple("+".join(pair) for pair in combinations(truths.IDS, 2)),
    outside=truths.OUTSIDE,
    case=case,
    poor=("friction", "pretension", "rim-slip"),
)

if __name__ == "__main__":
    sys.exit(main(TRIALS))
