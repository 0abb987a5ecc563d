"""A command run as one step of a study, inside a worker that has run others before it."""

from __future__ import annotations

from collections.abc import Sequence

from hyperfab.cases import options
from hyperfab.cases.registry import MADE_BY, case_class
from hyperfab.chapters.commands import chapter_of, run_words, without_run
from hyperfab.chapters.job import Job
from hyperfab.chapters.rerun import Listener
from hyperfab.errors import HyperfabError, UsageError
from hyperfab.studies.store import Outcome

#: The commands a study may chain, and the kind of document each writes.
COMMANDS = {command: kind for kind, command in MADE_BY.items() if command != "sweep"}


def run(command: str, words: Sequence[str], output: str) -> Outcome:
    """Run ``hf COMMAND WORDS -o OUTPUT`` in this process and return how it ended, as the command line would."""
    listener = Listener()
    try:
        status = run_words(Job(command, words, listener, target=output), words)
        message = listener.warnings[-1] if status and listener.warnings else ""
        return Outcome(status, message, tuple(listener.warnings))
    except HyperfabError as error:
        return Outcome(error.exit_status, str(error), tuple(listener.warnings))
    except MemoryError:
        return Outcome(70, "out of memory; use a coarser mesh or grid, or fewer jobs")
    except Exception as error:  # noqa: BLE001 - one case's defect must not end the others
        return Outcome(70, f"defect: {type(error).__name__}: {error}", tuple(listener.warnings))


def check(command: str, words: Sequence[str]) -> str | None:
    """Return what is wrong with a step's arguments, or None; nothing is run."""
    if command not in COMMANDS:
        return f"no command {command!r} makes documents; there is {', '.join(COMMANDS)}"
    try:
        own, like, _ = without_run(words)
        cls = case_class(command)
        if like is None:
            options.read(cls, own)
        else:
            options.given(cls, own)
    except UsageError as error:
        return str(error)
    return None


def warm(commands: Sequence[str]) -> None:
    """Import the chapters of ``commands``, so that the first case finds them loaded."""
    for command in commands:
        chapter_of(command)
