"""The model of ``hf drape``: the sheet that a case and its files describe, what holds it, and the mold below it."""

from __future__ import annotations

from dataclasses import dataclass, replace

from hyperfab.cases.drape import SIDES, DrapeCase
from hyperfab.chapters.drape.curves import read_curve
from hyperfab.chapters.drape.fabric import Fabric, read_fabric
from hyperfab.chapters.job import Job
from hyperfab.chapters.molds import PlacedMold, read_molds
from hyperfab.cloth import Mold, Sheet, SpringLaw, mold_of, piecewise_linear
from hyperfab.cloth.net import FIXED, X, Y, Z

#: Direction of the bias test in degrees from the warp.
BIAS = 45.0


@dataclass(frozen=True)
class Files:
    """What the files of a case hold: the fabric, the law of its diagonals where a bias test gives it, the mold."""

    fabric: Fabric
    bias: SpringLaw | None
    placed: PlacedMold


@dataclass(frozen=True)
class Model:
    """What is computed on.

    sheet   the flat sheet
    mold    the mold touching it: the depth is 0
    """

    case: DrapeCase
    files: Files
    sheet: Sheet
    mold: Mold

    @property
    def absent(self) -> list[str]:
        """Effects that this model does not have."""
        names = (
            ("friction", self.case.friction > 0.0),
            ("pre-tension", self.case.prestretch != (1.0, 1.0)),
            ("gravity", self.case.mass > 0.0),
            ("shear stiffness", self.sheet.shear is not None),
        )
        return [*(name for name, there in names if not there), "bending stiffness"]


def read_files(job: Job, case: DrapeCase) -> Files:
    """Read what the case names; InputError where a file is not sound."""
    fabric = read_fabric(job, case)
    bias = None if case.shear_law is None else read_curve(job, "--shear-law", case.shear_law, BIAS, None).law
    return Files(fabric, bias, read_molds(job, list(case.mold), case.stl_unit, case.wanted[-1]))


def model_of(case: DrapeCase, files: Files) -> Model:
    """Return the sheet and the mold that a case describes, with what its files hold."""
    n, m = case.grid
    fabric = files.fabric
    sheet = Sheet(
        n,
        m,
        case.size,
        fabric.thickness,
        fabric.warp,
        fabric.weft,
        prestretch=case.prestretch,
        shear=_diagonals(case, files.bias),
        mass=case.mass,
        edges=_held(case),
        holder=_holder(case),
    )
    return Model(case, files, sheet, mold_of(files.placed.surface, files.placed.touching))


def _diagonals(case: DrapeCase, bias: SpringLaw | None) -> SpringLaw | None:
    """Law of the diagonals, one of the two being taut in shear.

    Of a modulus it is linear: a cell hx by hy with diagonals d sheared by g strains them by g hx hy/d^2; half the
    cell's volume to each gives G = E/2 (hx hy/d^2)^2. Of a bias test it is the measured curve twice: pulled along
    the diagonals that point its way, a net whose threads only turn carries all of the stress on that half.
    """
    if bias is not None and case.shear_law is not None:
        return replace(bias, pieces=2.0 * bias.pieces)
    if case.shear_modulus is None:
        return None
    hx, hy = (side / (count - 1) for side, count in zip(case.size, case.grid, strict=True))
    modulus = 2.0 * case.shear_modulus * ((hx * hx + hy * hy) / (hx * hy)) ** 2
    return piecewise_linear([1.0, 2.0], [0.0, modulus])


def _holder(case: DrapeCase) -> tuple[float, float, float, float]:
    a, b, c, d = (case.holder.get(side, 0.0) for side in SIDES)
    return a, b, c, d


def _held(case: DrapeCase) -> tuple[int, int, int, int]:
    """Axes held at each edge: all where clamped, height alone under a blank holder; where sliding, all but along it."""
    bits = []
    for side in SIDES:
        free = X | Z if side[0] == "x" else Y | Z
        held = FIXED if side in case.clamp else free if side in case.sliding else 0
        bits.append(Z if side in case.holder else held)
    return bits[0], bits[1], bits[2], bits[3]
