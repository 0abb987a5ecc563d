"""Blind trials of the press: ``python -m loop.blind_press [trials] [protocol] [effects]``."""

from __future__ import annotations

import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable
from functools import cache
from pathlib import Path

import numpy as np
from loop.blind import in_answer, label
from loop.generators import press as truths

from hyperfab.chapters.close_loop.closing import close_anew
from hyperfab.chapters.close_loop.press import noise_of, pose
from hyperfab.chapters.close_loop.rerun import rerun
from hyperfab.chapters.press_contact.result import Told
from hyperfab.cli.steps import chapter_words
from hyperfab.loop.engine import Finding
from hyperfab.loop.press import Reading


@cache
def told() -> Told:
    """The press as its document has it."""
    folder = Path(tempfile.mkdtemp())
    for which in ("male", "female"):
        (folder / f"{which}.stl").write_bytes(truths.stl(which))
    (folder / "foam.toml").write_text(truths.FOAM_TOML)
    words = [
        "--male",
        f"{folder}/male.stl",
        "--female",
        f"{folder}/female.stl",
        "--foam",
        f"{folder}/foam.toml",
    ]
    words += ["--gap", f"{truths.GAP}mm"]
    made = rerun("press-contact", words, chapter_words("press-contact", [*words, "-o", "-"]))
    found = made.kept[-1]
    assert isinstance(found, Told)
    return found


def readings(truth: truths.Truth, random: np.random.Generator, noise: float, protocol: str) -> list[Reading]:
    """Return the readings as the loop takes them."""
    return [
        Reading(f"{i}.csv", one.kind, one.values, places=one.places, stroke=one.stroke, time_s=one.time)
        for i, one in enumerate(truths.measure(truth, random, noise, protocol))
    ]


def trial(effects: tuple[str, ...], seed: int, protocol: str) -> Finding:
    """Close the loop on one truth."""
    random = np.random.default_rng([seed, sum(map(ord, "".join(effects)))])
    truth = truths.draw(random, effects)
    files = [(one, None) for one in readings(truth, random, 1.0, protocol)]
    problem = pose(told(), files, 0.10, [])
    return close_anew(problem, noise_of(files), design=False)


def table(
    run: Callable[[tuple[str, ...], int, str], Finding],
    truth: tuple[str, ...],
    trials: int,
    protocol: str,
) -> None:
    """Run trials of one truth, print each and their sums."""
    tally: Counter[str] = Counter()
    for seed in range(trials):
        began = time.perf_counter()
        found = run(truth, seed, protocol)
        named = found.verdict in ("effect", "ambiguous")
        before, left = found.before.judgement.structured, found.after.judgement.structured
        tally["alone"] += found.verdict == "effect" and set(found.after.ids) == set(truth)
        tally["right or in the set"] += named and all(in_answer(name, found) for name in truth)
        tally["one right"] += named and any(in_answer(name, found) for name in truth)
        tally["noise"] += found.verdict == "noise"
        tally["unexplained"] += found.verdict == "unexplained"
        tally["spurious"] += named and any(
            name not in truth
            and not any(name in one and set(one) & set(truth) for one in found.indistinguishable)
            for name in found.after.ids
        )
        print(
            f"  {seed:3d} {'+'.join(truth) or 'none':24s} {label(found):60s} {before:.2f}, {left:.2f}; "
            f"{time.perf_counter() - began:.0f} s",
            flush=True,
        )
    print(
        f"{'+'.join(truth) or 'none'} {protocol} of {trials}: "
        + ", ".join(f"{k} {v}" for k, v in tally.items()),
        flush=True,
    )


def main() -> None:
    """Print the tables."""
    trials = int(sys.argv[1]) if len(sys.argv) > 1 else 8
    protocol = sys.argv[2] if len(sys.argv) > 2 else "rich"
    only = sys.argv[3:] or [*truths.IDS, "none"]
    for word in only:
        table(trial, tuple(part for part in word.split("+") if part != "none"), trials, protocol)


if __name__ == "__main__":
    main()
