"""Truths written apart from the forward code: other integrators, other discretisations, partly other laws."""
