"""A press that yields under its force: ``[press] stiffness`` of foam.toml."""

from __future__ import annotations

from collections.abc import Mapping

from hyperfab.loop.catalogue.press import DataContext, PressEffect
from hyperfab.loop.press_reading import Changes
from hyperfab.loop.problem import Constant, Form


class FrameCompliance(PressEffect):
    """What it does to a press."""

    def move(self, press: Changes, at: Mapping[str, float]) -> None:
        """Let the frame yield."""
        press.compliance += 1e-3 * at["compliance_mm_kN"]


def entry(context: DataContext) -> PressEffect:
    """Return the effect: the frame opens in proportion to the force."""
    whole = 1e3 * context.travel_mm / context.force_N
    reason = (
        "the press is set by its force, and no stroke was read"
        if context.forced and not context.strokes
        else ""
    )
    compliance = Constant("compliance_mm_kN", 0.0, 0.0, 20.0 * whole, 0.02 * whole)
    return FrameCompliance(
        id="frame-compliance",
        title="the frame of the press yields",
        not_sought=reason,
        rides_on=("stroke_mm",),
        shown_by="force over stroke with the molds metal on metal, or a dial gauge between the platens",
        source="a linear spring in series",
        forms=(
            Form(
                "spring", (compliance,),
                ((0.1 * whole,), (0.5 * whole,)), ((0.02 * whole,),),
            ),
        ),
    )  # fmt: skip
