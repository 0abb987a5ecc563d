"""Sources that documents hand on: known again by what they are, so that one that acts twice down the chain is one."""

from __future__ import annotations

import hashlib
import json
import math
import os
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from hyperfab.cases.case import Case
from hyperfab.chapters.field import HANDED, derivatives, read_field, read_handing
from hyperfab.chapters.job import Job
from hyperfab.chapters.uncertainty.changed import Changed
from hyperfab.chapters.uncertainty.sources import Number, Origin, Origins
from hyperfab.documents.uncertainty import SourceNumber, SourcePart
from hyperfab.io.inputs import Inputs
from hyperfab.numerics.propagation import Source

#: So much of a file's SHA-256 tells it from all others.
_DIGITS = 16


@dataclass(frozen=True)
class Handed:
    """A number that the fields of documents go with: ``at``, by the document's name its place among their numbers;
    ``own`` is the same number where this command reads it too."""

    name: str
    at: Mapping[str, int]
    own: Number | None = None
    file: str | None = None

    def move(self, inputs: Changed[Any], change: float) -> None:
        for document, index in self.at.items():
            changes = inputs.handed.setdefault(document, {})
            changes[index] = changes.get(index, 0.0) + change
        if self.own is not None:
            self.own.move(inputs, change)


def identified(found: Origins, case: Case, job: Job) -> None:
    """Give each number the id by which later commands know it: of its file's bytes, or of the command's set-up."""
    # The document of --like says what is run and is no part of it: the same set-up gives the same ids.
    like = None if job.like is None else job.like.name
    hashes = {file.name: file.sha256 for file in job.inputs.files if file.name != like}
    setup = json.dumps([case.COMMAND, case.setup(hashes), sorted(hashes.values())], sort_keys=True, default=str)
    of_setup = hashlib.sha256(setup.encode()).hexdigest()

    def id_of(number: Number) -> str:
        digest = of_setup if number.file is None else hashes[number.file]
        return f"{digest[:_DIGITS]}: {number.name.partition(': ')[2] or number.name}"

    found.found = [
        one if one.ids else replace(one, ids=tuple(id_of(number) for number in one.numbers)) for one in found.found
    ]


def join(found: Origins, inputs: Inputs, documents: Iterable[str]) -> None:
    """Add the sources of ``documents`` whose fields the command takes; what it already has becomes one with them."""
    silent = []
    for name in dict.fromkeys(documents):
        document = read_handing(inputs, name)
        told = document.uncertainty
        if told is None:
            silent.append(name)
            continue
        known = HANDED[document.KIND][0]
        if known not in told.handed or not derivatives(read_field(inputs, name, document), known):
            silent.append(name)
            continue
        at = 0
        for part in told.sources:
            _add(found, part, name, at)
            at += len(part.numbers)
    if found.found:
        found.left_out += [f"{os.path.basename(name)}: how its field goes with its inputs" for name in silent]


def _add(found: Origins, part: SourcePart, document: str, start: int) -> None:
    """Add one source of a document, whose numbers begin at ``start`` among its own."""
    ids = tuple(number.id for number in part.numbers)
    for place, one in enumerate(found.found):
        if one.ids == ids:
            numbers = tuple(
                replace(number, at={**number.at, document: start + k})
                if isinstance(number, Handed)
                else Handed(number.name, {document: start + k}, number)
                for k, number in enumerate(one.numbers)
            )
            found.found[place] = replace(one, numbers=numbers)
            return
    sd = np.array([number.sd for number in part.numbers])
    correlation = np.eye(len(sd)) if part.correlation is None else np.array(part.correlation)
    freedom = math.inf if part.degrees_of_freedom is None else part.degrees_of_freedom
    source = Source(part.source, correlation * np.outer(sd, sd), freedom)
    handed = tuple(Handed(number.name, {document: start + k}) for k, number in enumerate(part.numbers))
    found.found.append(Origin(source, handed, ids))


def described(one: Origin) -> SourcePart:
    """Return a source as documents tell it."""
    sd = np.sqrt(np.diag(one.source.covariance))
    more: dict[str, Any] = {}
    if len(sd) > 1:
        scale = np.where(sd > 0.0, sd, 1.0)
        correlation = one.source.covariance / np.outer(scale, scale)
        np.fill_diagonal(correlation, 1.0)
        more["correlation"] = correlation.tolist()
    if np.isfinite(one.source.freedom):
        more["degrees_of_freedom"] = one.source.freedom
    numbers = [
        SourceNumber(id=identity, name=number.name, sd=float(size))
        for identity, number, size in zip(one.ids, one.numbers, sd, strict=True)
    ]
    return SourcePart(source=one.source.name, numbers=numbers, **more)
