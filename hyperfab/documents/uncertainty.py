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


class Uncertainty(Part):
    """How sure the figures are, of what the inputs state."""

    level: float = Field(description="probability of the intervals")
    method: Literal["linear", "sampled"]
    samples: int | None = Field(default=None, description="runs that were drawn")
    reason: str | None = Field(default=None, description="why it was sampled without being asked")
    quantities: dict[str, Band] = Field(
        description="by the figure's own key, with dots where it stands deeper"
    )
    left_out: list[str] = Field(default_factory=list, description="what is not carried")
