"""``hf drape``: a sheet of fabric at equilibrium on a mold."""

from __future__ import annotations

import re

import numpy as np

from hyperfab.chapters.drape import files
from hyperfab.chapters.drape.depths import read_depths
from hyperfab.chapters.drape.effects import SIDES, Effects, edge_names, held, read_effects
from hyperfab.chapters.drape.fabric import read_fabric
from hyperfab.chapters.drape.result import document_of, judge, tears
from hyperfab.chapters.drape.states import SOLVERS, Solver, State, at_depths
from hyperfab.chapters.job import Job
from hyperfab.chapters.molds import PlacedMold, read_molds
from hyperfab.cloth import HeldNodeInside, Mold, Sheet, Step, mold_of
from hyperfab.cloth.cascade import grid_sizes
from hyperfab.errors import InputError, UsageError
from hyperfab.io import units

MOST_NODES = 4_000_000


def run(
    job: Job,
    *,
    material: str | None,
    mold: list[str],
    grid: str,
    size: str,
    depth: str,
    output: str,
    states: int | None = None,
    depths: str | None = None,
    warp: str | None = None,
    weft: str | None = None,
    thickness: str | None = None,
    clamp: str = "edges",
    slide: str | None = None,
    blank_holder: list[str] | None = None,
    friction: str | None = None,
    load_steps: int | None = None,
    prestretch: str = "1",
    mass: str | None = None,
    shear_modulus: str | None = None,
    shear_law: str | None = None,
    max_stretch: float | None = None,
    solver: str = "newton",
    steps: int | None = None,
    divisor: float = 40.0,
    tolerance: float = 1e-6,
    stl_unit: str = "mm",
) -> int:
    """Relax a sheet onto a mold and write where it rests, at each depth asked for.

    1 where the fabric would tear, 4 where no equilibrium was found or the constants are unstable.
    """
    out = job.opened(output, (".vtu", ".csv", ".png", ".pvd"))
    n, m = _grid(grid)
    sides = units.size(size, option="--size")
    wanted = read_depths(depth, states, depths)
    edges = edge_names("--clamp", clamp)
    sliding = edge_names("--slide", slide) if slide else []
    effects = read_effects(job, prestretch, mass, shear_modulus, shear_law, friction, blank_holder, edges)
    fixed = held(edges, sliding, effects.holder)
    _check(solver, steps, divisor, max_stretch, tolerance, size, min(sides), load_steps, effects)
    fabric = read_fabric(job, material, thickness, warp, weft)
    placed = read_molds(job, mold, stl_unit, wanted[-1])
    out.refuse_inputs(job.inputs)

    sheet = Sheet(
        n,
        m,
        sides,
        fabric.thickness,
        fabric.warp,
        fabric.weft,
        prestretch=effects.prestretch,
        shear=effects.shear_law(sides, (n, m)),
        mass=effects.mass,
        edges=fixed,
        holder=effects.holder_forces,
    )
    touching = (placed.shift[0], placed.shift[1], placed.shift[2] - wanted[-1])
    flat = mold_of(placed.surface, touching)
    job.keep((sheet, flat, wanted[-1], effects))
    found = _drape(
        job,
        sheet,
        flat,
        placed,
        wanted,
        effects,
        Solver(solver, tolerance, steps, divisor, load_steps),
    )
    last = found[-1]
    loose = [side for side in SIDES if side not in edges or side in effects.holder]
    document = document_of(fabric, sheet, placed, found, wanted, loose, tolerance)
    document.clamp, document.slide = edges, sliding
    document.blank_holder_N_mm = effects.holder or None
    document.friction = effects.friction or None
    if solver != "newton":
        document.iterations = document.iterations_finest
    document.solver, document.prestretch = solver, list(effects.prestretch)
    document.mass_g_m2, document.shear_modulus_MPa = effects.mass or None, effects.shear_modulus
    document.shear_law = "measured" if effects.bias is not None else None
    document.left_out = effects.absent
    sharp = len(last.mold.creases.corners) > 0
    if effects.friction > 0.0 and sharp:
        document.left_out.append("friction of the threads between nodes where they run over sharp edges")
    sound = judge(job, document)
    torn = tears(job, document, sheet, last, max_stretch)
    if out.wants_files:
        files.write(out, sheet, found, max_stretch)
    job.write(out, document)
    return 4 if not sound else 1 if torn else 0


