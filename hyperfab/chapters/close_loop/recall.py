"""A contact, drape or press document as a model: its inputs must be those it was made from."""

from __future__ import annotations

import os
from collections.abc import Iterable
from typing import Any, TypeVar

from hyperfab.cases.case import Case
from hyperfab.cases.like import Earlier
from hyperfab.chapters.job import Job
from hyperfab.errors import InputError

CaseT = TypeVar("CaseT", bound=Case)


def unchanged(made: Earlier[CaseT]) -> Earlier[CaseT]:
    """Return how a model was made; InputError where an input of it has changed since."""
    for name in made.changed:
        raise _changed(name, made)
    return made


def check_unchanged(job: Job, made: Earlier[Any], besides: Iterable[str]) -> None:
    """Refuse files read for the model that are not those it was made from; ``besides`` were read for other ends."""
    other = {made.name, *besides}
    known = set(made.read.values())
    for file in job.inputs.files:
        if file.name not in other and file.sha256 not in known:
            raise _changed(file.name, made)


def _changed(file: str, made: Earlier[Any]) -> InputError:
    return InputError(
        f"has changed since {made.name} was made from it",
        file=file,
        remedy=f"make {os.path.basename(made.name)} again with hf {made.cls.COMMAND}",
    )
