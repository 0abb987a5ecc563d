"""A command run as one step of a study, inside a worker that has run others before it."""

from __future__ import annotations

import importlib
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import typer.main

from hyperfab import errors
from hyperfab.cases import options
from hyperfab.cases.registry import CASES, case_class
from hyperfab.cli.shared import arguments_given, chapter_options
from hyperfab.console import Console
from hyperfab.errors import HyperfabError

if TYPE_CHECKING:
    from hyperfab.studies.store import Outcome

#: The commands a study may chain, and the kind of document each writes.
COMMANDS = {
    "fit": "material",
    "fabric-contact": "contact",
    "drape": "drape",
    "mold-heat": "heat",
    "press-contact": "press",
    "close-loop": "loop",
}
#: What the parser raises; typer brings click, or a copy of it under another name.
UsageError: Any = typer.BadParameter.__mro__[1]
_group: Any = None


class _Listener(Console):
    """A console nobody sits at: keeps the warnings, drops the rest."""

    def __init__(self) -> None:
        super().__init__(quiet=True)
        self.warnings: list[str] = []

    def warn(self, text: str) -> None:
        self.warnings.append(text)


def run(command: str, words: Sequence[str], output: str) -> Outcome:
    """Run ``hf COMMAND WORDS -o OUTPUT`` in this process and return how it ended, as the command line would."""
    from hyperfab.chapters.commands import run_words
    from hyperfab.chapters.job import Job
    from hyperfab.studies.store import Outcome

    listener = _Listener()
    try:
        if command in CASES:
            job = Job(command, words, listener, target=output)
            return _outcome(run_words(job, words), listener)
        context = parse(command, [*words, "-o", output])
        chapter = importlib.import_module(f"hyperfab.chapters.{command.replace('-', '_')}")
        job = Job(command, arguments_given(context), listener, strict=bool(context.params.get("strict")))
        return _outcome(job.ended(chapter.run(job, **chapter_options(context))), listener)
    except HyperfabError as error:
        return Outcome(error.exit_status, str(error), tuple(listener.warnings))
    except UsageError as error:
        return Outcome(2, error.format_message())
    except MemoryError:
        return Outcome(70, "out of memory; use a coarser mesh or grid, or fewer jobs")
    except Exception as error:  # noqa: BLE001 - one case's defect must not end the others
        return Outcome(70, f"defect: {type(error).__name__}: {error}", tuple(listener.warnings))


def _outcome(status: int, listener: _Listener) -> Outcome:
    from hyperfab.studies.store import Outcome

    message = listener.warnings[-1] if status and listener.warnings else ""
    return Outcome(status, message, tuple(listener.warnings))


def check(command: str, words: Sequence[str]) -> str | None:
    """Return what is wrong with a step's arguments, or None; nothing is run."""
    if command not in COMMANDS:
        known = ", ".join(COMMANDS)
        return f"no command {command!r} makes documents; there is {known}"
    try:
        if command in CASES:
            options.read(case_class(command), words)
        else:
            parse(command, [*words, "-o", "step.json"])
    except errors.UsageError as error:
        return str(error)
    except UsageError as error:
        return error.format_message()
    return None


def warm(commands: Sequence[str]) -> None:
    """Import the chapters of ``commands``, so that the first case finds them loaded."""
    for command in commands:
        importlib.import_module(f"hyperfab.chapters.{command.replace('-', '_')}")


def parse(command: str, words: Sequence[str]) -> typer.Context:
    """Read a command's arguments as the command line does; UsageError where they are wrong."""
    found: Any = _commands().get_command(None, command)
    context: typer.Context = found.make_context(command, list(words), resilient_parsing=False)
    return context


def _commands() -> Any:
    global _group
    if _group is None:
        from hyperfab.cli import app

        _group = typer.main.get_command(app)
    return _group
