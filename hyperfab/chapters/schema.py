"""``hf schema KIND``: print the JSON Schema of a kind of document."""

from __future__ import annotations

from hyperfab.chapters.job import Job
from hyperfab.documents.base import schema
from hyperfab.io.json_io import dump_json
from hyperfab.io.output import write_stdout


def run(job: Job, *, kind: str) -> int:
    """Print the schema; UsageError names the known kinds where ``kind`` is none of them."""
    write_stdout(dump_json(schema(kind)))
    return 0
