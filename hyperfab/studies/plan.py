"""A study made into work: the steps of each case, each known by the hash of all that decides its result."""

from __future__ import annotations

import copy
import functools
import hashlib
import json
import os
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import hyperfab
from hyperfab.documents.study import DocumentSection, StepSection, StudyDocument
from hyperfab.errors import HyperfabError, InputError, placed
from hyperfab.io.inputs import Inputs
from hyperfab.io.json_io import dump_json, load_json
from hyperfab.io.text import map_texts
from hyperfab.io.toml_io import dump_toml, load_toml
from hyperfab.studies.axes import Axis, Layout
from hyperfab.studies.template import fill, names

#: Digits of a hash that name a step or a case: 128 bits.
DIGITS = 32
#: Stands in arguments for the folder of all steps, which each worker knows.
STEPS = "{steps}"
#: Stands in arguments for the step's own folder.
HERE = "{here}"


@dataclass(frozen=True)
class Step:
    """One command to run: what it is known by, what it needs, and all a worker must have to run it.

    ``words`` are its arguments; STEPS and HERE in them stand for folders. ``documents`` are written into the
    step's folder before it runs. ``files`` are those that it is known by, named in its arguments, in ``documents`` and
    in these files themselves.
    """

    key: str
    name: str
    command: str
    words: tuple[str, ...]
    documents: tuple[tuple[str, bytes], ...]
    needs: tuple[str, ...]
    files: tuple[Seen, ...] = ()

    @property
    def changed(self) -> str | None:
        """The first of its files that is no longer what it is known by, if there is one."""
        return next((file.path for file in self.files if not file.is_as_read), None)


class Seen(NamedTuple):
    """A file as a study read it: where, how many bytes, when it was written, and its hash."""

    path: str
    size: int
    written_ns: int
    sha256: str

    @property
    def is_as_read(self) -> bool:
        """Whether it still holds the same; it is only read again where it was written meanwhile."""
        try:
            now = os.stat(self.path)
            if (now.st_size, now.st_mtime_ns) == (self.size, self.written_ns):
                return True
            return hashlib.sha256(Path(self.path).read_bytes()).hexdigest() == self.sha256
        except OSError:
            return False


@dataclass(frozen=True)
class Case:
    """One row of the study: its values, its steps in the order of the chain."""

    key: str
    values: Mapping[str, float | int | bool | str]
    steps: tuple[Step, ...]


