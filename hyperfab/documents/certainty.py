"""How sure constants of a material are, and how far the specimens differ that they were found from."""

from __future__ import annotations

from typing import Literal

import numpy as np
from pydantic import Field, model_validator

from hyperfab.documents.base import Part, optional

#: Covariances that others write have some seven digits.
_ROUNDING = 1e-6


class _Alike(Part):
    """Specimens of one kind: cut, warmed and tested alike."""

    test: str
    direction: str | None = None
    temperature_degC: float | None = None
    specimens: int = Field(description="of this kind")


class Replicates(_Alike):
    """How far specimens of one kind differ."""

    scatter: float = Field(
        description="standard deviation of the stress between specimens, rms over the stretches they share, "
        "over the largest stress"
    )


class NextSpecimen(_Alike):
    """Where the readings of one more specimen of a kind are to be expected, over the stretches that all share."""

    level: float = Field(description="probability that a reading is within, at each stretch")
    stretch: list[float] = Field(description="of the loading direction; between them the band goes straight")
    low_MPa: list[float] = Field(description="lower end of the band")
    high_MPa: list[float] = Field(description="upper end of the band")


class ScatterPart(Part):
    """What the specimens of one kind add to how unsure the constants are."""

    covariance: list[list[float]] = Field(description="of the constants")
    degrees_of_freedom: float


class FitUncertainty(Part):
    """How sure the constants are: covariance, and where it comes from.

    >>> FitUncertainty(order=["C10_MPa"], covariance=[[-1.0]], specimens=3, degrees_of_freedom=2, source="specimens")
    Traceback (most recent call last):
    ...
    pydantic_core._pydantic_core.ValidationError: 1 validation error for FitUncertainty
      Value error, covariance has a negative variance ...
    """

    order: list[str] = Field(description="names of the constants, in the order of the covariance")
    covariance: list[list[float]] | None = optional(
        "of the constants, by its source; absent where there are no more readings than constants"
    )
    specimens: int = Field(description="specimens fitted")
    degrees_of_freedom: float = Field(description="of Student's t for an interval; 0 where there are no replicates")
    source: Literal["specimens", "readings", "stated"] = Field(
        description="specimens: from how they scatter; readings: from what the law misses; stated: from what is "
        "stated of the readings, how specimens scatter being unknown too"
    )
    law: float | None = optional(
        "how far the stress of other accepted laws is from this one's, relative, over all modes up to "
        "the tests' I1 (--model all)"
    )
    parts: list[ScatterPart] | None = optional(
        "what each kind of specimens adds, where there are several: their sum is the covariance but for "
        "what few degrees of freedom widen it by, constant by constant; what hangs on several constants takes these"
    )
    next_specimen: list[NextSpecimen] | None = optional(
        "where readings of one more specimen are to be expected, of each kind of test with replicates; "
        "where directions have constants of their own, it stands with them"
    )

    @model_validator(mode="after")
    def _covariances(self) -> FitUncertainty:
        parts = [(f"parts.{k}.covariance", part.covariance) for k, part in enumerate(self.parts or ())]
        for name, rows in [("covariance", self.covariance), *parts]:
            fault = None if rows is None else _no_covariance(rows, len(self.order))
            if fault is not None:
                raise ValueError(f"{name} {fault}")
        return self


def _no_covariance(rows: list[list[float]], size: int) -> str | None:
    """Return why ``rows`` are no covariance of ``size`` constants, None where they are one."""
    if [len(row) for row in rows] != [size] * size:
        return f"has not {size} rows of {size} numbers, as order has names"
    found = np.array(rows).reshape(size, size)
    variance = np.diag(found)
    if (variance < 0.0).any():
        return "has a negative variance on its diagonal"
    sd = np.sqrt(np.where(variance > 0.0, variance, 1.0))
    correlation = found / np.outer(sd, sd)
    if not np.allclose(correlation, correlation.T, rtol=0.0, atol=_ROUNDING):
        return "is not symmetric"
    if size and np.linalg.eigvalsh(correlation)[0] < -_ROUNDING * size:
        return "is none: some combination of the constants has a negative variance"
    return None
