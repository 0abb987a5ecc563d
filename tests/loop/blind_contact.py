"""Blind trials of the sphere test: ``python -m loop.blind_contact [trials] [protocol] [effects]``."""

from __future__ import annotations

import json
import sys
import tempfile
from functools import cache
from pathlib import Path

import numpy as np
from loop.blind_press import table
from loop.generators import contact as truths

from hyperfab.chapters.close_loop.closing import close_rounds
from hyperfab.chapters.close_loop.contact import Forward, noise_of, pose, pose_sheet, read_material
from hyperfab.chapters.close_loop.recall import Recalled, recall
from hyperfab.chapters.close_loop.rerun import rerun
from hyperfab.chapters.job import Job
from hyperfab.cli.steps import chapter_words
from hyperfab.console import Console
from hyperfab.documents.base import parse_document
from hyperfab.documents.contact import ContactDocument
from hyperfab.documents.material import MaterialDocument
from hyperfab.loop.contact import ForceDepth, Sheet
from hyperfab.loop.engine import Finding


@cache
def model() -> tuple[Recalled, MaterialDocument, Sheet, Forward]:
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
    made = rerun(
        "fabric-contact", words, chapter_words("fabric-contact", [*words, "-o", f"{folder}/contact.json"])
    )
    data = made.document
    (folder / "contact.json").write_text(json.dumps(data))
    job = Job("close-loop", [], Console(True))
    recalled = recall(job, f"{folder}/contact.json", data, "contact", chapter_words)
    material = read_material(job, recalled)
    document = parse_document(data, "contact.json", ContactDocument)
    deepest = ForceDepth("", np.array([60.0]), np.array([0.0]))
    sheet = pose_sheet(job, recalled, document, material, [deepest], lambda share: None)
    return recalled, material, sheet, Forward(recalled, material)


def trial(effects: tuple[str, ...], seed: int, protocol: str) -> Finding:
    """Close the loop on one truth."""
    _, material, sheet, forward = model()
    random = np.random.default_rng([seed, sum(map(ord, "".join(effects)))])
    truth = truths.draw(random, effects, 0.06 if protocol == "poor" else 0.013)
    noise = 4.0 if protocol == "poor" else 1.0
    read = truths.measure(truth, random, noise, protocol)
    files = [(ForceDepth(f"{i}.csv", *one), None) for i, one in enumerate(read)]
    # Whoever has measured well also knows the fabric from its own tests.
    problem = pose(sheet, [one for one, _ in files], material, 0.10 if protocol == "poor" else 0.02, [])
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
