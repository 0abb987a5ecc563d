"""``hf drape``: a sheet of fabric at equilibrium on a mold."""

from hyperfab.chapters.drape.command import run

__all__ = ["run"]
