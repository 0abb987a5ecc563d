"""Which domain a model document belongs to."""

from __future__ import annotations

import re
from collections.abc import Mapping

from hyperfab.chapters.job import Job
from hyperfab.errors import InputError
from hyperfab.io.json_io import load_json
from hyperfab.io.toml_io import load_toml


def kind_of(job: Job, name: str) -> tuple[str, Mapping[str, object]]:
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
