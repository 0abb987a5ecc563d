"""Handbook values of common mold metals, to question constants that are misprints.

Values near room temperature from the CRC Handbook of Chemistry and Physics (elements) and the ASM Metals Handbook
(alloys), rounded: they are for questioning, not for computing.
"""

from __future__ import annotations

from dataclasses import dataclass

#: A given value further from the handbook's than this factor is questioned.
FACTOR = 1.6
#: A material of another name is taken for a metal whose density it has to this share, if it conducts as one.
SAME_DENSITY = 0.04
CONDUCTS = 10.0


@dataclass(frozen=True)
class Metal:
    """Names it goes by, density [kg/m^3], conductivity range [W/m/K] over its alloys, specific heat [J/kg/K]."""

    name: str
    words: tuple[str, ...]
    density: float
    conductivity: tuple[float, float]
    specific_heat: float


METALS = (
    Metal("aluminium", ("alumin", "alu", "aw-", "6061", "7075"), 2700.0, (90.0, 240.0), 900.0),
    Metal("steel", ("steel", "stahl", "iron", "p20", "h13"), 7850.0, (13.0, 80.0), 470.0),
    Metal("copper", ("copper", "kupfer"), 8960.0, (150.0, 401.0), 385.0),
    Metal("brass", ("brass", "messing"), 8500.0, (80.0, 160.0), 380.0),
    Metal("bronze", ("bronze",), 8800.0, (35.0, 110.0), 375.0),
    Metal("zinc", ("zinc", "zamak"), 7140.0, (100.0, 120.0), 388.0),
    Metal("nickel", ("nickel",), 8900.0, (60.0, 92.0), 444.0),
    Metal("magnesium", ("magnesium",), 1740.0, (50.0, 156.0), 1023.0),
    Metal("titanium", ("titan",), 4500.0, (6.0, 22.0), 523.0),
)


def recognise(name: str, density: float, conductivity: float) -> Metal | None:
    """Return the metal a material is, by its name, or by density and conductivity together.

    >>> recognise("tooling plate", 2702.0, 237.0).name
    'aluminium'
    """
    lowered = name.lower()
    for metal in METALS:
        if any(word in lowered for word in metal.words):
            return metal
    if conductivity < CONDUCTS:
        return None
    for metal in METALS:
        low, high = metal.conductivity
        same = abs(density / metal.density - 1.0) <= SAME_DENSITY
        if same and low / FACTOR <= conductivity <= high * FACTOR:
            return metal
    return None


def doubts(name: str, density: float, conductivity: float, specific_heat: float) -> list[str]:
    """Return what is unlikely about the constants of a material (SI units), in words.

    >>> doubts("aluminium", 2702.0, 237.0, 903.0)
    []
    >>> doubts("aluminium", 2702.0, 237.0, 49.0)
    ['specific heat 49 J/kg/K: the handbook has about 900 for aluminium']
    """
    metal = recognise(name, density, conductivity)
    if metal is None:
        return _general(density, conductivity, specific_heat)
    found = []
    low, high = metal.conductivity
    checks = (
        ("density", density, "kg/m^3", metal.density, metal.density),
        ("conductivity", conductivity, "W/m/K", low, high),
        ("specific heat", specific_heat, "J/kg/K", metal.specific_heat, metal.specific_heat),
    )
    for what, value, unit, least, greatest in checks:
        if not least / FACTOR <= value <= greatest * FACTOR:
            shown = f"{least:g}" if least == greatest else f"{least:g} to {greatest:g}"
            found.append(f"{what} {value:g} {unit}: the handbook has about {shown} for {metal.name}")
    return found


def _general(density: float, conductivity: float, specific_heat: float) -> list[str]:
    """Heat capacity per volume of solids lies within a narrow range: metals 1.4 to 4, plastics 1 to 4 MJ/m^3/K."""
    volumetric = density * specific_heat / 1e6
    if conductivity >= CONDUCTS and not 1.0 <= volumetric <= 5.0:
        return [
            f"specific heat {specific_heat:g} J/kg/K at {density:g} kg/m^3 is {volumetric:.3g} MJ/m^3/K: "
            "the handbook has 1.4 to 4 for metals"
        ]
    if specific_heat > 15000.0 or specific_heat < 50.0:
        return [f"specific heat {specific_heat:g} J/kg/K: no solid in the handbook is below 100 or above 5000"]
    return []
