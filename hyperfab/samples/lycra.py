"""Synthetic stretch-fabric tests: two directions, three temperatures, built on published Yeoh constants.

Nobody measured these numbers. They follow a third-order Yeoh law whose warp constants are those published
for a Lycra-type fabric stretched to a strain of 0.8 (Table 2.6 of the report: C10 60951, C20 21463, C30 17258
Pa). The weft is a softer variant, the softening with temperature a plausible straight line. Three replicates
differ in stiffness as cut specimens do, and each reading carries noise.
"""

from __future__ import annotations

from random import Random

from hyperfab.io.csv_write import csv_bytes

#: Yeoh constants at 23 degC [MPa].
YEOH = {"warp": (0.060951, 0.021463, 0.017258), "weft": (0.044, 0.0125, 0.0085)}
#: Stiffness lost per kelvin above 23 degC.
SOFTENING = 0.0015
TEMPERATURES = (23, 80, 105)
THICKNESS_MM = 0.5

_STRAINS = tuple(step / 50 for step in range(1, 41))
_REPLICATES = 3
_SPREAD_OF_REPLICATES = 0.015
_NOISE_RELATIVE = 0.004
_NOISE_MPA = 0.0002
_SOURCE = (
    "synthetic, not measured: a Yeoh law built on the constants of the report's Table 2.6 for the warp and a "
    "softer weft, 0.15 % softer per kelvin, with replicates and noise of a fixed seed"
)


def lycra() -> dict[str, bytes]:
    """Return six uniaxial tests, ``warp-23C.csv`` to ``weft-105C.csv``.

    >>> sorted(lycra())[0]
    'warp-105C.csv'
    """
    return {
        f"{direction}-{temperature}C.csv": _test(direction, temperature)
        for direction in YEOH
        for temperature in TEMPERATURES
    }


def nominal_stress(direction: str, temperature: float, strain: float) -> float:
    """Return the law behind the samples, without noise: nominal stress [MPa] of an incompressible Yeoh sheet.

    >>> round(nominal_stress("warp", 23.0, 0.8), 4)
    0.6367
    """
    c10, c20, c30 = YEOH[direction]
    lam = 1.0 + strain
    distance = lam * lam + 2.0 / lam - 3.0
    slope = c10 + distance * (2.0 * c20 + distance * 3.0 * c30)
    softening = 1.0 - SOFTENING * (temperature - 23.0)
    return 2.0 * (lam - 1.0 / (lam * lam)) * slope * softening


def _test(direction: str, temperature: int) -> bytes:
    random = Random(f"{direction} {temperature}")
    rows = []
    for specimen in range(1, _REPLICATES + 1):
        stiffness = 1.0 + _SPREAD_OF_REPLICATES * _bell(random)
        for strain in _STRAINS:
            exact = stiffness * nominal_stress(direction, temperature, strain)
            reading = exact * (1.0 + _NOISE_RELATIVE * _bell(random)) + _NOISE_MPA * _bell(random)
            rows.append([str(specimen), f"{strain:.2f}", f"{reading:.5f}"])
    metadata = {
        "test": "uniaxial",
        "material": "Lycra-type knit (synthetic)",
        "direction": direction,
        "temperature": f"{temperature} degC",
        "thickness": f"{THICKNESS_MM} mm",
        "branch": "load",
        "source": _SOURCE,
    }
    return csv_bytes(["specimen", "strain [-]", "stress [MPa]"], rows, metadata=metadata)


def _bell(random: Random) -> float:
    """A near-normal deviate from sums alone: the same on every machine, whatever its mathematics library."""
    return sum(random.random() for _ in range(12)) - 6.0
