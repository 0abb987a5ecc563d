"""``uncertainty`` of a document: how sure its figures are, and what that is made of."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, Literal

from pydantic import Field

from hyperfab.documents.base import Document, Part, optional

#: The figures of each kind of document that are carried; * stands for every name.
FIGURES: dict[str, tuple[str, ...]] = {
    "contact": ("force_N", "contact_radius_mm", "stretch_max", "stress_max_MPa", "energy_J"),
    "drape": (
        "force_N", "stress_warp_max_MPa", "stress_weft_max_MPa", "stress_max_MPa", "stretch_max", "thickness_min_mm",
        "energy_J",
    ),
    "heat": (
        "warmup_time_s", "work_surface.mean_degC", "work_surface.min_degC", "work_surface.max_degC",
        "work_surface.spread_K", "probes.*.final_degC", "probes.*.max_degC", "energy.supplied_J", "energy.lost_J",
        "energy.stored_J", "efficiency",
    ),
    "press": (
        "contact_fraction", "contact_area_mm2", "force_N", "gap_min_mm", "gap_mean_mm", "gap_max_mm",
        "pressure_max_MPa", "pressure_mean_MPa", "stroke_mm", "energy_J",
    ),
}  # fmt: skip


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
    sensitivities: dict[str, float] | None = optional(
        "what the figure changes by with each input number, in their units (linear)"
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
    correlation: list[list[float]] | None = optional("of several numbers")
    degrees_of_freedom: float | None = optional(
        "that its standard deviations are known with; absent where they count as known"
    )


class Uncertainty(Part):
    """How sure the figures are, of what the inputs state."""

    level: float = Field(description="probability of the intervals")
    method: Literal["linear", "sampled"]
    samples: int | None = optional("runs that were drawn")
    reason: str | None = optional("why it was sampled without being asked")
    quantities: dict[str, Band] = Field(description="by the figure's own key, with dots where it stands deeper")
    sources: list[SourcePart] = Field(
        default_factory=list,
        description="what the inputs state; by them later commands know what they already have",
    )
    handed: list[str] = Field(
        default_factory=list,
        description="fields whose derivatives by each number lie in the .vtu, as NAME_by_1 and on through all sources",
    )
    left_out: list[str] = Field(default_factory=list, description="what is not carried")


class Computed(Document):
    """A document of computed figures."""

    uncertainty: Uncertainty | None = optional("how sure the figures are, where the inputs say how sure they are")


def figures_of(plain: Mapping[str, Any], kind: str) -> Iterator[tuple[str, float]]:
    """Yield the figures of a document that are carried, by key."""
    for pattern in FIGURES[kind]:
        yield from _at(plain, pattern.split("."), "")


def _at(data: Any, path: list[str], name: str) -> Iterator[tuple[str, float]]:
    if not path:
        if isinstance(data, float):
            yield name, data
        return
    if not isinstance(data, Mapping):
        return
    for key in [key for key in data if path[0] in ("*", key)]:
        yield from _at(data[key], path[1:], f"{name}.{key}" if name else key)
