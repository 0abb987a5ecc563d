"""Strain-energy laws, one a file; ``hyperfab.materials.registry`` finds them."""
