"""Fabrics that give way across: ``fabric.compression`` of foam.toml."""

from __future__ import annotations

from collections.abc import Mapping

from hyperfab.loop.catalogue.press import DataContext, PressEffect
from hyperfab.loop.press_reading import Changes
from hyperfab.loop.problem import HAS_IT, Constant, Form
from hyperfab.pressing import foam_law


class FabricCompression(PressEffect):
    """What it does to a press."""

    def move(self, press: Changes, at: Mapping[str, float]) -> None:
        """Let both fabrics give way."""
        soft = at["compliance_1_MPa"]
        if soft == 0.0:
            return
        if "stiffening" in at:
            # One term without a ratio of Poisson's: its modulus at rest is 2 mu.
            press.across = foam_law.hyperfoam(0.5 / soft, -at["stiffening"], 0.0)
        else:
            press.across = foam_law.linear(1.0 / soft)


def entry(context: DataContext) -> PressEffect:
    """Return the effect: a strain in proportion to the pressure, or fabric that stiffens as it is pressed."""
    whole = 1.0 / context.pressure_MPa
    soft = Constant("compliance_1_MPa", 0.0, 0.0, 20.0 * whole, 0.02 * whole)
    reason = "there is no fabric" if context.foam.fabric_mm <= 0.0 else HAS_IT if context.foam.across else ""
    return FabricCompression(
        id="fabric-compression",
        title="the fabrics give way across",
        not_sought=reason,
        rides_on=("x_mm", "y_mm", "z_mm", "stroke_mm"),
        shown_by="the thickness of the fabrics alone under rising pressure (ISO 5084)",
        source="a linear spring; B. Storakers, J. Mech. Phys. Solids 34 (1986) 125, one term",
        forms=(
            Form("linear", (soft,), ((0.1 * whole,), (0.5 * whole,)), ((0.02 * whole,),)),
            Form(
                "stiffening", (soft, Constant("stiffening", 4.0, 0.5, 40.0, 1.0)),
                ((0.3 * whole, 4.0), (whole, 10.0)), ((0.1 * whole, 4.0),), refines="linear",
            ),
        ),
    )  # fmt: skip
