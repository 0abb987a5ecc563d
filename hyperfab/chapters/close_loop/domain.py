"""What the loop is given, and which domain a model document belongs to."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from hyperfab.cases.loop import LoopCase
from hyperfab.chapters.fit.prepare import Steps
from hyperfab.chapters.job import Job
from hyperfab.documents.base import Document, told_format
from hyperfab.errors import InputError, UsageError
from hyperfab.io.json_io import dump_json
from hyperfab.io.layout import Layout
from hyperfab.io.specimen import Geometry
from hyperfab.loop.thresholds import PRIOR


@dataclass(frozen=True)
class How:
    """How tests of a fabric are to be read: which test each file is where an option says it, sizes, chosen rows."""

    kinds: Mapping[str, str] = field(default_factory=dict)
    sizes: Geometry = field(default_factory=Geometry)
    steps: Steps = field(default_factory=Steps)

    def check(self, what: str) -> None:
        """UsageError where something of it is said of a model that is no fabric; where a push counts from may be."""
        pushed = what in ("contact", "press")
        if replace(self, steps=replace(self.steps, zero=False, preload=None) if pushed else self.steps) != How():
            raise UsageError(
                f"--uniaxial, sizes, --branch and their like are for tests of a fabric, and the model is a {what}"
            )


@dataclass(frozen=True)
class Given:
    """What each domain is given.

    data    the plain document of the model that ``case`` names
    layout  how tables are to be read, and ``how`` tests of a fabric
    """

    data: Mapping[str, Any]
    case: LoopCase
    layout: Layout
    how: How

    @property
    def surely(self) -> float:
        """The stated relative standard deviation of the model's own constants, or what is taken for constants of which
        something is always known."""
        return PRIOR if self.case.prior is None else self.case.prior


def signed(job: Job, given: Given, document: Document, target: str) -> bytes:
    """Return a document that the loop on a sheet or a press writes beside ``target``, with the loop's own set-up."""
    return dump_json(job.stated(document, target, given.case, prior=given.surely))


def kind_of(job: Job, name: str) -> tuple[str, Mapping[str, Any]]:
    """Return the kind of a model document and its plain data; InputError where it does not say what it is."""
    data = job.inputs.plain(name)
    if not isinstance(data, Mapping):
        raise InputError("is not a document: its top level is not an object", file=name)
    told = told_format(data.get("format"))
    if told is None:
        raise InputError(
            "does not say what it is",
            file=name,
            key="format",
            remedy='a model has "format": "hyperfab.material/1", or is a mold.toml, contact, drape or press document',
        )
    return told[0], data
