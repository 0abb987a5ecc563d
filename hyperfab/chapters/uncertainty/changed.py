"""A case and its files with other numbers in them."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Generic, TypeVar

from hyperfab.cases.case import Case
from hyperfab.chapters.field import moved_fields
from hyperfab.chapters.job import Job
from hyperfab.chapters.rerun import Listener
from hyperfab.io.inputs import MAX_BYTES, Inputs
from hyperfab.io.toml_io import dump_toml

CaseT = TypeVar("CaseT", bound=Case)
Parsed = TypeVar("Parsed")
#: Where something stands in a document: keys, and numbers in lists.
Place = tuple[str | int, ...]


@dataclass
class Kept:
    """What is read of a command's inputs once for all neighbours: ``texts`` of documents that change, by name, and the
    documents that do not, by name and kind."""

    texts: dict[str, str] = field(default_factory=dict)
    documents: dict[tuple[str, object], Any] = field(default_factory=dict)


class Changed(Generic[CaseT]):
    """A case and its files, with other numbers in them; what is read of these is ``kept``."""

    def __init__(self, case: CaseT, inputs: Inputs, kept: Kept) -> None:
        self.case = case
        self._inputs, self._kept = inputs, kept
        self._documents: dict[str, Any] = {}
        #: Of documents that hand fields on: by how much each number changes, by its place among theirs.
        self.handed: dict[str, dict[int, float]] = {}
        #: Other files that are not as they lie on disk, by name.
        self.written: dict[str, bytes] = {}

    def document(self, name: str) -> Any:
        """Return the plain data of a file, to be changed."""
        if name not in self._documents:
            if name not in self._kept.texts:
                self._kept.texts[name] = json.dumps(self._inputs.plain(name))
            self._documents[name] = json.loads(self._kept.texts[name])
        return self._documents[name]

    @property
    def inputs(self) -> Inputs:
        """The documents and tables as they are now, and all else as it is."""
        return _Moved(self._inputs, self._documents, self.written, self._kept)

    @property
    def job(self) -> Job:
        """The command on these inputs, with nobody at its console."""
        return Job(self.case.COMMAND, (), Listener(), self.inputs)

    @property
    def files(self) -> dict[str, bytes]:
        """The files that are not as they lie on disk, by name: those, and fields that documents hand on."""
        written = {
            name: dump_toml(data) if name.endswith(".toml") else json.dumps(data).encode()
            for name, data in self._documents.items()
        }
        given = dict(self._inputs.given) | written | self.written
        return given | moved_fields(self._inputs, self.handed)


class _Moved(Inputs):
    """Inputs whose documents are there as plain data: nothing is written to be read again, and what does not change is
    read once."""

    def __init__(self, inputs: Inputs, documents: dict[str, Any], written: dict[str, bytes], kept: Kept) -> None:
        super().__init__()
        self._inputs, self._documents, self._written, self._kept = inputs, documents, written, kept

    def plain(self, name: str) -> Any:
        return self._documents[name] if name in self._documents else super().plain(name)

    def parsed(self, name: str, kind: object, parse: Callable[[Any], Parsed]) -> Parsed:
        """Return a document; one that does not change is the same each time."""
        if name in self._documents or name in self._written:
            return super().parsed(name, kind, parse)
        if (name, kind) not in self._kept.documents:
            self._kept.documents[name, kind] = super().parsed(name, kind, parse)
        return self._kept.documents[name, kind]

    def read(self, name: str, limit: int = MAX_BYTES) -> bytes:
        return self._written[name] if name in self._written else self._inputs.read(name, limit)


def inside(data: Any, place: Place) -> Any:
    """Return what stands at a place of plain data."""
    for step in place:
        data = data[step]
    return data


def there(data: Any, place: Place) -> bool:
    """Whether anything does."""
    try:
        inside(data, place)
    except (KeyError, IndexError, TypeError):
        return False
    return True
