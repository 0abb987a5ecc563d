"""Where a document comes from: version, command, arguments, and the hash of every input.

No clock, host or absolute path, so that the same inputs give the same bytes.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Sequence

from pydantic import BaseModel, ConfigDict, Field

from hyperfab import __version__
from hyperfab.io.inputs import InputFile

#: An input further away than this many folders up is known by its bare name: its path would tell the machine's layout.
MAX_FOLDERS_UP = 3


class InputRecord(BaseModel):
    """One input file: its path relative to the document, and the SHA-256 of its bytes."""

    model_config = ConfigDict(extra="allow")

    name: str
    sha256: str = Field(pattern="^[0-9a-f]{64}$")


class Provenance(BaseModel):
    """How a document came to be."""

    model_config = ConfigDict(extra="allow")

    hf: str = Field(description="version of hf that wrote the document")
    command: str = Field(description="the command, for example fit")
    arguments: list[str] = Field(description="the options as given, without those that name the output")
    inputs: list[InputRecord] = Field(description="every file that was read")


def record(command: str, arguments: Sequence[str], inputs: Iterable[InputFile], target: str) -> Provenance:
    """Return the provenance of a document written to ``target`` (``-``: standard output)."""
    files = list(inputs)
    names = {file.name: relative_name(file.name, target) for file in files}
    shown = [relative_name(text, target) if os.path.isabs(text) else names.get(text, text) for text in arguments]
    inputs_seen = [InputRecord(name=names[file.name], sha256=file.sha256) for file in files]
    return Provenance(hf=__version__, command=command, arguments=shown, inputs=inputs_seen)


def relative_name(name: str, target: str) -> str:
    """Return the name of a file as seen from the folder of the document ``target``.

    A place that shares no folder with the document, or was named by an absolute path and does not lie in the
    folder or beside it, is known by its base name alone.

    >>> relative_name("specimens/warp.csv", "build/fit.json")
    '../specimens/warp.csv'
    >>> relative_name("/somewhere/else/warp.csv", "fit.json")
    'warp.csv'
    """
    if name == "-":
        return name
    folder = os.path.abspath(os.path.dirname(target) if target != "-" else ".")
    place = os.path.abspath(name)
    try:
        shared = os.path.commonpath([folder, place])
    except ValueError:  # two drives
        return os.path.basename(place)
    if shared == os.path.dirname(shared):  # the root alone
        return os.path.basename(place)
    seen = os.path.relpath(place, folder)
    furthest = 1 if os.path.isabs(name) else MAX_FOLDERS_UP
    return os.path.basename(place) if seen.split(os.sep).count(os.pardir) > furthest else seen
