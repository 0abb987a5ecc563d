"""The model of ``hf drape``: the sheet that a case and its files describe, what holds it and the mold below it; and its
states at the depths asked for.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from hyperfab.cases.drape import DYNAMIC_STEPS, LOAD_STEPS, RELAXATION_STEPS, SIDES, DrapeCase
from hyperfab.chapters.drape.curves import Curve, read_curve
from hyperfab.chapters.drape.fabric import Fabric, read_fabric
from hyperfab.chapters.job import Job
from hyperfab.chapters.molds import TURNED, PlacedMold, ask_unit_by_sheet, read_molds
from hyperfab.cloth import (
    Answers,
    Equilibrium,
    Mold,
    Rest,
    Sheet,
    SpringLaw,
    Step,
    answers,
    drape,
    follow,
    load_steps,
    mold_of,
    raised,
)
from hyperfab.cloth.dynamic import swing
from hyperfab.cloth.march import relax
from hyperfab.cloth.net import FIXED, X, Y, Z
from hyperfab.cloth.shear import linear_shear, shear_of_bias
from hyperfab.cloth.start import lowered
from hyperfab.errors import InputError, placed
from hyperfab.io.stl import SIZE_RANGE

#: A mold so many times larger or smaller than the sheet is none of it.
_OUT_OF_PROPORTION = 20.0
#: Direction of the bias test in degrees from the warp.
BIAS = 45.0


#: What a net of springs is without, whatever the case.
NET = (
    "biaxial coupling: warp and weft each carry their uniaxial curve, so that forces and stresses are below those of a "
    "membrane stretched both ways (by a third to a half for an isotropic fabric)",
    "lateral contraction: a cell's thickness is t0/(l1 l2), and a strip with free edges does not narrow, so it is told "
    "thinner than it is",
)


#: What a membrane is without on a mold that has them.
EDGES = "the angle between warp and weft in cells folded over sharp edges of the mold: it is that of their chords"


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
            ("shear stiffness", self.sheet.shear is not None or self.sheet.membrane is not None),
        )
        missing = [name for name, there in names if not there]
        if self.files.fabric.temperature is None:
            missing.append("temperature: the laws are taken as they stand, at the temperature of their tests")
        whole = self.files.fabric.whole
        if whole is None:
            return [*missing, "bending stiffness", *NET, *self.files.fabric.left_out]
        edges = [EDGES] if len(self.mold.creases.corners) else []
        return [*missing, "bending stiffness", *edges, *whole.left_out]


def read_files(job: Job, case: DrapeCase) -> Files:
    """Read what the case names; InputError where a file is not sound."""
    fabric = read_fabric(job, case)
    bias = None if case.shear_law is None else read_curve(job, "--shear-law", case.shear_law, BIAS, None)
    placed = read_molds(job, list(case.mold), case.stl_unit, case.wanted[-1], case.axis)
    question(job, case, placed)
    return Files(fabric, bias, placed)


def question(job: Job, case: DrapeCase, placed: PlacedMold) -> None:
    """Ask what a mold's shape makes doubtful: its unit (InputError), which way is up, and a depth beyond its height."""
    low, high = placed.surface.bounds[0, :3], placed.surface.bounds[0, 3:]
    sides = high - low
    # A sheet in proportion tells that the unit is meant.
    fits = 1.0 / _OUT_OF_PROPORTION < sides.max() / max(case.size) < _OUT_OF_PROPORTION
    if not (fits or SIZE_RANGE[0] <= sides.max() <= SIZE_RANGE[1]):
        shown = " x ".join(f"{side:.3g}" for side in sides)
        raise InputError(
            f"measures {shown} mm when read in {case.stl_unit}",
            file=placed.name,
            remedy="state its unit: --stl-unit m, cm, mm or inch; if it is that small or large, "
            "give a sheet that fits it: --size",
        )
    ask_unit_by_sheet(job, placed.name, placed.surface, case.stl_unit, max(case.size))
    if case.wanted[-1] > sides[2] * (1.0 + 1e-9):
        above = case.wanted[-1] - sides[2]
        job.console.note(
            f"{placed.name}: is {sides[2]:.4g} mm high and pushed up by {case.wanted[-1]:.4g} mm: its underside ends "
            f"{above:.3g} mm above the sheet's plane"
        )
    # Flat faces on the sides of the bounding box: the largest is where a mold stands.
    corners, normals, areas = (
        placed.surface.vertices[placed.surface.faces],
        placed.surface.normals,
        placed.surface.areas,
    )
    flat = {}
    for k, name in enumerate("xyz"):
        for sign, plane in (("-", low[k]), ("+", high[k])):
            on = (np.abs(corners[:, :, k] - plane).max(1) < 1e-6 * sides.max()) & (np.abs(normals[:, k]) > 0.999)
            flat[name + sign] = float(areas[on].sum())
    best = max(flat, key=lambda side: flat[side])
    if best[0] != "z" and flat[best] > 1.5 * max(flat["z-"], flat["z+"]):
        of_file = "xyz"[TURNED[case.axis]["xyz".index(best[0])]]
        way = f"--axis {of_file} turns it up" if best[1] == "-" else "turn it in the program it comes from"
        job.console.warn(
            f"{placed.name}: its largest flat side, {flat[best]:.4g} mm^2, faces {of_file}{best[1]}: if it stands "
            f"on that one, it lies on its side here, and {way}"
        )


