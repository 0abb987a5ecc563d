"""The document upstream that is put right as it is written, and the commands that make the model from it again."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

from hyperfab.cases.case import Case
from hyperfab.cases.kinds import File
from hyperfab.chapters.close_loop.domain import Given, signed
from hyperfab.chapters.close_loop.extended_mold import relocate
from hyperfab.chapters.job import Job
from hyperfab.chapters.rerun import command_line, rerun
from hyperfab.documents.base import parse_document
from hyperfab.documents.material import MaterialDocument
from hyperfab.io.inputs import Inputs
from hyperfab.io.json_io import dump_json, load_json
from hyperfab.io.output import Output
from hyperfab.io.toml_io import dump_toml, load_toml

#: The sandwich that takes its fabric from the document put right.
_FOAM = ".upstream.foam.toml"
#: Endings of what is written.
WRITTEN = (
    *(
        f".upstream{end}"
        for end in (
            ".json", ".toml", ".stl", ".vtu", ".[0-9]*.vtu", ".pvd", ".csv", ".png", ".formed.png", ".mold.stl",
            ".design.stl", ".compensated.stl",
        )
    ),
    _FOAM,
)  # fmt: skip


@dataclass(frozen=True)
class Corrected:
    """A chain put right: the ``case`` of the model and ``files`` that are not as they lie there, by name; the bytes of
    the ``document`` that was at fault (None: it is ``made`` by a case of its own, or is the model itself).

    The ``command`` makes the model from it again, None where no input says what was put right; before it those are run
    that make the documents between, by the name of each. A ``sandwich`` names the document too, by its fabric.
    """

    case: Case
    files: Mapping[str, bytes]
    document: bytes | None
    command: Case | None
    made: Case | None = None
    between: Mapping[str, Case] = field(default_factory=dict)
    sandwich: str | None = None


def write(job: Job, given: Given, out: Output, document: str, corrected: Corrected) -> tuple[str | None, list[str]]:
    """Queue the corrected ``document``; return its name and the commands that make the model from it, if any.

    What a command makes for the next one lies beside it, by the name that it has in both.
    """
    if corrected.command is None:
        return None, []
    name = _queue(job, given, out, document, corrected)
    names = {document: name}
    if corrected.sandwich is not None:
        names[corrected.sandwich] = str(out.path(_FOAM))
        out.add(_FOAM, _taking(job.inputs.read(corrected.sandwich), corrected.sandwich, document, names))
    commands = []
    for file, case in corrected.between.items():
        names[file] = str(out.path(f".upstream.{Path(file).stem}.json"))
        given_to = _renamed(case, names)
        commands.append(command_line(given_to, name, names.values(), "-o", os.path.basename(names[file])))
    commands.append(command_line(_renamed(corrected.command, names), name, names.values()))
    return os.path.basename(name), commands


def _queue(job: Job, given: Given, out: Output, document: str, corrected: Corrected) -> str:
    """Queue the corrected document as it is written; return its path."""
    if corrected.document is None:
        target = str(out.path(".upstream.json"))
        made = rerun(corrected.made or corrected.command or corrected.case, target)
        out.add(".upstream.json", dump_json(made.document))
        for suffix, data in made.siblings.items():
            out.add(f".upstream{suffix}", data)
        return target
    ending = os.path.splitext(document)[1].lower()
    suffix = f".upstream{ending if ending in ('.toml', '.stl') else '.json'}"
    name = str(out.path(suffix))
    if suffix.endswith(".stl"):
        data = corrected.document
    elif suffix.endswith(".toml"):
        data = _relocated(corrected.document, document, name)
    else:
        parsed = parse_document(load_json(corrected.document, name), name, MaterialDocument)
        data = signed(job, given, parsed, name)
    out.add(suffix, data)
    return name


def _renamed(case: Case, names: Mapping[str, str]) -> Case:
    """Return a case that takes files by their new names."""

    def new(value: object) -> object:
        if isinstance(value, tuple):
            return tuple(map(new, value))
        if not isinstance(value, str):
            return value
        file, part = File.parted(value)
        return names[file] + part if file in names else value

    asked = {one.name: getattr(case, one.name) for one in case.settings().values()}
    return replace(case, **{key: new(value) for key, value in asked.items()})


def _relocated(data: bytes, old: str, new: str) -> bytes:
    """Return a document whose tables and documents are counted from where it is written now."""
    plain = load_toml(data, old)
    relocate(plain, (os.path.dirname(old), os.path.dirname(new)))
    return dump_toml(plain)


def _taking(data: bytes, sandwich: str, document: str, names: Mapping[str, str]) -> bytes:
    """Return a sandwich whose layers are of the document as it is written now."""
    plain = load_toml(data, sandwich)
    layers = plain["fabric"]
    here = [key for key in ("above", "below") if names_layer(layers.get(key), sandwich, document)]
    folder = os.path.dirname(names[sandwich])
    relocate(plain, (os.path.dirname(sandwich), folder))
    layers.update(dict.fromkeys(here, os.path.relpath(names[document], folder or ".")))
    return dump_toml(plain)


def names_layer(text: object, sandwich: str, document: str) -> bool:
    """Whether a layer of a sandwich is told by that document."""
    return isinstance(text, str) and os.path.normpath(Inputs.beside(sandwich, text)) == os.path.normpath(document)
