"""``sweep.json``: the outcome of a study; its table, one row a case, lies beside it."""

from __future__ import annotations

from typing import Any, ClassVar

from pydantic import Field

from hyperfab.documents.base import Document, Part


class FigureRange(Part):
    """How far a figure moves over the study."""

    cases: int = Field(description="cases that have the figure")
    least: float
    mean: float
    greatest: float


class Effect(Part):
    """Mean of a figure at each level of an axis, and how much of its variance the axis alone explains."""

    axis: str
    figure: str
    levels: list[float | str] = Field(description="level, or middle of its class where values are drawn")
    means: list[float]
    variance_share: float = Field(description="0: no effect of its own; 1: all of the variance")


class Front(Part):
    """Cases that no other case beats in both figures."""

    figures: list[str]
    directions: list[str] = Field(description="minimize or maximize, for each figure")
    cases: list[str]


class SweepDocument(Document):
    """The result of ``hf sweep``."""

    KIND: ClassVar[str] = "sweep"

    name: str
    question: str = ""
    cases: int
    steps: int = Field(description="different steps: shared ones count once")
    by_status: dict[str, int] = Field(description="cases by exit status")
    within_limits: int | None = None
    axes: dict[str, str] = Field(description="axis of the study: column of the table")
    figures: dict[str, FigureRange]
    limits: dict[str, dict[str, float]] = Field(default_factory=dict)
    effects: list[Effect] = Field(default_factory=list)
    idle: list[str] = Field(default_factory=list, description="axes along which every case finds the same")
    front: Front | None = None
    best: dict[str, dict[str, Any]] = Field(
        default_factory=dict,
        description="the case with the least of each figure, or the greatest where senses says so, within the limits",
    )
    senses: dict[str, str] = Field(
        default_factory=dict,
        description="least or greatest: what the goals and limits of the study want of a figure",
    )
    table: str = Field(description="the table, relative to this document")
