"""The model of ``hf drape``: the sheet that a case and its files describe, what holds it, and the mold below it."""

from __future__ import annotations

from dataclasses import dataclass

from hyperfab.cases.drape import SIDES, DrapeCase
from hyperfab.chapters.drape.curves import Curve, read_curve
from hyperfab.chapters.drape.fabric import Fabric, read_fabric
from hyperfab.chapters.job import Job
from hyperfab.chapters.molds import PlacedMold, read_molds
from hyperfab.cloth import Mold, Sheet, SpringLaw, mold_of
from hyperfab.cloth.net import FIXED, X, Y, Z
from hyperfab.cloth.shear import linear_shear, shear_of_bias
from hyperfab.errors import InputError

#: Direction of the bias test in degrees from the warp.
BIAS = 45.0


#: What a net of springs is without, whatever the case.
NET = (
    "biaxial coupling: warp and weft each carry their uniaxial curve, so that forces and stresses are below those of a "
    "membrane stretched both ways (by a third to a half for an isotropic fabric)",
    "lateral contraction: a cell's thickness is t0/(l1 l2), and a strip with free edges does not narrow, so it is told "
    "thinner than it is",
)


@dataclass(frozen=True)
class Files:
    """What the files of a case hold: the fabric, the test at 45 degrees where one is given, the mold."""

    fabric: Fabric
    bias: Curve | None
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
        missing = [name for name, there in names if not there]
        if self.files.fabric.temperature is None:
            missing.append("temperature: the laws are taken as they stand, at the temperature of their tests")
        return [*missing, "bending stiffness", *NET]


def read_files(job: Job, case: DrapeCase) -> Files:
    """Read what the case names; InputError where a file is not sound."""
    fabric = read_fabric(job, case)
    bias = None if case.shear_law is None else read_curve(job, "--shear-law", case.shear_law, BIAS, None)
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
        shear=_shear(case, files),
        mass=case.mass,
        edges=_held(case),
        holder=_holder(case),
    )
    return Model(case, files, sheet, mold_of(files.placed.surface, files.placed.touching))


def _shear(case: DrapeCase, files: Files) -> SpringLaw | None:
    """Law of the angle between the threads: of a modulus, or such that the net answers the bias test as measured."""
    if files.bias is None or case.shear_law is None:
        return None if case.shear_modulus is None else linear_shear(case.shear_modulus)
    try:
        return shear_of_bias(files.bias.law, files.fabric.warp, files.fabric.weft, files.bias.tested)
    except ValueError as error:
        raise InputError(
            str(error), file=case.shear_law, remedy="is it of this fabric, and cut at 45 degrees to the warp?"
        ) from None


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
