"""What a worker does: run steps one after another, each in a folder of its own, and put the folder in place."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from pathlib import Path

from hyperfab.errors import OutputError
from hyperfab.studies.plan import HERE, STEPS, Step
from hyperfab.studies.store import Outcome, Store

#: Runs one command: (command, arguments, name of the document to write) -> how it ended.
Runner = Callable[[str, Sequence[str], str], Outcome]


def run_steps(folder: str, run: Runner, steps: Sequence[Step]) -> list[tuple[str, Outcome, float]]:
    """Run ``steps``; return the key of each, how it ended, and the seconds the command itself took.

    A step that is finished already is not run. After a failed write nothing more is tried: the disk is full for all.
    """
    store = Store(folder)
    found: list[tuple[str, Outcome, float]] = []
    for step in steps:
        outcome, seconds = run_step(store, run, step)
        found.append((step.key, outcome, seconds))
        if outcome.status == OutputError.exit_status:
            break
    return found


def run_step(store: Store, run: Runner, step: Step) -> tuple[Outcome, float]:
    """Run one step and put its folder in place; an outcome that is not kept leaves no folder."""
    known = store.outcome(step.key)
    if known is not None:
        return known, 0.0
    place: Path | None = None
    seconds = 0.0
    try:
        place = store.begin(step)
        for name, data in step.documents:
            (place / name).write_bytes(data)
        words = [word.replace(STEPS, str(store.steps)).replace(HERE, str(place)) for word in step.words]
        start = time.perf_counter()
        outcome = run(step.command, words, str(place / f"{step.name}.json"))
        seconds = time.perf_counter() - start
        if outcome.kept:
            outcome = _without_places(outcome, store, place)
            store.finish(step, place, outcome, seconds)
            place = None
        return outcome, seconds
    except OSError as error:
        return Outcome(OutputError.exit_status, f"{store.folder}: {error.strerror or error}"), seconds
    except OutputError as error:
        return Outcome(error.exit_status, str(error)), seconds
    finally:
        if place is not None:
            store.abandon(place)


def _without_places(outcome: Outcome, store: Store, place: Path) -> Outcome:
    """Take folders of this machine and this run out of messages: the same case tells the same everywhere."""

    def short(text: str) -> str:
        return text.replace(f"{place}/", "").replace(f"{store.steps}/", "steps/")

    return Outcome(outcome.status, short(outcome.message), tuple(short(text) for text in outcome.warnings))
