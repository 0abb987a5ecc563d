"""``study.toml``: a chain of commands, the axes it is run over, and the figures to collect."""

from __future__ import annotations

import math
import re
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field, field_validator, model_validator

from hyperfab.documents.base import HandWritten, MisfitError, Section

#: Names of axes, steps and documents, as they stand in {braces}.
_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_-]{0,39}")

Value = bool | int | float | str
Number = int | float | str


class Span(Section):
    """From one value to another, both included."""

    first: Number = Field(alias="from")
    last: Number = Field(alias="to")
    count: Annotated[int, Field(ge=2, le=10**6)]


class Between(Section):
    """A uniform distribution."""

    first: Number = Field(alias="from")
    last: Number = Field(alias="to")


class Normal(Section):
    """A normal distribution."""

    mean: Number
    sd: Number


class Lognormal(Section):
    """A lognormal distribution: its median, and the factor that is one standard deviation."""

    median: Number
    factor: Annotated[float, Field(gt=1.0)]


class AxisSection(Section):
    """One axis of the study: listed values, a range, or a distribution to draw from."""

    values: list[Value] | None = None
    range: Span | None = None
    log_range: Span | None = None
    uniform: Between | None = None
    log_uniform: Between | None = None
    normal: Normal | None = None
    lognormal: Lognormal | None = None

    @model_validator(mode="after")
    def _one_way(self) -> AxisSection:
        given = [name for name in type(self).model_fields if getattr(self, name) is not None]
        if len(given) != 1:
            raise ValueError(f"an axis is exactly one of {', '.join(type(self).model_fields)}")
        if self.values == []:
            raise ValueError("the axis is empty: a study over it has no case; give it values")
        return self

    @property
    def count(self) -> int:
        """How many listed values there are; 1 where they are drawn."""
        span = self.range or self.log_range
        return span.count if span is not None else len(self.values or [0])

    @property
    def drawn(self) -> bool:
        """Whether values are drawn from a distribution."""
        return not (self.values or self.range or self.log_range)


class SamplingSection(Section):
    """How the axes with a distribution are drawn, all together."""

    method: Literal["random", "latin-hypercube", "sobol"] = "random"
    count: Annotated[int, Field(ge=1)]
    seed: Annotated[int, Field(ge=0)]


class DocumentSection(Section):
    """A document that the study edits for each case."""

    source: str = Field(alias="from", description="the document to start from, relative to the study")
    set: dict[str, Any] = Field(default_factory=dict, description="dotted key (list items by number, or *): value")


class StepSection(Section):
    """One command of the chain."""

    name: str
    command: str
    arguments: list[str] = Field(default=[])


class ParetoSection(Section):
    """Two figures that pull against each other."""

    minimize: list[str] = Field(default=[])
    maximize: list[str] = Field(default=[])

    @model_validator(mode="after")
    def _two(self) -> ParetoSection:
        if len(self.minimize) + len(self.maximize) != 2:
            raise ValueError("a Pareto front is of two figures; name two under minimize and maximize")
        return self


class LimitSection(Section):
    """What a figure must keep to; cases that do not are marked."""

    least: float | None = None
    most: float | None = None

    @model_validator(mode="after")
    def _one(self) -> LimitSection:
        if self.least is None and self.most is None:
            raise ValueError("a limit has least, most, or both")
        return self


class StudyDocument(HandWritten):
    """Many runs of one chain."""

    KIND: ClassVar[str] = "study"

    name: str
    question: str = ""
    axis: dict[str, AxisSection] = Field(min_length=1)
    sampling: SamplingSection | None = None
    document: dict[str, DocumentSection] = Field(default_factory=dict)
    step: list[StepSection] = Field(min_length=1)
    figures: dict[str, str] = Field(min_length=1, description="column of the table: STEP.key of its document")
    limit: dict[str, LimitSection] = Field(default_factory=dict)
    pareto: ParetoSection | None = None

    @field_validator("axis", "document")
    @classmethod
    def _plain_names(cls, value: dict[str, Any]) -> dict[str, Any]:
        for name in value:
            _check_name(name)
        return value

    @model_validator(mode="after")
    def _fits_together(self) -> StudyDocument:
        names = [*self.axis, *self.document, *(step.name for step in self.step)]
        for name in names:
            _check_name(name)
            if names.count(name) > 1:
                raise MisfitError(name, f"{name!r} names two things of axis, document and step; rename one")
        drawn = [name for name, axis in self.axis.items() if axis.drawn]
        if drawn and self.sampling is None:
            raise MisfitError(
                f"axis.{drawn[0]}",
                f"axis {drawn[0]!r} is drawn from a distribution; add [sampling] with count and seed",
            )
        if self.sampling is not None and not drawn:
            raise MisfitError("sampling", "[sampling] is there, but no axis has a distribution; remove it or add one")
        for key, wanted in (("limit", self.limit), ("pareto", self._front())):
            for name in wanted:
                if name not in self.figures:
                    raise MisfitError(key, f"{key} asks for {name!r}; the figures are {', '.join(self.figures)}")
        return self

    @property
    def cases(self) -> int:
        """How many cases the study has."""
        listed = math.prod(axis.count for axis in self.axis.values())
        return listed * (self.sampling.count if self.sampling is not None else 1)

    def _front(self) -> list[str]:
        return [] if self.pareto is None else [*self.pareto.minimize, *self.pareto.maximize]


def _check_name(name: str) -> None:
    if not _NAME.fullmatch(name):
        raise ValueError(f"{name!r} is no name: letters, digits, _ and -, beginning with a letter")
