"""Treloar's vulcanised rubber of 1944: the measurements against which every elastic law is tried."""

from __future__ import annotations

from hyperfab.io.csv_write import csv_bytes

_SOURCE = (
    "L. R. G. Treloar, Stress-strain data for vulcanised rubber under various types of deformation, "
    "Trans. Faraday Soc. 40 (1944) 59, doi:10.1039/TF9444000059; 8 % sulphur rubber, as commonly tabulated"
)

# Stretch and nominal stress [MPa], as printed in the literature.
_UNIAXIAL = """
1.01 0.03, 1.12 0.14, 1.24 0.23, 1.39 0.32, 1.61 0.41, 1.89 0.50, 2.17 0.58, 2.42 0.67,
3.01 0.85, 3.58 1.04, 4.03 1.21, 4.76 1.58, 5.36 1.94, 5.76 2.29, 6.16 2.67, 6.40 3.02,
6.62 3.39, 6.87 3.75, 7.05 4.12, 7.16 4.47, 7.27 4.85, 7.43 5.21, 7.50 5.57, 7.61 6.30
"""
_SHEAR = """
1.06 0.16, 1.14 0.26, 1.21 0.33, 1.32 0.41, 1.46 0.51, 1.87 0.72, 2.40 0.92, 2.98 1.12,
3.48 1.31, 3.96 1.50, 4.36 1.67, 4.69 1.85, 4.96 2.01
"""
_BIAXIAL = """
1.04 0.09, 1.08 0.16, 1.12 0.24, 1.14 0.26, 1.20 0.33, 1.31 0.44, 1.42 0.51, 1.68 0.66,
1.94 0.78, 2.49 0.97, 3.03 1.26, 3.43 1.47, 3.75 1.75, 4.03 1.98, 4.26 2.24, 4.44 2.43
"""


def treloar() -> dict[str, bytes]:
    """Return the three files of Treloar's tests: uniaxial, planar shear and equal biaxial tension.

    >>> treloar()["uniaxial.csv"].decode().splitlines()[-1]
    '7.61,6.30'
    """
    tests = {"uniaxial": _UNIAXIAL, "shear": _SHEAR, "biaxial": _BIAXIAL}
    return {f"{test}.csv": _table(test, points) for test, points in tests.items()}


def _table(test: str, points: str) -> bytes:
    metadata = {"test": test, "material": "vulcanised rubber", "temperature": "20 degC", "source": _SOURCE}
    rows = [point.split() for point in points.split(",")]
    return csv_bytes(["stretch [-]", "stress [MPa]"], rows, metadata=metadata)
