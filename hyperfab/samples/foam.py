"""A soft polyurethane foam: its compression curve, and the sandwich that is pressed between the molds."""

from __future__ import annotations

from math import exp

from hyperfab.io.csv_write import csv_bytes

_SOURCE = (
    "synthetic, not measured: plateau and densification in the form of Avalle, Belingardi and Montanini, "
    "Int. J. Impact Eng. 25 (2001) 455, with values typical of a 30 kg/m^3 polyurethane foam"
)
_PLATEAU_MPA = 0.0045
_MODULUS_MPA = 0.12
_DENSIFICATION_MPA = 0.0016
_DENSIFICATION_POWER = 2

FOAM_TOML = b"""\
# The sandwich between the molds: fabric, foam, fabric.
format = "hyperfab.foam/1"

# Undeformed, at room temperature. With both fabric layers the sandwich is 4.5 mm thick.
thickness = "3.5 mm"

# Nominal stress over engineering strain, both positive in compression. A named law would be
# { law = "linear", modulus = "0.05 MPa" }.
compression = { table = "foam.csv" }

# Each layer by its thickness, or by a material document: above = "fabric.json".
fabric = { above = "0.5 mm", below = "0.5 mm" }

# For --dwell, typical of a 30 kg/m^3 foam: what carries and stores heat, from a mold's surface on.
conductivity = "0.04 W/m/K"
specific_heat = "1400 J/kg/K"
density = "30 kg/m^3"
contact_conductance = "500 W/m^2/K"

# What stays when the press opens (synthetic): nine tenths of the foam's strain after 40 s at 200 degC. Measured
# thicknesses would be { measured = "set.csv" }.
set = { rate = "1.8e9 1/s", activation = "95 kJ/mol" }

# Linear thermal expansion of the molds: aluminium 6061, mean between 20 and 100 degC.
expansion = { male = "23.6e-6 1/K", female = "23.6e-6 1/K" }
"""
TEXTILE_TOML = b"""\
# The textile of the report's Table 4.1, as one slab. Between the plates in molds/, 4.5 mm apart and at 200 degC, its
# middle is at 146.69 degC after 4 s: hf press-contact --male molds/plate-male.stl --female molds/plate-female.stl
#   --foam specimens/textile.toml --gap 4.5mm --zero hot --temperature 200degC --dwell 4s -o press.json
format = "hyperfab.foam/1"
thickness = "4.5 mm"
conductivity = "0.023 W/m/K"
specific_heat = "1045 J/kg/K"
density = "30 kg/m^3"
temperature = "25 degC"

# The table has no mechanics: the curve of the sample foam.
compression = { table = "foam.csv" }
"""


def foam_curve() -> bytes:
    """Return ``foam.csv``: engineering strain and nominal stress in compression, rising throughout.

    >>> foam_curve().decode().splitlines()[-1]
    '0.90,0.13410'
    """
    rows = [[f"{step / 50:.2f}", f"{stress(step / 50):.5f}"] for step in range(46)]
    metadata = {"material": "polyurethane foam (synthetic)", "source": _SOURCE}
    return csv_bytes(["strain [-]", "stress [MPa]"], rows, metadata=metadata)


def stress(strain: float) -> float:
    """Return the nominal stress [MPa] of the sample foam: a plateau, then densification.

    >>> stress(0.0)
    0.0
    """
    plateau = _PLATEAU_MPA * (1.0 - exp(-_MODULUS_MPA * strain / _PLATEAU_MPA))
    return plateau + _DENSIFICATION_MPA * (strain / (1.0 - strain)) ** _DENSIFICATION_POWER
