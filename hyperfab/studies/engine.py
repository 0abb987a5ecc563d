"""The engine: keeps workers busy with the steps that are ready, on a Dask cluster.

The driver holds little: a few batches in flight, the steps that wait for them, and the status of what is done.
Results never pass through it: a worker puts each finished step in its place in the study's folder, so a lost
worker or driver loses only what was under way.
"""

from __future__ import annotations

import queue
import time
from collections import Counter, deque
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from hyperfab.errors import InputError, OutputError
from hyperfab.studies.plan import HERE, STEPS, Case, Step
from hyperfab.studies.store import CHANGED, Outcome, Store

#: A batch is sized to take about this long, so that the cost of sending it is small beside it.
BATCH_S = 0.2
MAX_BATCH = 100
#: Steps a driver looks ahead: bounds its memory, whatever the size of the study.
AHEAD = 2000
#: The status of a step that took its worker with it, as a shell tells it of a killed command.
DIED = 137


@dataclass
class Progress:
    """How far a run has come: steps run, found finished, not run for want of an earlier one."""

    run: int = 0
    reused: int = 0
    skipped: int = 0


@dataclass(eq=False)
class Engine:
    """Runs the steps of cases; one object a run.

    Without a client it only takes stock of what is finished.
    ``again`` says of a finished outcome whether to run its step anew; ``tell`` is called about once a second.
    """

    client: Any | None
    store: Store
    runner: Runner
    tell: Callable[[Progress], None]
    again: Callable[[Outcome], bool]

    def __post_init__(self) -> None:
        self.progress = Progress()
        #: Outcomes that were not kept in the folder: accidents, which the next run tries again.
        self.accidents: dict[str, Outcome] = {}
        self._builds: dict[str, bool] = {}  # finished steps: whether later ones can build on them
        self._known: set[str] = set()
        self._ready: deque[Step] = deque()
        self._waiting: dict[str, list[Step]] = {}
        self._missing: Counter[str] = Counter()  # how many needs a waiting step still has
        self._deaths: Counter[str] = Counter()
        self._flying: dict[str, tuple[Any, list[Step]]] = {}
        self._arrived: queue.SimpleQueue[Any] = queue.SimpleQueue()
        self._mean = BATCH_S
        self._batches = 0

    def run(self, cases: Iterable[Case]) -> None:
        """Run every step that is not finished.

        Raises OutputError as soon as a worker cannot write, InputError as soon as a file is no longer what the study
        read: what is done stays, and another run goes on from there.
        """
        stream, exhausted = iter(cases), False
        slots, told = self._slots(), time.monotonic()
        while True:
            while not exhausted and len(self._ready) + len(self._missing) < AHEAD:
                case = next(stream, None)
                if case is None:
                    exhausted = True
                    break
                for step in case.steps:
                    self._take(step)
            while self._ready and len(self._flying) < 2 * slots + 1:
                self._send(slots)
            if exhausted and not self._flying and not self._ready:
                self.tell(self.progress)
                return
            self._receive()
            if time.monotonic() - told >= 1.0:
                told, slots = time.monotonic(), self._slots()
                self.tell(self.progress)

    def _take(self, step: Step) -> None:
        """Find out what is to be done about a step: nothing, wait for others, or run it."""
        if step.key in self._known:
            return
        self._known.add(step.key)
        outcome = self.store.outcome(step.key)
        if outcome is not None and self.again(outcome):
            self.store.forget(step.key)
            outcome = None
        if outcome is not None:
            self.progress.reused += 1
            self._finish(step.key, outcome.has_result)
            return
        if any(self._builds.get(need) is False for need in step.needs):
            self._skip(step)
            return
        open_needs = [need for need in step.needs if need not in self._builds]
        if not open_needs:
            self._ready.append(step)
            return
        self._missing[step.key] = len(open_needs)
        for need in open_needs:
            self._waiting.setdefault(need, []).append(step)

    def _send(self, slots: int) -> None:
        # After a death steps go one by one, to find the one that kills its worker.
        size = 1 if self._deaths else max(1, min(MAX_BATCH, int(BATCH_S / max(self._mean, 1e-6))))
        # Towards the end nobody shall sit on a long batch while others idle.
        size = min(size, -(-len(self._ready) // (2 * slots)))
        batch = [self._ready.popleft() for _ in range(size)]
        self._batches += 1
        folder = str(self.store.folder.absolute())
        assert self.client is not None, "a step is to be run, and there is no worker"
        future = self.client.submit(run_steps, folder, self.runner, batch, key=f"steps-{self._batches}", pure=False)
        self._flying[future.key] = (future, batch)
        future.add_done_callback(self._arrived.put)

    def _receive(self) -> None:
        try:
            future = self._arrived.get(timeout=1.0)
        except queue.Empty:
            return
        while future is not None:
            _, batch = self._flying.pop(future.key)
            if future.status == "finished":
                self._settle(future.result(), batch)
            else:
                self._lose(future, batch)
            try:
                future = self._arrived.get_nowait()
            except queue.Empty:
                future = None

    def _settle(self, results: list[tuple[str, Outcome, float]], batch: list[Step]) -> None:
        for key, outcome, seconds in results:
            if outcome.status == OutputError.exit_status:
                raise OutputError(outcome.message)
            if outcome.status == CHANGED:
                raise InputError(
                    "changed while the study ran",
                    file=outcome.message,
                    remedy="run the same line again; what was found before it changed is kept as such",
                )
            self.progress.run += 1
            self._mean += 0.1 * (seconds + 0.002 - self._mean)
            self._deaths.pop(key, None)
            if not outcome.kept:
                self.accidents[key] = outcome
            self._finish(key, outcome.has_result)
        for step in batch[len(results) :]:
            self._ready.appendleft(step)

    def _lose(self, future: Any, batch: list[Step]) -> None:
        """Workers died with the batch, more often than the scheduler puts up with: try its steps one by one."""
        error = future.exception() if future.status == "error" else None
        reason = f"{type(error).__name__}" if error is not None else "the batch was lost"
        for step in batch:
            if self.store.outcome(step.key) is None and len(batch) == 1:
                self.accidents[step.key] = Outcome(
                    DIED, f"its worker died each time ({reason}): out of memory, or a crash in compiled code"
                )
                self.progress.run += 1
                self._finish(step.key, False)
            else:
                self._deaths[step.key] += 1
                self._ready.append(step)

    def _finish(self, key: str, builds: bool) -> None:
        self._builds[key] = builds
        for step in self._waiting.pop(key, []):
            if step.key not in self._missing:
                continue
            if not builds:
                del self._missing[step.key]
                self._skip(step)
                continue
            self._missing[step.key] -= 1
            if not self._missing[step.key]:
                del self._missing[step.key]
                self._ready.append(step)

    def _skip(self, step: Step) -> None:
        self.progress.skipped += 1
        self._finish(step.key, False)

    def _slots(self) -> int:
        return 1 if self.client is None else max(sum(self.client.nthreads().values()), 1)


#: Runs one command: (command, arguments, name of the document to write) -> how it ended.
Runner = Callable[[str, Sequence[str], str], Outcome]


def run_steps(folder: str, run: Runner, steps: Sequence[Step]) -> list[tuple[str, Outcome, float]]:
    """Run ``steps``; return the key of each, how it ended, and the seconds the command itself took.

    A step that is finished already is not run. After a failed write nothing more is tried: the disk is full for all;
    nor where a file is no longer what the study read.
    """
    store = Store(folder)
    found: list[tuple[str, Outcome, float]] = []
    for step in steps:
        outcome, seconds = run_step(store, run, step)
        found.append((step.key, outcome, seconds))
        if outcome.status in (OutputError.exit_status, CHANGED):
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
        changed = step.changed
        if changed is not None:
            return Outcome(CHANGED, changed), seconds
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
