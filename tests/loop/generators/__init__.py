"""Truths that owe nothing to the forward code: other functional forms, other integrators, other discretisations."""
