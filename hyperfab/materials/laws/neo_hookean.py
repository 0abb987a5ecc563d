"""Neo-Hookean law: ``W = C10 (I1 - 3)``, shear modulus mu = 2 C10."""

from __future__ import annotations

from hyperfab.materials.polynomial import Polynomial

LAWS = (Polynomial("neo-hookean", "one constant; small and moderate stretches", (1, 0)),)
