"""A model as a command made it: its inputs must be those it was made from; the command run again, kept in memory."""

from __future__ import annotations

import os
import shlex
from collections.abc import Container, Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any, TypeVar

from hyperfab.cases.case import Case
from hyperfab.cases.kinds import File
from hyperfab.cases.like import Earlier, earlier
from hyperfab.cases.options import words
from hyperfab.chapters.commands import run
from hyperfab.chapters.job import Job
from hyperfab.console import Console
from hyperfab.documents.provenance import relative_name
from hyperfab.errors import InputError
from hyperfab.io.inputs import MAX_BYTES, Inputs
from hyperfab.io.output import Output

CaseT = TypeVar("CaseT", bound=Case)


class Overlay(Inputs):
    """Files on disk, and those in ``given`` (by name) that are not written yet."""

    def __init__(self, given: Mapping[str, bytes]) -> None:
        super().__init__()
        self._given = dict(given)

    @property
    def given(self) -> Mapping[str, bytes]:
        """The files that do not lie on disk, by name."""
        return self._given

    def read(self, name: str, limit: int = MAX_BYTES) -> bytes:
        """Return the bytes of a file; what is given goes before what lies on disk."""
        if name in self._given:
            return self._take(name, self._given[name], limit)
        return super().read(name, limit)


class Kept(Output):
    """An output that writes nothing."""

    document: dict[str, Any]

    def finish(self, document: dict[str, Any], inputs: Inputs) -> None:
        """Keep the document, with ``files`` filled in."""
        names = sorted(self.path(suffix).name for suffix in self._siblings)
        self.document = {**document, "files": names} if self.wants_files else document

    @property
    def siblings(self) -> dict[str, bytes]:
        """What would lie beside the document, by suffix."""
        return dict(self._siblings)


class Listener(Console):
    """A console nobody sits at: keeps the warnings."""

    def __init__(self) -> None:
        super().__init__(quiet=True)
        self.warnings: list[str] = []

    def warn(self, *texts: str) -> None:
        self.warnings += texts


@dataclass
class Rerun(Job):
    """A run whose output is kept."""

    outputs: list[Kept] = field(default_factory=list)

    def opened(self, *suffixes: str) -> Output:
        self.outputs.append(Kept(self.target, suffixes))
        return self.outputs[-1]


@dataclass(frozen=True)
class Made:
    """What a command would have written: the document, its siblings by suffix; status and warnings."""

    document: dict[str, Any]
    siblings: dict[str, bytes]
    status: int
    warnings: list[str]


def rerun(case: Case, target: str, given: Mapping[str, bytes] = {}) -> Made:
    """Run the command of a case, with files ``given`` by name that are not written yet; errors are the command's."""
    listener = Listener()
    job = Rerun(case.COMMAND, words(case), listener, Overlay(given), target)
    status = run(job, case)
    kept = job.outputs[-1]
    return Made(kept.document, kept.siblings, status, listener.warnings)


def command_line(case: Case, target: str, given: Container[str], *more: str) -> str:
    """Return what runs a case beside the document ``target``, with ``more`` words; the files ``given`` are to come."""

    def seen(word: str) -> str:
        file, part = File.parted(word)
        return relative_name(file, target) + part if os.path.exists(file) or file in given else word

    return shlex.join(["hf", case.COMMAND, *map(seen, words(case)), *more])


def unchanged(cls: type[CaseT], data: Mapping[str, Any], name: str) -> Earlier[CaseT]:
    """Return how the document ``name`` was made; InputError where an input of it has changed since."""
    made = earlier(cls, data, name)
    for file in made.changed:
        raise _changed(file, made)
    return made


def check_unchanged(job: Job, made: Earlier[Any], besides: Iterable[str]) -> None:
    """Refuse files read for the model that are not those it was made from; ``besides`` were read for other ends."""
    other = {made.name, *besides} | ({job.like.name} if job.like is not None else set())
    known = set(made.read.values())
    for file in job.inputs.files:
        if file.name not in other and file.sha256 not in known:
            raise _changed(file.name, made)


def _changed(file: str, made: Earlier[Any]) -> InputError:
    return InputError(
        f"has changed since {made.name} was made from it",
        file=file,
        remedy=f"make {os.path.basename(made.name)} again with hf {made.cls.COMMAND}",
    )
