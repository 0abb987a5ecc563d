"""How far the laws and tables behind a result were used, beside how far they are known."""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict, Field


class Validity(BaseModel):
    """One law or table: the range it was used over beside the range tested or tabulated, in the unit of ``of``."""

    model_config = ConfigDict(extra="allow", allow_inf_nan=False, populate_by_name=True)

    of: str = Field(description="stretch, temperature_degC, strain, or a table's name")
    direction: str | None = Field(default=None, description="warp or weft, where each has a law of its own")
    used: tuple[float, float] = Field(description="smallest and largest value met")
    known: tuple[float, float] | None = Field(
        default=None, description="smallest and largest value tested or tabulated; absent where nothing says"
    )
    within: bool | None = Field(
        default=None, description="whether used lies in known; absent where that is unknown"
    )
    source: str = Field(alias="from", description="the input that the law or the table came from")
