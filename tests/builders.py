"""What many tests need: a small heated plate, for tests of the command and not of the heat; a mesh of one size."""

from __future__ import annotations

import numpy as np

from hyperfab.membrane.meshing import SizeField


def plate(x: float, y: float, z: float) -> str:
    """Return the head of a mold.toml: an aluminium plate of these sizes [mm], a corner at the origin."""
    return f"""
format = "hyperfab.mold/1"
[material.aluminium]
density = "2702 kg/m^3"
conductivity = "237 W/m/K"
specific_heat = "903 J/kg/K"
[[part]]
name = "plate"
material = "aluminium"
box = {{ origin = ["0 mm", "0 mm", "0 mm"], size = ["{x} mm", "{y} mm", "{z} mm"] }}
"""


PLATE = (
    plate(60, 60, 20)
    + """[[heater]]
on = "plate.z-"
power = "3000 W"
[[convection]]
on = "exposed"
h = { table = "film.csv" }
ambient = "25 degC"
[run]
start = "25 degC"
target = "200 degC"
mesh_size = "20 mm"
[work_surface]
on = "plate.z+"
"""
)
#: The film coefficient the plate's table names.
FILM = b"temperature [degC],h [W/m^2/K]\n25,5\n100,9\n250,13\n"


def uniform(length: float) -> SizeField:
    """Return the size field of a membrane's mesh that is ``length`` [mm] everywhere."""
    return lambda points: np.full(len(points), length)
