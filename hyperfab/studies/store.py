"""Where the results of a study live: one folder a finished step, which appears whole or not at all.

steps/ab/abcd...          the step's document, what lies beside it, and outcome.json
steps/ab/abcd....log      one line each time the step was started or finished
steps/ab/.abcd....run-*   a step at work; what a killed worker leaves is swept away at the next start
"""

from __future__ import annotations

import contextlib
import errno
import json
import os
import shutil
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import filelock

from hyperfab.errors import InputError, OutputError, UsageError
from hyperfab.io.atomic import write_files
from hyperfab.io.json_io import dump_json, load_json
from hyperfab.studies.plan import Step
from hyperfab.system import BINARY

#: The file whose being there says that a step is finished.
OUTCOME = "outcome.json"
#: The status of a step one of whose files is no longer what the study read; its message is which.
CHANGED = 75
#: Statuses that say nothing about the case: the step is run again by the next run of the study.
PASSING = frozenset({5, 70, CHANGED, 130, 143})


def is_result(status: object) -> bool:
    """Whether a step that ended with this status was done, also with a negative verdict."""
    return status in (0, 1)


@dataclass(frozen=True)
class Outcome:
    """How a step ended: its exit status, its message, its warnings."""

    status: int
    message: str = ""
    warnings: tuple[str, ...] = ()

    @property
    def has_result(self) -> bool:
        """Whether later steps can build on it: done, also with a negative verdict."""
        return is_result(self.status)

    @property
    def kept(self) -> bool:
        """Whether it is final: not an accident of the machine."""
        return self.status not in PASSING


class Store:
    """The folder of a study."""

    def __init__(self, folder: str | Path) -> None:
        self.folder = Path(folder)
        self.steps = self.folder / "steps"

    def place(self, key: str) -> Path:
        """Return the folder of a step."""
        return self.steps / key[:2] / key

    def outcome(self, key: str) -> Outcome | None:
        """Return how a step ended, or None where it is not finished."""
        path = self.place(key) / OUTCOME
        try:
            found = json.loads(path.read_bytes())
            return Outcome(int(found["status"]), str(found["message"]), tuple(found["warnings"]))
        except (OSError, ValueError, KeyError, TypeError):
            return None  # not there, or damaged from outside: run it again

    def document(self, step: Step) -> dict[str, Any] | None:
        """Return the document a step wrote, or None where it wrote none."""
        path = self.place(step.key) / f"{step.name}.json"
        try:
            loaded = load_json(path.read_bytes(), str(path))
        except (OSError, InputError):
            return None
        return loaded if isinstance(loaded, dict) else None

    def begin(self, step: Step) -> Path:
        """Make the folder a step works in, and note in its log that it was started."""
        folder = self.steps / step.key[:2]
        try:
            folder.mkdir(parents=True, exist_ok=True)
            self._log(step, "started")
            for attempt in range(1000):
                place = folder / f".{step.key}.run-{os.getpid()}-{attempt}"
                with contextlib.suppress(FileExistsError):
                    place.mkdir()
                    return place
        except OSError as error:
            raise OutputError(f"{folder}: {error.strerror or error}") from error
        raise OutputError(f"{folder}: too many unfinished steps were left here")

    def finish(self, step: Step, place: Path, outcome: Outcome, seconds: float) -> None:
        """Give the folder ``place`` its name. A step that somebody else finished meanwhile stays as it is."""
        found = {"status": outcome.status, "message": outcome.message, "warnings": list(outcome.warnings)}
        write_files([(place / OUTCOME, dump_json(found))])
        try:
            target = self.place(step.key)
            if target.exists() and self.outcome(step.key) is None:
                shutil.rmtree(target)
            os.rename(place, target)
        except OSError as error:
            self.abandon(place)
            if error.errno in (errno.ENOTEMPTY, errno.EEXIST):
                return
            raise OutputError(f"{place}: {error.strerror or error}") from error
        self._log(step, f"finished with status {outcome.status} in {seconds:.3f} s")

    def abandon(self, place: Path) -> None:
        """Remove the folder of a step that did not come to an end."""
        shutil.rmtree(place, ignore_errors=True)

    def forget(self, key: str) -> None:
        """Remove a finished step, so that it is run again."""
        shutil.rmtree(self.place(key), ignore_errors=True)

    def _log(self, step: Step, text: str) -> None:
        path = self.steps / step.key[:2] / f"{step.key}.log"
        descriptor = os.open(path, os.O_WRONLY | os.O_APPEND | os.O_CREAT | BINARY, 0o666)
        try:
            os.write(descriptor, f"{step.command} {text}\n".encode())
        finally:
            os.close(descriptor)

    @contextlib.contextmanager
    def held(self) -> Iterator[None]:
        """Hold the folder for one driver, and sweep away what killed ones left in it.

        Raises OutputError where the folder cannot be written, UsageError where another driver is at work in it.
        """
        lock = filelock.FileLock(self.folder / ".lock", blocking=False)
        try:
            self.steps.mkdir(parents=True, exist_ok=True)
            lock.acquire()
        except filelock.Timeout:
            raise UsageError(
                f"--out {self.folder}: another hf sweep is at work there; wait for it or choose another folder"
            ) from None
        except OSError as error:
            raise OutputError(f"{self.folder}: {error.strerror or error}; choose another folder") from error
        try:
            for left in self.steps.glob("??/.*.run-*"):
                shutil.rmtree(left, ignore_errors=True)
            yield
        finally:
            lock.release()
