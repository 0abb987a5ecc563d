"""``hf schema KIND``: print the JSON Schema of a kind of document."""

from __future__ import annotations

from hyperfab.cases.about import SchemaCase
from hyperfab.cases.registry import CASES, MADE_BY, case_class
from hyperfab.chapters.job import Job
from hyperfab.documents.base import schema
from hyperfab.io.json_io import dump_json
from hyperfab.io.output import write_stdout


def run(job: Job, case: SchemaCase) -> int:
    """Print the schema; UsageError names the known kinds where this is none of them."""
    found = schema(case.kind)
    command = MADE_BY.get(case.kind)
    if command in CASES:
        found["properties"]["setup"] = {"allOf": [found["properties"].get("setup", {}), case_class(command).schema()]}
    write_stdout(dump_json(found))
    return 0