def _check(
    solver: str,
    steps: int | None,
    divisor: float,
    max_stretch: float | None,
    tolerance: float,
    size: str,
    side: float,
    load_steps: int | None,
    effects: Effects,
) -> None:
    """Refuse options that mean nothing, with the right form."""
    if solver not in SOLVERS:
        raise UsageError(f"--solver {solver}: choose {', '.join(SOLVERS[:-1])} or {SOLVERS[-1]}")
    if (steps is not None and steps < 1) or divisor <= 0.0:
        raise UsageError(f"--steps {steps}, --divisor {divisor:g}: both must be more than 0")
    if solver != "newton" and effects.rubs:
        raise UsageError(f"--solver {solver} knows no friction; leave out --friction and --blank-holder")
    if load_steps is not None and (load_steps < 1 or not effects.rubs):
        raise UsageError(
            f"--load-steps {load_steps}: 1 or more, and only where --friction or --blank-holder makes the way matter"
        )
    if max_stretch is not None and max_stretch <= 1.0:
        raise UsageError(f"--max-stretch {max_stretch:g}: a stretch is more than 1; write 1.8 for 80 %")
    if side <= 0.0:
        raise UsageError(f"--size {size}: both sides must be longer than 0")
    if not 1e-12 <= tolerance <= 1e-2:
        raise UsageError(f"--tolerance {tolerance:g}: choose between 1e-12 and 1e-2; 1e-6 is usual")


def _drape(
    job: Job,
    sheet: Sheet,
    mold: Mold,
    placed: PlacedMold,
    wanted: list[float],
    effects: Effects,
    solver: Solver,
) -> list[State]:
    """The states at the depths ``wanted``, as far as there are any."""
    sizes = grid_sizes(sheet.n, sheet.m)
    total = sum(a * b for a, b in sizes)
    with job.console.progress("Draping") as advance:

        def report(depth: float, step: Step) -> None:
            a, b = step.nodes
            share = float(np.log(max(step.residual, solver.tolerance)) / np.log(solver.tolerance))
            way = (sum(p * q for p, q in sizes if p * q < a * b) + max(share, 0.0) * a * b) / total
            if wanted[-1] > 0.0 and (effects.rubs or len(wanted) > 1):
                way = depth / wanted[-1]
            advance(way, f"{depth:.3g} mm, {a}x{b} nodes, residual {step.residual:.1e}")

        try:
            return list(at_depths(sheet, mold, wanted, effects.friction, solver, report))
        except HeldNodeInside as error:
            raise _held_inside(error, sheet, placed) from None


def _grid(text: str) -> tuple[int, int]:
    match = re.fullmatch(r"\s*(\d{1,5})\s*[x×]\s*(\d{1,5})\s*", text)
    if match is None:
        raise UsageError(f"--grid {text}: give the nodes along warp and weft; write 100x100")
    n, m = int(match[1]), int(match[2])
    if min(n, m) < 3:
        raise UsageError(f"--grid {text}: at least 3 nodes a side")
    if n * m > MOST_NODES:
        raise UsageError(f"--grid {text}: {n * m} nodes are more than the {MOST_NODES} that fit; take fewer")
    return n, m


def _held_inside(error: HeldNodeInside, sheet: Sheet, placed: PlacedMold) -> InputError:
    x, y, _ = sheet.flat()[error.node]
    return InputError(
        f"the clamped edge of the sheet at ({x:.4g}, {y:.4g}) mm is {error.depth:.3g} mm inside the mold",
        file=placed.name,
        remedy="make --size larger or --depth smaller, or leave that edge out of --clamp",
    )
