"""``hf drape``: a sheet of fabric at equilibrium on a mold."""

from __future__ import annotations

import re

import numpy as np

from hyperfab.chapters.drape import files
from hyperfab.chapters.drape.effects import SIDES, edge_names, held, read_effects
from hyperfab.chapters.drape.fabric import Fabric, read_fabric, use_of
from hyperfab.chapters.drape.mold import PlacedMold, read_molds
from hyperfab.chapters.job import Job
from hyperfab.cloth import Answers, Equilibrium, HeldNodeInside, Sheet, Step, answers, drape, mold_of
from hyperfab.cloth.cascade import grid_sizes
from hyperfab.cloth.mold import FREE
from hyperfab.cloth.relaxation import relax
from hyperfab.cloth.start import lowered
from hyperfab.documents.drape import DrapeDocument, DrapeMold
from hyperfab.errors import InputError, UsageError
from hyperfab.io import units

MOST_NODES = 4_000_000


def run(
    job: Job,
    *,
    material: str,
    mold: list[str],
    grid: str,
    size: str,
    depth: str,
    thickness: str | None,
    clamp: str,
    slide: str | None,
    prestretch: str,
    mass: str | None,
    shear_modulus: str | None,
    max_stretch: float | None,
    solver: str,
    steps: int,
    divisor: float,
    tolerance: float,
    stl_unit: str,
    output: str,
) -> int:
    """Relax a sheet onto a mold and write where it rests.

    1 where ``max_stretch`` is exceeded, 4 where no equilibrium was found or the constants are unstable.
    """
    out = job.opened(output, (".vtu", ".csv", ".png"))
    n, m = _grid(grid)
    sides = units.size(size, option="--size")
    rise = units.quantity(depth, "length", option="--depth")
    edges = edge_names("--clamp", clamp)
    sliding = edge_names("--slide", slide) if slide else []
    effects = read_effects(prestretch, mass, shear_modulus)
    if solver not in ("newton", "relaxation"):
        raise UsageError(f"--solver {solver}: choose newton or relaxation")
    if steps < 1 or divisor <= 0.0:
        raise UsageError(f"--steps {steps}, --divisor {divisor:g}: both must be more than 0")
    if max_stretch is not None and max_stretch <= 1.0:
        raise UsageError(f"--max-stretch {max_stretch:g}: a stretch is more than 1; write 1.8 for 80 %")
    if min(sides) <= 0.0:
        raise UsageError(f"--size {size}: both sides must be longer than 0")
    if rise < 0.0:
        raise UsageError(f"--depth {depth}: the mold is pushed up by 0mm or more")
    if not 1e-12 <= tolerance <= 1e-2:
        raise UsageError(f"--tolerance {tolerance:g}: choose between 1e-12 and 1e-2; 1e-6 is usual")
    fabric = read_fabric(job, material, thickness)
    placed = read_molds(job, mold, stl_unit, rise)
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
        edges=held(edges, sliding),
    )
    surface = mold_of(placed.surface, placed.shift)
    with job.console.progress("Draping") as advance:
        total = sum(a * b for a, b in grid_sizes(n, m))

        def report(step: Step) -> None:
            a, b = step.nodes
            done = sum(p * q for p, q in grid_sizes(n, m) if p * q < a * b)
            share = float(np.log(max(step.residual, tolerance)) / np.log(tolerance))
            advance((done + max(share, 0.0) * a * b) / total, f"{a}x{b} nodes, residual {step.residual:.1e}")

        try:
            if solver == "newton":
                found = drape(sheet, surface, tolerance, report)
            else:
                found = relax(sheet, surface, lowered(sheet, surface), divisor, tolerance, steps, report)
        except HeldNodeInside as error:
            raise _held_inside(error, sheet, placed) from None
    fields = answers(sheet, surface, found)
    document = _document(fabric, sheet, placed, found, fields, tolerance)
    document.depth_mm, document.clamp, document.slide = rise, edges, sliding
    if solver == "relaxation":
        document.iterations = document.iterations_finest
    document.solver, document.prestretch = solver, list(effects.prestretch)
    document.mass_g_m2, document.shear_modulus_MPa = effects.mass or None, effects.shear_modulus
    document.draw_in_mm = _draw_in(sheet, found, [side for side in SIDES if side not in edges])
    document.left_out = ["friction", *effects.absent]
    sound = _judge(job, document)
    torn = max_stretch is not None and _exceeds(job, document, fields, max_stretch)
    if out.wants_files:
        out.add(".vtu", files.field(sheet, found, fields))
        out.add(".csv", files.history(found))
        out.add(".png", files.picture(sheet, found, fields))
    job.write(out, document)
    return 4 if not sound else 1 if torn else 0


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


