"""``uncertainty`` of a document: how sure its figures are, and what that is made of."""

from __future__ import annotations

from typing import Literal

from pydantic import BaseModel, ConfigDict, Field


class Part(BaseModel):
    """A table of the document."""

    model_config = ConfigDict(extra="allow", allow_inf_nan=False)


class Share(Part):
    """What a source contributes."""

    source: str
    share: float = Field(description="of the variance")


class Band(Part):
    """One figure."""

    sd: float = Field(description="standard deviation, in the figure's unit")
    low: float = Field(description="lower end of the interval")
    high: float = Field(description="upper end of the interval")
    budget: list[Share] = Field(description="what it is made of, largest first")
    sensitivities: dict[str, float] | None = Field(
        default=None, description="what the figure changes by with each input number, in their units (linear)"
    )


class SourceNumber(Part):
    """An uncertain number."""

    id: str = Field(
        description="what it is, the same in every document that hangs on it: the beginning of its file's SHA-256, or "
        "of that of the command's set-up, and its place there"
    )
    name: str = Field(description="the file, and the key in it; of an option its key in the set-up")
    sd: float


class SourcePart(Part):
    """Numbers that err together."""

    source: str = Field(description="as budgets name it")
    numbers: list[SourceNumber]
    correlation: list[list[float]] | None = Field(default=None, description="of several numbers")
    degrees_of_freedom: float | None = Field(
        default=None,
        description="that its standard deviations are known with; absent where they count as known",
    )


class Uncertainty(Part):
    """How sure the figures are, of what the inputs state."""

    level: float = Field(description="probability of the intervals")
    method: Literal["linear", "sampled"]
    samples: int | None = Field(default=None, description="runs that were drawn")
    reason: str | None = Field(default=None, description="why it was sampled without being asked")
    quantities: dict[str, Band] = Field(
        description="by the figure's own key, with dots where it stands deeper"
    )
    sources: list[SourcePart] = Field(
        default_factory=list,
        description="what the inputs state; by them later commands know what they already have",
    )
    handed: list[str] = Field(
        default_factory=list,
        description="fields whose derivatives by each number lie in the .vtu, as NAME_by_1 and on through all sources",
    )
    left_out: list[str] = Field(default_factory=list, description="what is not carried")