class Plan:
    """All cases of a study. They are made when asked for: a study of a million cases takes no memory for them."""

    def __init__(self, study: StudyDocument, file: str, inputs: Inputs) -> None:
        self.study = study
        self.file = file
        self.layout = Layout(study, file)
        self.files = FileKnowledge(os.path.dirname(file), inputs)
        with placed(file):
            self._sources = {name: self._source(name, part, inputs) for name, part in study.document.items()}
            self._uses = {step.name: self._used(step) for step in study.step}

    @property
    def axes(self) -> list[Axis]:
        """The axes, in the order of the study."""
        return self.layout.axes

    def __len__(self) -> int:
        return len(self.layout)

    def __iter__(self) -> Iterator[Case]:
        return (self.case(index) for index in range(len(self)))

    def case(self, index: int) -> Case:
        """Return case ``index``; InputError naming the key of the study where its braces cannot be filled."""
        levels = self.layout.case(index)
        texts = {name: level.text for name, level in levels.items()}
        numbers = {name: level.number for name, level in levels.items()}
        steps: dict[str, Step] = {}
        for position, section in enumerate(self.study.step):
            with placed(self.file):
                steps[section.name] = self._step(position, section, texts, numbers, steps)
        key = _hash({"values": texts, "steps": [step.key for step in steps.values()]})
        return Case(key, {name: level.value for name, level in levels.items()}, tuple(steps.values()))

    def edited(self, name: str) -> dict[str, Any]:
        """Return document ``name`` as the first case edits it, its files by absolute path."""
        levels = self.layout.case(0)
        texts = {axis: level.text for axis, level in levels.items()}
        with placed(self.file):
            document = self._edit(name, texts, {axis: level.number for axis, level in levels.items()})
        return document

    def _source(self, name: str, section: DocumentSection, inputs: Inputs) -> dict[str, Any]:
        path = Inputs.beside(self.file, section.source)
        loaded = inputs.plain(path)
        if not isinstance(loaded, dict):
            raise InputError("is not a document: its top level is not an object", file=path)
        folder = os.path.dirname(os.path.abspath(path))
        # The edited copy lies elsewhere: what it names is named from anywhere.
        found: dict[str, Any] = map_texts(loaded, lambda text: self.files.whole(text, folder))
        for key in section.set:
            targets(found, key, f"document.{name}.set")
        return found

    def _used(self, step: StepSection) -> tuple[list[str], list[str]]:
        """Return the documents and the earlier steps that a step uses; InputError for a name that is neither."""
        earlier = [other.name for other in self.study.step[: self.study.step.index(step)]]
        documents, steps = [], []
        for text in step.arguments:
            with placed(key=f"step {step.name}.arguments"):
                used = list(names(text))
            for name in used:
                if name in self.study.document:
                    documents.append(name)
                elif name in earlier:
                    steps.append(name)
                elif name not in self.study.axis:
                    known = [*self.study.axis, *self.study.document, *earlier]
                    raise InputError(
                        f"{{{name}}} is no axis, document or earlier step",
                        key=f"step {step.name}.arguments",
                        remedy=f"there is {', '.join(known)}",
                    )
        return sorted(set(documents)), sorted(set(steps))

    def _step(
        self,
        position: int,
        section: StepSection,
        texts: Mapping[str, str],
        numbers: Mapping[str, float | int | None],
        earlier: Mapping[str, Step],
    ) -> Step:
        documents, steps = self._uses[section.name]
        edited = {name: self._edit(name, texts, numbers) for name in documents}
        used: set[str] = set()
        known = {name: _hash(self._known(document, used)) for name, document in edited.items()}
        symbols = {name: f"{{document {digest}}}" for name, digest in known.items()}
        symbols |= {name: f"{{step {earlier[name].key}}}" for name in steps}
        places = {name: f"{HERE}/{self._file_name(name)}" for name in documents}
        keys = {name: earlier[name].key for name in steps}
        places |= {name: f"{STEPS}/{key[:2]}/{key}/{name}.json" for name, key in keys.items()}
        words, identity = [], []
        for text in section.arguments:
            with placed(key=f"step.{position}.arguments", remedy="correct the braces"):
                word = fill(text, {**texts, **places}, numbers)
                symbol = fill(text, {**texts, **symbols}, numbers)
            found = self.files.find(word)
            words.append("".join(found or word))
            identity.append(symbol if found is None else self._file(found, used))
        key = _hash({"hf": program(), "command": section.command, "arguments": identity})
        needs = tuple(sorted(earlier[name].key for name in steps))
        files = {self._file_name(name): document for name, document in edited.items()}
        written = tuple(
            (name, dump_toml(document) if name.endswith(".toml") else dump_json(document))
            for name, document in files.items()
        )
        return Step(key, section.name, section.command, tuple(words), written, needs, self.files.seen(used))

    def _file_name(self, name: str) -> str:
        """Return the name of an edited document: commands tell a model by its ending."""
        return name + os.path.splitext(self.study.document[name].source)[1]

    def _edit(self, name: str, texts: Mapping[str, str], numbers: Mapping[str, float | int | None]) -> dict[str, Any]:
        section = self.study.document[name]
        document = copy.deepcopy(self._sources[name])
        place = f"document.{name}.set"

        def put(text: str) -> str:
            return self.files.whole(fill(text, texts, numbers))

        for key, value in section.set.items():
            with placed(key=f"{place}.{key}"):
                new = map_texts(value, put)
            if isinstance(new, str) and new != value and not isinstance(value, dict):
                new = _bare(new)
            for holder, last in targets(document, key, place):
                holder[last] = copy.deepcopy(new)
        return document

    def _known(self, document: Any, used: set[str]) -> Any:
        """Return a document with what its files hold in place of where they are; they are noted in ``used``."""

        def known(text: str) -> str:
            found = self.files.find(text) if os.path.isabs(text) else None
            return text if found is None else self._file(found, used)

        return map_texts(document, known)

    def _file(self, found: Named, used: set[str]) -> str:
        used.add(found.path)
        ending, digest = os.path.splitext(found.path)[1], self.files.digest(found.path)
        return f"{found.before}{{file {ending} {digest}}}{found.behind}"


def targets(document: dict[str, Any], dotted: str, place: str) -> list[tuple[Any, Any]]:
    """Return (holder, key) of every place that a dotted key names; InputError where it names none.

    >>> targets({"heater": [{"power": "1 W"}]}, "heater.*.power", "set")
    [({'power': '1 W'}, 'power')]
    """
    parts = dotted.split(".")
    holders: list[Any] = [document]
    for depth, part in enumerate(parts):
        found: list[tuple[Any, Any]] = []
        for holder in holders:
            if isinstance(holder, list) and part == "*":
                found += [(holder, index) for index in range(len(holder))]
            elif isinstance(holder, list) and part.isdecimal() and int(part) < len(holder):
                found.append((holder, int(part)))
            elif isinstance(holder, dict) and (part in holder or depth == len(parts) - 1):
                found.append((holder, part))
        if not found:
            raise InputError(
                f"{dotted}: there is no {'.'.join(parts[: depth + 1])} in the document",
                key=place,
                remedy="list items are counted from 0, * means all of them",
            )
        if depth == len(parts) - 1:
            return found
        holders = [holder[key] for holder, key in found]
    return []


