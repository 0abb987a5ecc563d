"""Strain-energy laws of stretch fabrics and rubbers: stresses, tangents, identification, stability."""

from __future__ import annotations

from hyperfab.materials.law import Membrane
from hyperfab.materials.material import Material, Uniaxial
from hyperfab.materials.registry import bind, law, laws

__all__ = ["Material", "Membrane", "Uniaxial", "bind", "law", "laws"]
