"""A contact, drape or press document as a model: the command that made it, its options, and the files it read."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

from hyperfab.cases.case import Case
from hyperfab.cases.like import Earlier
from hyperfab.chapters.job import Job
from hyperfab.documents.base import document_class, parse_document
from hyperfab.documents.provenance import Provenance
from hyperfab.errors import InputError, UsageError
from hyperfab.io.inputs import Inputs

CaseT = TypeVar("CaseT", bound=Case)
#: Reads the words of a command line: command and words to the options its chapter takes.
Parse = Callable[[str, Sequence[str]], Mapping[str, Any]]

#: The command that makes each kind of document.
MADE_BY = {"contact": "fabric-contact", "drape": "drape", "press": "press-contact"}


@dataclass(frozen=True)
class Recalled:
    """How a document was made: ``words`` of its command with the files where they are now, and ``options`` of the
    chapter; ``known`` are the SHA-256 of what was read then."""

    name: str
    command: str
    words: list[str]
    options: dict[str, Any]
    known: frozenset[str]
    data: Mapping[str, Any]


def recall(job: Job, name: str, data: Mapping[str, Any], kind: str, parse: Parse) -> Recalled:
    """Return how the document ``name`` was made; every file it was made from is found again and unchanged.

    Raises InputError naming what is missing or has changed since.
    """
    command = MADE_BY[kind]
    document = parse_document(data, name, document_class(kind))
    provenance = document.provenance
    if provenance is None or provenance.command != command:
        raise InputError(
            "does not say how it was made",
            file=name,
            key="provenance",
            remedy=f"make it with hf {command}",
        )
    # Also what the files named on the command line name in their turn.
    places = {one.name: _found(job, name, one.name, provenance, command) for one in provenance.inputs}
    words = [places.get(word, word) for word in provenance.arguments]
    try:
        options = dict(parse(command, [*words, "-o", "-"]))
    except UsageError as error:
        raise InputError(
            f"has arguments that hf {command} does not take: {error}",
            file=name,
            key="provenance.arguments",
            remedy=f"make it again with hf {command}",
        ) from None
    return Recalled(name, command, words, options, frozenset(one.sha256 for one in provenance.inputs), data)


def unchanged(made: Earlier[CaseT]) -> Earlier[CaseT]:
    """Return how a model was made; InputError where an input of it has changed since."""
    for name in made.changed:
        raise _changed(name, made.name, made.case.COMMAND)
    return made


def check_unchanged(job: Job, made: Earlier[Any] | Recalled, besides: Iterable[str]) -> None:
    """Refuse files read for the model that are not those it was made from; ``besides`` were read for other ends."""
    other = {made.name, *besides}
    known = made.known if isinstance(made, Recalled) else set(made.read.values())
    for file in job.inputs.files:
        if file.name not in other and file.sha256 not in known:
            raise _changed(
                file.name, made.name, made.command if isinstance(made, Recalled) else made.case.COMMAND
            )


def reworded(words: Sequence[str], changes: Mapping[str, str | None]) -> list[str]:
    """Return a command's words with options set anew; None takes one out.

    >>> reworded(["a.json", "--depth", "60mm"], {"--depth": "50mm", "--friction": "0.2"})
    ['a.json', '--depth', '50mm', '--friction', '0.2']
    """
    found = list(words)
    for option, value in changes.items():
        if option in found:
            at = found.index(option)
            found[at : at + 2] = [] if value is None else [option, value]
        elif value is not None:
            found += [option, value]
    return found


def _found(job: Job, name: str, relative: str, provenance: Provenance, command: str) -> str:
    """Return where an input lies now: beside the document, or in a folder near by, known by its hash."""
    if relative == "-":
        kept = _kept(name, {one.sha256 for one in provenance.inputs if one.name == relative})
        if kept is not None:
            job.inputs.read(kept)
            return kept
        raise InputError(
            "was made from a document on standard input, which is gone",
            file=name,
            key="provenance.arguments",
            remedy=f"keep that document in a file and run hf {command} on it",
        )
    wanted = {one.sha256 for one in provenance.inputs if one.name == relative}
    first = Inputs.beside(name, relative)
    base = os.path.basename(relative)
    others = [relative, base]
    # No further: a copy that happens to lie about elsewhere is not the user's file.
    for folder in (Path(), Path(name).parent):
        others += [str(path) for path in [folder / base, *sorted(folder.glob(f"*/{base}"))]]
    for place in (first, *(os.path.normpath(place) for place in others)):
        if os.path.isfile(place) and (not wanted or _hash(place) in wanted):
            job.inputs.read(place)
            return place
    if os.path.isfile(first):
        raise _changed(first, name, command)
    raise InputError(
        f"no such file; {name} was made from it",
        file=first,
        remedy=f"put it back, or make {os.path.basename(name)} again with hf {command}",
    )


def _kept(name: str, wanted: set[str]) -> str | None:
    """Return the copy of a piped document that was kept beside the document ``name`` or in the present folder."""
    for folder in (Path(name).parent, Path()):
        for path in sorted(folder.glob("*.json")):
            if path.is_file() and _hash(str(path)) in wanted:
                return os.path.normpath(path)
    return None


def _hash(place: str) -> str:
    return hashlib.sha256(Path(place).read_bytes()).hexdigest()


def _changed(file: str, name: str, command: str) -> InputError:
    return InputError(
        f"has changed since {name} was made from it",
        file=file,
        remedy=f"make {os.path.basename(name)} again with hf {command}",
    )
