"""The set-up of an earlier document: its case, with every input found again by its name and hash."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Generic, TypeVar

from hyperfab.cases import options
from hyperfab.cases.case import HASHES, Case
from hyperfab.cases.kinds import File
from hyperfab.documents.base import document_class, parse_document
from hyperfab.documents.provenance import Provenance
from hyperfab.errors import InputError, UsageError
from hyperfab.io.inputs import Inputs

CaseT = TypeVar("CaseT", bound=Case)


@dataclass(frozen=True)
class Earlier(Generic[CaseT]):
    """How a document was made.

    name     the document
    cls      the class of its case
    values   those of the case, with the files where they are now; settings that no document keeps are not among them
    read     the SHA-256 of all that was read then, by the name it has from here
    far      those of what lay too far off to be named but by its bare name, and is not named by the case
    changed  inputs that the case names and that have changed since
    """

    name: str
    cls: type[CaseT]
    values: Mapping[str, Any]
    read: Mapping[str, str]
    far: Mapping[str, Collection[str]]
    changed: Sequence[str]

    @property
    def case(self) -> CaseT:
        """The case; InputError where the document lacks what one needs."""
        try:
            return self.cls.of({}, self.values)
        except UsageError as error:
            raise InputError(str(error), file=self.name, key="setup") from None

    def altered(self, inputs: Inputs) -> list[str]:
        """Return files read now that lie where the earlier run read others, besides those the case names."""
        # By absolute path: a study names its files so.
        now = {os.path.abspath(file.name): file for file in inputs.files if file.name != "-"}
        near = {os.path.abspath(name): name for name in self.read if name not in self.changed}
        moved = [near[place] for place in near if place in now and now[place].sha256 != self.read[near[place]]]
        hidden = [
            file.name
            for place, file in now.items()
            if place not in near and file.sha256 not in self.far.get(os.path.basename(place), [file.sha256])
        ]
        return moved + hidden


def earlier(cls: type[CaseT], data: Mapping[str, Any], name: str, replaced: Collection[str] = ()) -> Earlier[CaseT]:
    """Return how the document ``name`` with the plain ``data`` was made; fields ``replaced`` need no file.

    A file is looked for beside the document and in folders near by, by its hash; one that has changed is taken by its
    name. Raises InputError where the document does not say how it was made, or names an input that is missing.
    """
    if cls.KIND is None:
        raise UsageError(f"hf {cls.COMMAND} writes no document to take a set-up from")
    document = parse_document(data, name, document_class(cls.KIND))
    provenance = document.provenance
    if provenance is None or provenance.command != cls.COMMAND:
        raise InputError(
            "does not say how it was made",
            file=name,
            key="provenance",
            remedy=f"make it with hf {cls.COMMAND}",
        )
    values, hashes = asked(cls, data, name, provenance)
    search = _Search(name, cls.COMMAND, provenance)
    for one in cls.settings().values():
        value = values.get(one.name)
        if value is None or not one.files(value) or one.name in replaced:
            continue
        known = hashes.get(one.key)
        if isinstance(value, str):
            values[one.name] = search.found(value, known if isinstance(known, str) else None)
        else:
            named = one.files(value)
            each = iter(known if isinstance(known, list) and len(known) == len(named) else [None] * len(named))
            values[one.name] = tuple(search.found(name, next(each)) if one.files([name]) else name for name in value)
    read = {search.beside(file.name): file.sha256 for file in provenance.inputs}
    told = {digest for one in hashes.values() for digest in (one if isinstance(one, list) else [one])}
    far: dict[str, set[str]] = {}
    for file in provenance.inputs:
        bare = file.name == os.path.basename(file.name) and not os.path.isfile(search.beside(file.name))
        if bare and file.sha256 not in told:
            far.setdefault(file.name, set()).add(file.sha256)
    return Earlier(name, cls, values, read, far, search.changed)


def asked(
    cls: type[Case], data: Mapping[str, Any], name: str, provenance: Provenance
) -> tuple[dict[str, Any], Mapping[str, Any]]:
    """Return the values that the document ``name`` was made with, by field, and the hashes of its inputs, by key."""
    setup = data.get("setup")
    # The set-up of older documents says what was pressed, and not all that was asked.
    if isinstance(setup, Mapping) and HASHES in setup:
        return cls.load(setup, name), setup[HASHES]
    return _of_words(cls, provenance, name), {}


def _of_words(cls: type[CaseT], provenance: Provenance, name: str) -> dict[str, Any]:
    """Return the values of a document without ``setup``, from the words it was made with."""
    try:
        return options.read(cls, provenance.arguments).values
    except UsageError as error:
        raise InputError(
            f"has arguments that hf {cls.COMMAND} does not take: {error}",
            file=name,
            key="provenance.arguments",
            remedy=f"make it again with hf {cls.COMMAND}",
        ) from None


class _Search:
    """Finds inputs of a document again."""

    def __init__(self, name: str, command: str, provenance: Provenance) -> None:
        self.name, self.command, self.provenance = name, command, provenance
        self.changed: list[str] = []

    def beside(self, relative: str) -> str:
        """Return a name that the document gives, from here."""
        return relative if relative == "-" else os.path.normpath(Inputs.beside(self.name, relative))

    def found(self, shown: str, known: str | None) -> str:
        """Return where the input ``shown`` lies now; ``known`` is its hash where the set-up says it."""
        shown, part = File.parted(shown)
        return self._found(shown, known) + part

    def _found(self, shown: str, known: str | None) -> str:
        inputs, bare = self.provenance.inputs, os.path.basename(shown)
        named = (one.name for one in inputs if one.sha256 == known and os.path.basename(one.name) == bare)
        relative = next(named, shown)
        wanted = {known} if known else {one.sha256 for one in inputs if one.name == relative}
        if relative == "-":
            return self._kept(wanted)
        first = self.beside(relative)
        others = [relative]
        # No further: a copy that happens to lie about elsewhere is not the user's file.
        for folder in (Path(), Path(self.name).parent):
            others += [str(path) for path in [folder / bare, *sorted(folder.glob(f"*/{bare}"))]]
        for place in (first, *(os.path.normpath(place) for place in others)):
            if os.path.isfile(place) and (not wanted or _hash(place) in wanted):
                return place
        if os.path.isfile(first):
            self.changed.append(first)
            return first
        own = "the document" if self.name == "-" else os.path.basename(self.name)
        namesake = next((place for place in others if os.path.isfile(place)), None)
        another = "" if namesake is None else f", and {os.path.normpath(namesake)} is another one or has changed"
        raise InputError(
            f"no such file; {own if self.name == '-' else self.name} was made from it{another}",
            file=first,
            remedy=f"lay it beside {own}, or make {own} again with hf {self.command}",
        )

    def _kept(self, wanted: set[str]) -> str:
        """Return the copy of a piped document that was kept beside the document or in the present folder."""
        for folder in (Path(self.name).parent, Path()):
            for path in sorted(folder.glob("*.json")):
                if path.is_file() and _hash(str(path)) in wanted:
                    return os.path.normpath(path)
        raise InputError(
            "was made from a document on standard input, which is gone",
            file=self.name,
            key="provenance.arguments",
            remedy=f"keep that document in a file and run hf {self.command} on it",
        )


def _hash(place: str) -> str:
    return hashlib.sha256(Path(place).read_bytes()).hexdigest()
