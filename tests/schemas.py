"""Documents held to the schema of their kind, each of which is itself checked once: that takes most of the time."""

from __future__ import annotations

from functools import cache
from typing import Any

from jsonschema.exceptions import best_match
from jsonschema.validators import validator_for

from hyperfab.documents.base import schema


@cache
def _validator(kind: str) -> Any:
    found = schema(kind)
    made = validator_for(found)
    made.check_schema(found)
    return made(found)


def follows_schema(document: Any, kind: str) -> None:
    """Raise ValidationError where a document is none of its ``kind``, as ``jsonschema.validate`` does."""
    if error := best_match(_validator(kind).iter_errors(document)):
        raise error
