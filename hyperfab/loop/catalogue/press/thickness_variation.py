"""Foam that is not equally thick everywhere: ``variation`` of foam.toml."""

from __future__ import annotations

from collections.abc import Mapping

from hyperfab.loop.catalogue.press import DataContext, PressEffect
from hyperfab.loop.press_reading import Changes
from hyperfab.loop.problem import Constant, Form


class ThicknessVariation(PressEffect):
    """What it does to a press."""

    def move(self, press: Changes, at: Mapping[str, float]) -> None:
        """Add to the terms of the thickness."""
        for name, coefficient in at.items():
            press.uneven[name] = press.uneven.get(name, 0.0) + coefficient


def entry(context: DataContext) -> PressEffect:
    """Return the effect: a wedge, a bowl, or both, or bent ones, over the plan of the male."""

    def terms(*names: str) -> tuple[Constant, ...]:
        return tuple(Constant(name, 0.0, -0.8, 0.8, 0.02) for name in names)

    x, y, xx, xy, yy = terms("x", "y", "xx", "xy", "yy")
    cubes, fours = terms("xxx", "xxy", "xyy", "yyy"), terms("xxxx", "xxyy", "yyyy")
    some, zeros = 0.05, (0.0,) * 11
    wedge = ((some, 0.0), (0.0, some), (-some, 0.0), (0.0, -some))
    return ThicknessVariation(
        id="thickness-variation",
        title="the foam is not equally thick everywhere",
        rides_on=("x_mm", "y_mm"),
        shown_by="the thickness of the foam before it is pressed, at nine places",
        source="a polynomial over the plan",
        forms=(
            Form("wedge", (x, y), wedge, ((0.02, 0.0), (0.0, 0.02))),
            Form("bowl", (xx, yy), wedge[:1] + wedge[2:3], ((0.02, 0.0), (0.0, 0.02))),
            Form("quadric", (x, y, xx, xy, yy), ((some, *zeros[:4]),), ((*zeros[:4], 0.02),), refines="wedge"),
            Form("quadric of a bowl", (xx, yy, x, y, xy), ((some, *zeros[:4]),), refines="bowl"),
            Form("cubic", (x, y, xx, xy, yy, *cubes), ((some, *zeros[:8]),), refines="quadric"),
            Form("flat bowl", (xx, yy, *fours), ((some, *zeros[:4]),), refines="bowl"),
            Form(
                "quartic", (x, y, xx, xy, yy, *cubes, *fours), ((some, *zeros),), refines=("cubic", "flat bowl")
            ),
        ),
    )  # fmt: skip
