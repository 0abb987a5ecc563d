"""The commands by name: the chapter that runs each, imported only when it is asked for."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from hyperfab.cases.case import Case, tolerances
from hyperfab.cases.like import earlier
from hyperfab.cases.options import given, shown
from hyperfab.cases.registry import case_class
from hyperfab.chapters.job import Job
from hyperfab.io.json_io import load_json


def asked(job: Job, cls: type[Case], options: Mapping[str, Any], like: str | None = None) -> Case:
    """Return the case of the ``options`` given, the others as in the document ``like``; changed inputs are told.

    From now on the job's arguments are those.
    """
    job.arguments = [*shown(cls, options), *(["--like", like] if like is not None else [])]
    if like is None:
        return cls.of(options)
    data = load_json(job.inputs.read(like), like)
    replaced = {*options, *(other for name in options for other in cls.settings()[name].over)}
    job.like = earlier(cls, data if isinstance(data, Mapping) else {}, like, replaced)
    for name in job.like.changed:
        job.console.warn(f"{name} has changed since {like} was made from it")
    return cls.of(options, job.like.values)


def without_run(words: Sequence[str]) -> tuple[list[str], str | None, bool]:
    """Return a command's words without those about the run: its own, the document of ``--like``, ``--strict``."""
    own, like, strict = [], None, False
    rest = iter(words)
    for word in rest:
        if word == "--strict":
            strict = True
        elif word == "--like":
            like = next(rest, None)
        elif word.startswith("--like="):
            like = word.removeprefix("--like=")
        elif word not in ("--quiet", "-q", "--debug"):
            own.append(word)
    return own, like, strict


def run_words(job: Job, words: Sequence[str]) -> int:
    """Run the job's command on the case of its words, as the command line would."""
    cls = case_class(job.command)
    own, like, job.strict = without_run(words)
    return run(job, asked(job, cls, given(cls, own), like))


def run(job: Job, case: Case) -> int:
    """Run the chapter of the case's command; return its exit status."""
    settings = case.settings()
    if "uncertainty" not in settings:
        stated = [one.spoken for one in settings.values() if tolerances(getattr(case, one.name), one.key)]
        if stated:
            job.console.warn(f"hf {case.COMMAND} does not carry tolerances: that of {', '.join(stated)} is left out")
    return job.ended(chapter_of(case.COMMAND)(job, case))


def chapter_of(command: str) -> Callable[[Job, Any], int]:
    """Return what runs a command; each takes the case that the registry has for it."""
    chapter: Callable[[Job, Any], int]
    if command == "fit":
        from hyperfab.chapters.fit import run as chapter
    elif command == "close-loop":
        from hyperfab.chapters.close_loop import run as chapter
    elif command == "export":
        from hyperfab.chapters.export import run as chapter
    elif command == "fabric-contact":
        from hyperfab.chapters.fabric_contact import run as chapter
    elif command == "drape":
        from hyperfab.chapters.drape import run as chapter
    elif command == "mold-heat":
        from hyperfab.chapters.mold_heat import run as chapter
    elif command == "press-contact":
        from hyperfab.chapters.press_contact import run as chapter
    elif command == "report":
        from hyperfab.chapters.report import run as chapter
    elif command == "sweep":
        from hyperfab.chapters.sweep import run as chapter
    elif command == "summary":
        from hyperfab.chapters.summary import run as chapter
    elif command == "sample":
        from hyperfab.chapters.sample import run as chapter
    elif command == "schema":
        from hyperfab.chapters.schema import run as chapter
    else:
        raise KeyError(command)
    return chapter
