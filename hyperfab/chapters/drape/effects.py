"""What the sheet of ``hf drape`` is besides a net of springs: its edges, pre-stretch, weight, shear stiffness."""

from __future__ import annotations

from dataclasses import dataclass

from hyperfab.cloth import SpringLaw, piecewise_linear
from hyperfab.cloth.net import FIXED, X, Y, Z
from hyperfab.errors import UsageError
from hyperfab.io import units

SIDES = ("x-", "x+", "y-", "y+")


@dataclass(frozen=True)
class Effects:
    """Pre-stretch along warp and weft, mass in g/m^2, shear modulus in MPa or None."""

    prestretch: tuple[float, float]
    mass: float
    shear_modulus: float | None

    def shear_law(self, sides: tuple[float, float], grid: tuple[int, int]) -> SpringLaw | None:
        """Law of the diagonals: linear, one of the two being taut in shear.

        A cell hx by hy with diagonals d sheared by g strains them by g hx hy/d^2; half the cell's volume to each
        gives G = E/2 (hx hy/d^2)^2.
        """
        if self.shear_modulus is None:
            return None
        hx, hy = sides[0] / (grid[0] - 1), sides[1] / (grid[1] - 1)
        modulus = 2.0 * self.shear_modulus * ((hx * hx + hy * hy) / (hx * hy)) ** 2
        return piecewise_linear([1.0, 2.0], [0.0, modulus])

    @property
    def absent(self) -> list[str]:
        """Effects that this run does not have."""
        names = ("pre-tension", self.prestretch != (1.0, 1.0)), ("gravity", self.mass > 0.0)
        return [
            name for name, there in (*names, ("shear stiffness", self.shear_modulus is not None)) if not there
        ]


def read_effects(prestretch: str, mass: str | None, shear_modulus: str | None) -> Effects:
    """Read the options; UsageError with the right form."""
    parts = prestretch.replace("×", "x").split("x")
    try:
        values = [float(part) for part in parts]
    except ValueError:
        values = []
    if len(values) not in (1, 2) or not all(0.5 <= value <= 3.0 for value in values):
        raise UsageError(
            f"--prestretch {prestretch}: a stretch from 0.5 to 3, or two; write 1.05 or 1.05x1.1"
        )
    weight = 0.0 if mass is None else units.quantity(mass, "mass-per-area", option="--mass")
    modulus = (
        None if shear_modulus is None else units.quantity(shear_modulus, "stress", option="--shear-modulus")
    )
    if weight < 0.0 or (modulus is not None and modulus <= 0.0):
        raise UsageError("--mass and --shear-modulus must be more than 0")
    return Effects((values[0], values[-1]), weight, modulus)


def edge_names(option: str, text: str) -> list[str]:
    """Read ``edges`` (all four) or some of x-,x+,y-,y+."""
    names = list(SIDES) if text.strip() == "edges" else [part.strip() for part in text.split(",")]
    wrong = [name for name in names if name not in SIDES]
    if wrong:
        raise UsageError(f"{option} {text}: {wrong[0]!r} is no edge; write edges, or some of x-,x+,y-,y+")
    return [side for side in SIDES if side in names]


def held(clamped: list[str], sliding: list[str]) -> tuple[int, int, int, int]:
    """Axes held at each edge: all where clamped; where sliding, all but along the edge."""
    both = [side for side in clamped if side in sliding]
    if both:
        raise UsageError(f"--slide {both[0]}: that edge is clamped; leave it out of --clamp")
    bits = []
    for side in SIDES:
        free = X | Z if side[0] == "x" else Y | Z
        bits.append(FIXED if side in clamped else free if side in sliding else 0)
    return bits[0], bits[1], bits[2], bits[3]
