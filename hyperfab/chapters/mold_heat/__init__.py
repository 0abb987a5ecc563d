"""``hf mold-heat``: the warm-up of a heated mold."""

from hyperfab.chapters.mold_heat.recipe import run

__all__ = ["run"]