def model_of(case: DrapeCase, files: Files) -> Model:
    """Return the sheet and the mold that a case describes, with what its files hold."""
    placed = replace(files.placed, aside=case.offset)
    return Model(case, replace(files, placed=placed), sheet_of(case, files), mold_of(placed.surface, placed.touching))


def sheet_of(case: DrapeCase, files: Files) -> Sheet:
    """Return the flat sheet that a case describes."""
    n, m = case.grid
    fabric = files.fabric
    return Sheet(
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
        membrane=None if fabric.whole is None else fabric.whole.law,
        round=case.shape == "disc",
    )


def _shear(case: DrapeCase, files: Files) -> SpringLaw | None:
    """Law of the angle between the threads: of a modulus, or such that the net answers the bias test as measured."""
    if files.bias is None or case.shear_law is None:
        return None if case.shear_modulus is None else linear_shear(case.shear_modulus)
    with placed(case.shear_law, remedy="is it of this fabric, and cut at 45 degrees to the warp?"):
        law = shear_of_bias(files.bias.law, files.fabric.warp, files.fabric.weft, files.bias.tested)
    return law


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


@dataclass(frozen=True)
class State:
    """The sheet at one depth of the mold; ``rest``: what rubbing took on the way, where something rubs."""

    depth: float
    mold: Mold
    found: Equilibrium
    fields: Answers
    rest: Rest | None = None


def at_depths(model: Model, report: Callable[[float, Step], None]) -> Iterator[State]:
    """States at the depths that are wanted, until one finds no equilibrium.

    Without friction each depth is computed on its own: the equilibrium does not hang on the way there.
    Raises HeldNodeInside where the mold reaches a clamped node.
    """
    if model.case.has_friction:
        yield from _rubbing(model, report)
        return
    for depth in model.case.wanted:
        up = raised(model.mold, depth)

        def told(step: Step, depth: float = depth) -> None:
            report(depth, step)

        found = _solved(model, up, told)
        yield State(depth, up, found, answers(model.sheet, up, found))
        if not found.converged:
            return


def _solved(model: Model, mold: Mold, told: Callable[[Step], None]) -> Equilibrium:
    case, sheet = model.case, model.sheet
    if case.solver == "newton":
        return drape(sheet, mold, case.tolerance, told)
    start = lowered(sheet, mold)
    if case.solver == "dynamic":
        return swing(sheet, mold, start, case.tolerance, case.steps or DYNAMIC_STEPS, told)
    return relax(sheet, mold, start, case.divisor, case.tolerance, case.steps or RELAXATION_STEPS, told)


def _rubbing(model: Model, report: Callable[[float, Step], None]) -> Iterator[State]:
    case, sheet, mold = model.case, model.sheet, model.mold
    heights = load_steps(case.wanted, case.load_steps or LOAD_STEPS)
    wanted = np.array(case.wanted)
    reached = 0.0

    def told(step: Step) -> None:
        report(reached, step)

    for rest in follow(sheet, mold, heights, case.friction, case.tolerance, wanted, told):
        reached = rest.height
        if rest.found.converged and not np.isclose(wanted, rest.height, rtol=0.0, atol=1e-9).any():
            continue
        up = raised(mold, rest.height)
        yield State(rest.height, up, rest.found, answers(sheet, up, rest.found), rest)
