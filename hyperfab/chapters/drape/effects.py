"""What the sheet of ``hf drape`` is besides a net of springs, and what holds it: each effect is off by default."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, field, replace

from hyperfab.chapters.drape.curves import read_curve
from hyperfab.chapters.job import Job
from hyperfab.cloth import SpringLaw, piecewise_linear
from hyperfab.cloth.net import FIXED, X, Y, Z
from hyperfab.errors import UsageError
from hyperfab.io import units

SIDES = ("x-", "x+", "y-", "y+")

#: Direction of the bias test in degrees from the warp.
BIAS = 45.0


@dataclass(frozen=True)
class Effects:
    """Pre-stretch along warp and weft, mass in g/m^2, shear modulus in MPa or the diagonals' law, the coefficient of
    friction on the mold, and the blank holder's friction in N/mm by edge.
    """

    prestretch: tuple[float, float] = (1.0, 1.0)
    mass: float = 0.0
    shear_modulus: float | None = None
    bias: SpringLaw | None = None
    friction: float = 0.0
    holder: dict[str, float] = field(default_factory=dict)

    def shear_law(self, sides: tuple[float, float], grid: tuple[int, int]) -> SpringLaw | None:
        """Law of the diagonals, one of the two being taut in shear.

        Of a modulus it is linear: a cell hx by hy with diagonals d sheared by g strains them by g hx hy/d^2; half the
        cell's volume to each gives G = E/2 (hx hy/d^2)^2. Of a bias test it is the measured curve twice: pulled along
        the diagonals that point its way, a net whose threads only turn carries all of the stress on that half.
        """
        if self.bias is not None:
            return replace(self.bias, pieces=2.0 * self.bias.pieces)
        if self.shear_modulus is None:
            return None
        hx, hy = sides[0] / (grid[0] - 1), sides[1] / (grid[1] - 1)
        modulus = 2.0 * self.shear_modulus * ((hx * hx + hy * hy) / (hx * hy)) ** 2
        return piecewise_linear([1.0, 2.0], [0.0, modulus])

    @property
    def holder_forces(self) -> tuple[float, float, float, float]:
        """The blank holder's friction at x-, x+, y-, y+ in N/mm, 0 where there is none."""
        a, b, c, d = (self.holder.get(side, 0.0) for side in SIDES)
        return a, b, c, d

    @property
    def rubs(self) -> bool:
        """Does the sheet remember the way it was draped?"""
        return self.friction > 0.0 or bool(self.holder)

    @property
    def absent(self) -> list[str]:
        """Effects that this run does not have."""
        names = (
            ("friction", self.friction > 0.0),
            ("pre-tension", self.prestretch != (1.0, 1.0)),
            ("gravity", self.mass > 0.0),
            ("shear stiffness", self.shear_modulus is not None or self.bias is not None),
        )
        return [*(name for name, there in names if not there), "bending stiffness"]


def read_effects(
    job: Job,
    prestretch: str,
    mass: str | None,
    shear_modulus: str | None,
    shear_law: str | None = None,
    friction: str | None = None,
    holder: list[str] | None = None,
    clamped: list[str] | None = None,
) -> Effects:
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
    if modulus is not None and shear_law is not None:
        raise UsageError("--shear-modulus and --shear-law both say what the diagonals are; give one of them")
    mu = _coefficient(friction)
    held = _holder(holder or [], clamped or [])
    bias = None if shear_law is None else read_curve(job, "--shear-law", shear_law, BIAS, None).law
    return Effects((values[0], values[-1]), weight, modulus, bias, mu, held)


def _coefficient(text: str | None) -> float:
    if text is None:
        return 0.0
    try:
        mu = float(text)
    except ValueError:
        mu = math.nan
    if not 0.0 <= mu <= 2.0:
        raise UsageError(f"--friction {text}: a coefficient from 0 to 2; write 0.3")
    return mu


def _holder(texts: list[str], clamped: list[str]) -> dict[str, float]:
    """Read ``2 N/mm`` (all clamped edges) and ``x-,x+=2 N/mm``."""
    found: dict[str, float] = {}
    for text in texts:
        match = re.fullmatch(r"\s*(?:([^=]*)=)?([^=]*)", text)
        if match is None:
            raise UsageError(f"--blank-holder {text}: write 2N/mm, or y-,y+=2N/mm")
        sides = clamped if match[1] is None else edge_names("--blank-holder", match[1])
        force = units.quantity(match[2], "membrane-stress", option="--blank-holder")
        if force <= 0.0:
            raise UsageError(
                f"--blank-holder {text}: more than 0N/mm; an edge that nothing holds is left out of --clamp"
            )
        loose = [side for side in sides if side not in clamped]
        if loose:
            raise UsageError(f"--blank-holder {text}: {loose[0]} is not held; name it in --clamp too")
        found |= dict.fromkeys(sides, force)
    return {side: found[side] for side in SIDES if side in found}


def edge_names(option: str, text: str) -> list[str]:
    """Read ``edges`` (all four) or some of x-,x+,y-,y+."""
    names = list(SIDES) if text.strip() == "edges" else [part.strip() for part in text.split(",")]
    wrong = [name for name in names if name not in SIDES]
    if wrong:
        raise UsageError(f"{option} {text}: {wrong[0]!r} is no edge; write edges, or some of x-,x+,y-,y+")
    return [side for side in SIDES if side in names]


def held(clamped: list[str], sliding: list[str], holder: dict[str, float]) -> tuple[int, int, int, int]:
    """Axes held at each edge: all where clamped, height alone under a blank holder; where sliding, all but along it."""
    both = [side for side in clamped if side in sliding]
    if both:
        raise UsageError(f"--slide {both[0]}: that edge is clamped; leave it out of --clamp")
    bits = []
    for side in SIDES:
        free = X | Z if side[0] == "x" else Y | Z
        bits.append(Z if side in holder else FIXED if side in clamped else free if side in sliding else 0)
    return bits[0], bits[1], bits[2], bits[3]
