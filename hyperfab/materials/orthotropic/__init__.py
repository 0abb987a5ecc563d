"""The orthotropic sheet: its energy, what its tests give, and its constants from tests."""

from __future__ import annotations

from hyperfab.materials.orthotropic.energy import ABSENT, LINEAR, NAMES, NONLINEAR, Orthotropic

__all__ = ["ABSENT", "LINEAR", "NAMES", "NONLINEAR", "Orthotropic"]
