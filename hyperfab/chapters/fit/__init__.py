"""``hf fit``: constants of a law from fabric tests."""

from __future__ import annotations

from hyperfab.chapters.fit.recipe import run

__all__ = ["run"]
