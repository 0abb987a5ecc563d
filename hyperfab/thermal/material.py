"""What a part is made of: density, conductivity and specific heat, the last two against temperature."""

from __future__ import annotations

from dataclasses import dataclass

from hyperfab.thermal.tables import Table


@dataclass(frozen=True)
class ThermalMaterial:
    """``density`` [kg/m^3], ``conductivity`` [W/m/K] and ``specific_heat`` [J/kg/K] against temperature [degC]."""

    name: str
    density: float
    conductivity: Table
    specific_heat: Table