def _draw_in(sheet: Sheet, found: Equilibrium, edges: list[str]) -> dict[str, float] | None:
    """How far in mm each edge that is not clamped is drawn in, at most over its nodes."""
    way = found.state.x - sheet.flat()
    inward = {"x-": way[0, :, 0], "x+": -way[-1, :, 0], "y-": way[:, 0, 1], "y+": -way[:, -1, 1]}
    out = {name: float(inward[name].max()) + 0.0 for name in edges}
    return out or None


def _exceeds(job: Job, document: DrapeDocument, fields: Answers, largest: float) -> bool:
    """Note and say where springs are stretched further than the fabric can bear."""
    over = int(
        np.count_nonzero(fields.stretch_warp > largest) + np.count_nonzero(fields.stretch_weft > largest)
    )
    document.max_stretch, document.over_max_stretch = largest, over
    if over:
        top = max(document.warp.stretch_max, document.weft.stretch_max)
        job.console.warn(
            f"{over} springs are stretched beyond {largest:g}, up to {top:.3f}: the fabric would tear"
        )
    return over > 0


def _held_inside(error: HeldNodeInside, sheet: Sheet, placed: PlacedMold) -> InputError:
    x, y, _ = sheet.flat()[error.node]
    return InputError(
        f"the clamped edge of the sheet at ({x:.4g}, {y:.4g}) mm is {error.depth:.3g} mm inside the mold",
        file=placed.name,
        remedy="make --size larger or --depth smaller, or leave that edge out of --clamp",
    )


def _document(
    fabric: Fabric, sheet: Sheet, placed: PlacedMold, found: Equilibrium, fields: Answers, tolerance: float
) -> DrapeDocument:
    warp, weft = use_of(fabric, fields.stretch_warp, fields.stretch_weft)
    status = None
    if not found.converged:
        x, y, _ = sheet.flat()[found.worst]
        status = (
            f"{found.status}: residual {found.residual_relative:.2e} above {tolerance:g}, "
            f"worst at the node that lies at ({x:.4g}, {y:.4g}) mm of the flat sheet"
        )
    return DrapeDocument(
        converged=found.converged,
        status=status,
        iterations=sum(1 for step in found.history if step.iteration > 0),
        iterations_finest=found.history[-1].iteration,
        residual_max_N=found.residual_max,
        residual_relative=found.residual_relative,
        tolerance=tolerance,
        energy_J=fields.spring_energy * 1e-3,
        force_N=fields.press_force,
        imbalance_N=fields.imbalance,
        contact_nodes=int(np.count_nonzero(found.state.contact != FREE)),
        penetration_max_mm=max(fields.node_penetration, fields.edge_penetration),
        penetration_nodes_mm=fields.node_penetration,
        penetration_edges_mm=fields.edge_penetration,
        penetration_edges_at_mm=list(fields.edge_at) if fields.edge_penetration > 0.0 else None,
        slack_springs=fields.slack_springs,
        stress_warp_max_MPa=float(fields.stress_warp.max()),
        stress_weft_max_MPa=float(fields.stress_weft.max()),
        thickness_min_mm=float(fields.cell_thickness.min()),
        thickness_mm=sheet.thickness,
        grid=[sheet.n, sheet.m],
        size_mm=list(sheet.size),
        depth_mm=0.0,
        clamp=[],
        warp=warp,
        weft=weft,
        mold=DrapeMold(facets=len(placed.surface.faces), closed=placed.closed, shift_mm=list(placed.shift)),
    )


def _judge(job: Job, document: DrapeDocument) -> bool:
    """Say what the user must know before trusting the answer; False where it is no equilibrium to rely on."""
    sound = document.converged
    if document.status is not None:
        job.console.warn(document.status)
    for name, use in (("warp", document.warp), ("weft", document.weft)):
        if use.beyond_tested:
            job.console.warn(
                f"{use.beyond_tested} {name} springs are stretched up to {use.stretch_max:.3f}, beyond the tests "
                f"of the fabric (up to {use.tested_stretch_max:.3f}): their stress is extrapolated"
            )
        if use.softens_at is not None:
            sound = False
            text = (
                f"the constants along {name} are unstable where they are used: the stress falls beyond stretch "
                f"{use.softens_at:.3f}, and springs reach {use.stretch_max:.3f}; fit the fabric again with --stable"
            )
            document.status = text if document.status is None else f"{document.status}; {text}"
            job.console.warn(text)
    return sound
