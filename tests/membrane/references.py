"""Reference solutions of a sphere of radius 40 mm on a clamped membrane, 1 mm thick, computed by two other methods.

Incompressible plane-stress membrane, disc of radius 100 mm, frictionless: collocation and shooting on the axisymmetric
equations agree to the digits shown. Square of side 200 mm: a converged P2 solution. Units N, N mm, mm.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Disc:
    """Force, energy, contact radius undeformed and deformed, stretch at the apex, radial stretch at the rim."""

    force: float
    energy: float
    radius: float
    radius_deformed: float
    apex: float
    rim: float


NEO_HOOKEAN = {"C10_MPa": 0.2}
YEOH = {"C10_MPa": 0.18, "C20_MPa": -0.004, "C30_MPa": 0.0008}

DISC = {
    ("neo-hookean", 20.0): Disc(1.7959477986, 8.6510373724, 13.991936, 14.123451, 1.0307655323, 1.012823033),
    ("neo-hookean", 40.0): Disc(14.679562516, 147.70373922, 22.751221, 23.648071, 1.1140841365, 1.0536932296),
    ("neo-hookean", 60.0): Disc(41.576556565, 693.07619325, 27.803588, 30.716268, 1.2854086307, 1.1122654003),
    ("neo-hookean", 80.0): Disc(71.468419551, 1830.8080792, 29.074052, 35.688074, 1.6269494464, 1.1665977709),
    ("yeoh-3", 20.0): Disc(1.616176689, 7.7854957455, 13.992330, 14.123908, 1.0307742808, 1.0128221865),
    ("yeoh-3", 40.0): Disc(13.188277813, 132.81663062, 22.754228, 23.655444, 1.1145147718, 1.0536311243),
    ("yeoh-3", 60.0): Disc(37.064492514, 620.96680058, 27.791318, 30.760584, 1.2912697173, 1.1114526235),
    ("yeoh-3", 80.0): Disc(62.822435364, 1626.8780156, 28.975197, 35.780115, 1.6391627787, 1.1633635186),
}

#: Force and energy of the neo-Hookean square.
SQUARE = {
    20.0: (1.48266, 7.15610),
    40.0: (12.2608, 122.549),
    60.0: (36.0422, 587.319),
    80.0: (65.1037, 1600.31),
}
