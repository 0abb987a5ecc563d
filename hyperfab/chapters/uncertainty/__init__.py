"""Uncertainty of the inputs carried into the results: sources, what results change by with them, bands and budget."""

from hyperfab.chapters.uncertainty.carry import carry

__all__ = ["carry"]