def _bare(text: str) -> Any:
    """A value that is a number or a truth value, alone in its braces, is one in the document too."""
    try:
        value = json.loads(text)
    except ValueError:
        return text
    return value if isinstance(value, (int, float, bool)) else text


def _hash(value: object) -> str:
    text = json.dumps(value, sort_keys=True, separators=(",", ":"))
    return hashlib.sha256(text.encode()).hexdigest()[:DIGITS]


#: A word that names a file with its option before it, or with what is meant of it behind: ``--mold=cup.stl``,
#: ``tests.xlsx:warp``, ``heat.json:plate``.
_NAMING = re.compile(r"(--[a-z][a-z0-9-]*=)?(.+?)((?<=\.json|\.xlsx):[^/\\:]+)?", re.DOTALL)


class Named(NamedTuple):
    """A file that a word names: the option before it, its absolute path, and what is meant of it behind."""

    before: str
    path: str
    behind: str


#: Documents may name documents; nobody nests them deeper.
_MAX_DEPTH = 8


class FileKnowledge:
    """What is known of the files of a study. Each is read once; a step whose file changes while it runs is not kept."""

    def __init__(self, folder: str, inputs: Inputs) -> None:
        self.folder = os.path.abspath(folder)
        self._inputs = inputs
        self._hashes: dict[str, str] = {}
        self._seen: dict[str, Seen] = {}
        self._inside: dict[str, set[str]] = {}

    def find(self, text: str, folder: str | None = None) -> Named | None:
        """Return the file that ``text`` names, seen from ``folder`` (the study's), if there is such a file."""
        if not text or len(text) > 1000 or "\n" in text or "\0" in text:
            return None
        parted = _NAMING.fullmatch(text)
        assert parted is not None  # any text but an empty one has a middle
        for before, name, behind in (("", text, ""), (parted[1] or "", parted[2], parted[3] or "")):
            path = os.path.normpath(os.path.join(folder or self.folder, name))
            if os.path.isfile(path):
                return Named(before, path, behind)
        return None

    def whole(self, text: str, folder: str | None = None) -> str:
        """Return ``text`` with the file that it names named from anywhere."""
        return "".join(self.find(text, folder) or text)

    def digest(self, path: str, depth: int = 0) -> str:
        """Return the hash of a file and of every file that it names, if it is a document."""
        if path not in self._hashes:
            before = os.stat(path)
            data = self._inputs.read(path)
            whole = hashlib.sha256(data)
            self._seen[path] = Seen(path, before.st_size, before.st_mtime_ns, whole.hexdigest())
            if path.endswith((".toml", ".json")) and depth < _MAX_DEPTH:
                self._hashes[path] = ""  # a document that names itself ends here
                self._inside[path] = self._named(data, path)
                for name in sorted(self._inside[path]):
                    whole.update(self.digest(name, depth + 1).encode())
            self._hashes[path] = whole.hexdigest()
        return self._hashes[path]

    def seen(self, paths: Iterable[str]) -> tuple[Seen, ...]:
        """Return files whose hash was asked for as they were read, with those that documents among them name."""
        found: dict[str, Seen] = {}
        left = list(paths)
        while left:
            path = left.pop()
            if path not in found:
                found[path] = self._seen[path]
                left += self._inside.get(path, ())
        return tuple(found[path] for path in sorted(found))

    def _named(self, data: bytes, path: str) -> set[str]:
        try:
            loaded = load_toml(data, path) if path.endswith(".toml") else load_json(data, path)
        except HyperfabError:
            return set()  # the step that reads it will say what is wrong with it
        found: set[str] = set()

        def note(text: str) -> str:
            place = self.find(text, os.path.dirname(path))
            if place is not None:
                found.add(place.path)
            return text

        map_texts(loaded, note)
        return found


@functools.cache
def program() -> str:
    """Return the version and, behind a +, the hash of all of the package's sources.

    In a tree that is worked on the sources change under the same version, and with them what a step would find.
    """
    whole = hashlib.sha256()
    root = Path(hyperfab.__file__).parent
    for path in sorted(root.rglob("*.py"), key=lambda path: path.relative_to(root).parts):
        data = path.read_bytes()
        whole.update(f"{path.relative_to(root).as_posix()} {len(data)}\n".encode())
        whole.update(data)
    return f"{hyperfab.__version__}+{whole.hexdigest()[:16]}"
