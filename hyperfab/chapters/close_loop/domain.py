"""What the loop is given, and which domain a model document belongs to."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from hyperfab.chapters.close_loop.recall import Parse
from hyperfab.chapters.job import Job
from hyperfab.errors import InputError
from hyperfab.io.json_io import load_json
from hyperfab.io.toml_io import load_toml


@dataclass(frozen=True)
class Given:
    """What the command line gives each domain: ``data`` is the plain document read from the file ``name``.

    ``prior`` is the relative standard deviation of the model's own constants, where it is stated. ``parse`` reads the
    words of another command's line, for documents that are models by how they were made.
    """

    name: str
    data: Mapping[str, Any]
    measured: list[str]
    hold_out: list[str]
    noise: str | None
    fix: list[str]
    prior: float | None
    decimal: str | None
    output: str
    parse: Parse

    @property
    def held(self) -> list[str]:
        """The files of ``--hold-out``; ``auto`` is none."""
        return [file for file in self.hold_out if file != "auto"]


def kind_of(job: Job, name: str) -> tuple[str, Mapping[str, Any]]:
    """Return the kind of a model document and its plain data; InputError where it does not say what it is."""
    raw = job.inputs.read(name)
    data = load_toml(raw, name) if name.endswith(".toml") else load_json(raw, name)
    if not isinstance(data, Mapping):
        raise InputError("is not a document: its top level is not an object", file=name)
    found = data.get("format")
    match = re.fullmatch(r"hyperfab\.([a-z-]+)/([0-9]{1,6})", found) if isinstance(found, str) else None
    if match is None:
        raise InputError(
            "does not say what it is",
            file=name,
            key="format",
            remedy='a model has "format": "hyperfab.material/1", or is a mold.toml, contact, drape or press document',
        )
    return match[1], data
