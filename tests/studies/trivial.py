"""Commands that do next to nothing: the engine is tested on them, not the physics."""

from __future__ import annotations

import errno
import os
import signal
import time
from collections.abc import Sequence
from pathlib import Path

from hyperfab.io.atomic import write_files
from hyperfab.io.json_io import dump_json, load_json
from hyperfab.studies.store import Outcome

#: "none" is no kind of document: its keys are not known beforehand.
COMMANDS = {
    "add": "none",
    "fill": "none",
    "fail": "none",
    "sleep": "none",
    "die": "none",
    "stall": "none",
    "first": "none",
}


def check(command: str, words: Sequence[str]) -> str | None:
    """Return what is wrong with the arguments."""
    return None if command in COMMANDS else f"no command {command!r} makes documents"


def warm(commands: Sequence[str]) -> None:
    """Nothing to warm up."""


def run(command: str, words: Sequence[str], output: str) -> Outcome:
    """Add the numbers among ``words``, and the ``sum`` of each document among them; or fail as asked.

    ``stall`` comes no further than 3, which its document tells; ``first`` adds the first number alone.
    """
    numbers = []
    for word in words:
        if word.endswith(".json"):
            numbers.append(float(load_json(Path(word).read_bytes(), word)["sum"]))
        elif not word.startswith("/"):
            numbers.append(float(word))
    total = sum(numbers)
    if command == "fail" and total > 3:
        return Outcome(4, f"{output}: {total} is more than 3")
    if command == "fill" and total > 2 and not Path(output).parents[4].joinpath("freed").exists():
        raise OSError(errno.ENOSPC, "No space left on device")
    if command == "first":
        total = numbers[0]
    if command == "sleep":
        time.sleep(total)
    if command == "die":
        os.kill(os.getpid(), signal.SIGKILL)
    stalls = command == "stall" and total > 3
    total = min(total, 3.5) if stalls else total
    write_files([(output, dump_json({"sum": total, "deep": {"double": 2 * total}}))])
    return Outcome(4, "comes no further than 3") if stalls else Outcome(0)
