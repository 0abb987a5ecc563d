"""``hf drape``: a sheet of fabric at equilibrium on a mold."""

from __future__ import annotations

import os

import numpy as np

from hyperfab.cases.drape import DrapeCase
from hyperfab.chapters.drape import files, nearby
from hyperfab.chapters.drape.fabric import note_ranges
from hyperfab.chapters.drape.model import Model, State, at_depths, model_of, read_files
from hyperfab.chapters.drape.result import LOOKED, document_of, judge, say, tears
from hyperfab.chapters.job import Job
from hyperfab.chapters.uncertainty.carry import Sure, carry
from hyperfab.chapters.uncertainty.of_fabric import origins_of_fabric
from hyperfab.chapters.uncertainty.sources import Origins, origins
from hyperfab.cloth import BeyondLaw, HeldNodeInside, Step
from hyperfab.cloth.cascade import grid_sizes
from hyperfab.cloth.net import FIXED
from hyperfab.errors import HyperfabError, InputError, NotConverged
from hyperfab.report.bands import banded


def run(job: Job, case: DrapeCase) -> int:
    """Relax a sheet onto a mold and write where it rests, at each depth asked for.

    1 where the fabric would tear, 4 where no equilibrium was found or the constants are unstable.
    """
    out = job.opened(".vtu", ".[0-9]*.vtu", ".csv", ".png", ".pvd", ".mold.stl")
    model = model_of(case, read_files(job, case))
    out.refuse_inputs(job.inputs)
    found = _drape(job, model)
    document = document_of(model, found)
    note_ranges(job, model.files.fabric, found[-1].fields.stretch_warp, found[-1].fields.stretch_weft)
    sound = judge(job, document, found[-1])
    torn = tears(job, document, model.sheet, found[-1], case.max_stretch)
    sure = Sure()
    if document.converged:
        say(job, document)
        sure = carry(
            job,
            case,
            document,
            lambda: _origins(job, case),
            lambda origins: nearby.beside(job, model, found[-1], origins),
        )
    if out.wants_files:
        files.write(out, model, found, sure, banded(document.to_json(), "force_N", "N"))
    known = {"temperature_degC": model.files.fabric.temperature, "slide": case.sliding}
    job.write(out, document, case, thickness_mm=model.sheet.thickness, **known)
    return 4 if not sound else 1 if torn else 0


def _origins(job: Job, case: DrapeCase) -> Origins:
    """Return what the inputs say of how sure they are."""
    if case.material is None:
        found = origins(job.inputs, case)
    else:
        found = origins_of_fabric(job.inputs, case, case.material, case.temperature)
    curves = [name for name in (case.warp, case.weft, case.shear_law) if name is not None]
    found.left_out += [f"{os.path.basename(name)}: how far specimens differ" for name in curves if found.found]
    return found


def _drape(job: Job, model: Model) -> list[State]:
    """The states at the depths that are wanted, as far as there are any."""
    wanted, tolerance = model.case.wanted, model.case.tolerance
    sizes = grid_sizes(model.sheet.n, model.sheet.m)
    total = sum(a * b for a, b in sizes)
    with job.console.progress("Draping") as advance:

        def report(depth: float, step: Step) -> None:
            a, b = step.nodes
            share = float(np.log(max(step.residual, tolerance)) / np.log(tolerance))
            way = (sum(p * q for p, q in sizes if p * q < a * b) + max(share, 0.0) * a * b) / total
            if wanted[-1] > 0.0 and (model.case.has_friction or len(wanted) > 1):
                way = depth / wanted[-1]
            advance(way, f"{depth:.3g} mm, {a}x{b} nodes, residual {step.residual:.1e}")

        try:
            return list(at_depths(model, report))
        except HeldNodeInside as error:
            raise _held_inside(error, model) from None
        except BeyondLaw:
            raise _beyond(model) from None


def _beyond(model: Model) -> HyperfabError:
    """What ends a membrane's law that has no answer: constants that are unstable before, or chains that lock."""
    law, file = model.sheet.membrane, model.files.fabric.ways[0].source
    assert law is not None
    way = np.linspace(1.0, LOOKED, 401)[1:]
    held, none = np.ones_like(way), np.zeros_like(way)
    for one, other in ((way, held), (held, way), (way, way)):
        with np.errstate(all="ignore"):
            margin = law.margin(np.column_stack([one**2, other**2, none]))
        first = int(np.argmin(margin >= 0.0))
        if margin[first] < 0.0:
            return NotConverged(
                f"{file}: the constants are unstable: from a stretch of {way[first]:.3f} on more strain takes less "
                "stress, and the law has no answer to the strains that the mold asks for; fit the fabric again with "
                "--stable"
            )
    return InputError(
        "the law has no answer to the strains that the mold asks for: it ends there (its chains lock)",
        file=file,
        remedy="less --depth, a larger --size, or a law that goes further",
    )


def _held_inside(error: HeldNodeInside, model: Model) -> InputError:
    x, y, _ = model.sheet.flat()[error.node]
    held = "clamped" if model.sheet.fixed[error.node] == FIXED else "sliding"
    return InputError(
        f"the {held} edge of the sheet at ({x:.4g}, {y:.4g}) mm is {error.depth:.3g} mm inside the mold",
        file=model.files.placed.name,
        remedy="make --size larger or --depth smaller, or leave that edge out of --clamp and --slide",
    )
