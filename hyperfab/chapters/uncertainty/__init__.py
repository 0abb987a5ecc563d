"""Uncertainty of the inputs carried into the results: sources, what results change by with them, bands and budget."""
