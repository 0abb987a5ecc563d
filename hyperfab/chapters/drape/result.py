"""``drape.json`` from the states of the sheet, and what the user must know before trusting it."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from hyperfab.cases.drape import DYNAMIC_STEPS, LOAD_STEPS, RELAXATION_STEPS, SIDES
from hyperfab.chapters.drape.fabric import use_of
from hyperfab.chapters.drape.model import Model, State
from hyperfab.chapters.job import Job
from hyperfab.cloth import Answers, Sheet
from hyperfab.cloth.cascade import PASSED
from hyperfab.cloth.depth import stands_out
from hyperfab.cloth.friction import SLIDES, STARTS, STICKS
from hyperfab.cloth.mold import FREE
from hyperfab.documents.drape import DrapeDocument, DrapeMold, DrapeState, Place, Rubbing
from hyperfab.membrane.ellipticity import lost, lost_from

#: The mold may stand out between the nodes by this share of their spacing without a word.
THROUGH = 0.25
#: Sharp edges may bear this share of the force, which friction does not know, without a word.
MUCH = 0.2
#: How far a law is looked through for where it is unstable.
LOOKED = 3.0


def draw_in(sheet: Sheet, state: State, edges: list[str]) -> dict[str, float] | None:
    """How far in mm each of ``edges`` is drawn in, at most over its nodes."""
    way = state.found.state.x - sheet.flat()
    inward = {"x-": way[0, :, 0], "x+": -way[-1, :, 0], "y-": way[:, 0, 1], "y+": -way[:, -1, 1]}
    return {name: float(inward[name].max()) + 0.0 for name in edges} or None


def peak(sheet: Sheet, state: State) -> Place:
    """The middle of the spring, or of the cell of a membrane, that is stretched most."""
    one, other = state.fields.most_stretched
    flat, x = sheet.flat(), state.found.state.x
    middle, draped = 0.5 * (flat[one] + flat[other]), 0.5 * (x[one] + x[other])
    return Place(flat=[float(v) + 0.0 for v in middle[:2]], draped=[float(v) + 0.0 for v in draped])


def document_of(model: Model, states: list[State]) -> DrapeDocument:
    """The document of the last state."""
    case, sheet, placed, fabric = model.case, model.sheet, model.files.placed, model.files.fabric
    depths, tolerance = case.wanted, case.tolerance
    loose = [side for side in SIDES if side not in case.clamp or side in case.holder]
    state = states[-1]
    found, fields = state.found, state.fields
    warp, weft = use_of(fabric, fields.stretch_warp, fields.stretch_weft)
    status = None
    if not found.converged:
        x, y, _ = sheet.flat()[found.worst]
        status = (
            f"{found.status}: residual {found.residual_relative:.2e} above {tolerance:g}, "
            f"worst at the node that lies at ({x:.4g}, {y:.4g}) mm of the flat sheet"
        )
        if len(depths) > 1 or state.rest is not None:
            status += f", at a depth of {state.depth:.4g} mm"
        status += f"; {way_out(model)}"
    left_out = model.absent
    if case.friction > 0.0 and len(state.mold.creases.corners) > 0:
        left_out.append("friction of the threads between nodes where they run over sharp edges")
    through, top, below = stands_out(found.state.x, sheet, state.mold)
    where = Place(flat=below[:2].tolist(), draped=top.tolist())
    newton = sum(step.iteration > 0 for one in states for step in one.found.history)
    last = dict(_state(sheet, state, loose))
    del last["depth_mm"]  # where the way ended early, that is not the depth asked for
    document = DrapeDocument(
        **last,
        status=status,
        iterations=newton if case.solver == "newton" else found.history[-1].iteration,
        iterations_finest=found.history[-1].iteration,
        residual_max_N=found.residual_max,
        tolerance=tolerance,
        sheet=case.sheet,
        imbalance_N=fields.imbalance,
        penetration_nodes_mm=fields.cut.node,
        penetration_edges_mm=fields.cut.edge,
        penetration_edges_at_mm=list(fields.cut.flat) if fields.cut.edge > 0.0 else None,
        stretch_max=fields.stretch_max,
        stretch_max_at_mm=peak(sheet, state),
        stands_through_mm=through,
        stands_through_at_mm=where if through > 0.0 else None,
        stress_max_MPa=None if fields.cells is None else float(fields.cells.cauchy.max()),
        stress_nominal_max_MPa=float(
            max(fields.stress_warp.max(), fields.stress_weft.max())
            if fields.cells is None
            else fields.cells.nominal.max()
        ),
        wrinkled_area_fraction=None
        if fields.cells is None
        else float(np.average(fields.cells.wrinkled, weights=sheet.areas)),
        thickness_mm=sheet.thickness,
        grid=[sheet.n, sheet.m],
        size_mm=list(sheet.size),
        shape=case.shape,
        depth_mm=depths[-1],
        temperature_degC=fabric.temperature,
        constants_degC=fabric.held_at,
        clamp=list(case.clamp),
        slide=case.sliding,
        blank_holder_N_mm=case.holder or None,
        friction=case.friction or None,
        solver=case.solver,
        prestretch=list(case.prestretch),
        mass_g_m2=case.mass or None,
        shear_modulus_MPa=case.shear_modulus,
        shear_law=None if model.files.bias is None else "measured",
        left_out=left_out,
        warp=warp,
        weft=weft,
        mold=DrapeMold(
            facets=len(placed.surface.faces),
            closed=placed.closed,
            axis=case.axis,
            shift_mm=[float(v) + 0.0 for v in placed.standing(state.depth)],
        ),
    )
    if (not found.converged and state.depth < depths[-1] - 1e-9) or len(states) < len(depths):
        reached = [s.depth for s in states if s.found.converged]
        document.depth_reached_mm = reached[-1] if reached else 0.0
    if len(depths) > 1:
        document.states = [_state(sheet, s, loose) for s in states]
        document.force_depth = [[s.depth, s.fields.press_force] for s in states if s.found.converged]
    if state.rest is not None:
        document.rubbing = _rubbing(state)
    return document


def _state(sheet: Sheet, state: State, loose: list[str]) -> DrapeState:
    found, fields = state.found, state.fields
    return DrapeState(
        depth_mm=state.depth,
        converged=found.converged,
        residual_relative=found.residual_relative,
        force_N=fields.press_force,
        energy_J=fields.spring_energy * 1e-3,
        contact_nodes=int(np.count_nonzero(fields.touching)),
        contact_edges=fields.contact_edges,
        slack_springs=fields.slack_springs,
        stress_warp_max_MPa=float(fields.stress_warp.max()),
        stress_weft_max_MPa=float(fields.stress_weft.max()),
        thickness_min_mm=float(fields.cell_thickness.min()),
        penetration_max_mm=max(fields.cut.node, fields.cut.edge),
        draw_in_mm=draw_in(sheet, state, loose),
    )


def _rubbing(state: State) -> Rubbing:
    rest = state.rest
    assert rest is not None
    stick_slip = rest.friction.stick_slip[state.found.state.contact != FREE]
    stored = state.found.energy - rest.unstressed
    return Rubbing(
        load_steps=rest.steps,
        work_J=rest.work * 1e-3,
        rubbed_J=rest.rubbed * 1e-3,
        drawn_J=rest.drawn * 1e-3,
        balance_relative=(rest.work - stored - rest.rubbed - rest.drawn) / rest.work if rest.work else 0.0,
        sticking_nodes=int(np.count_nonzero(stick_slip == STICKS)),
        sliding_nodes=int(np.count_nonzero((stick_slip == STARTS) | (stick_slip == SLIDES))),
    )


def way_out(model: Model) -> str:
    """Return what to try where the sheet has found no equilibrium, the likeliest first."""
    case = model.case
    if case.solver != "newton":
        steps = case.steps or (DYNAMIC_STEPS if case.solver == "dynamic" else RELAXATION_STEPS)
        return f"try --solver newton, or --steps {4 * steps}"
    along, across = (count + 1 if count % 2 == 0 else count + 20 for count in case.grid)
    ways = [f"--grid {along}x{across}", f"--depth {0.8 * max(case.wanted):.4g}mm"]
    if case.has_friction:
        ways.insert(0, f"--load-steps {2 * (case.load_steps or LOAD_STEPS)}")
    else:
        ways.append("--solver dynamic (slow)")
    return f"try {', then '.join(ways)}"


def judge(job: Job, document: DrapeDocument, state: State) -> bool:
    """Say what the user must know before trusting the answer; False where it is no equilibrium to rely on."""
    if document.status is not None:
        job.console.warn(document.status)
    unrubbed = float(state.found.push[2]) / max(state.fields.press_force, 1e-300)
    if document.friction and unrubbed > MUCH:
        job.console.warn(
            f"{100.0 * unrubbed:.0f} % of the force goes over sharp edges of the mold between nodes, where nothing "
            "rubs: --friction counts for little; round the edges over a few spacings of the --grid"
        )
    faults = list(_faults(document, state.fields))
    job.console.warn(*faults)
    document.status = "; ".join([*([] if document.status is None else [document.status]), *faults]) or None
    through, at = document.stands_through_mm or 0.0, document.stands_through_at_mm
    if through > THROUGH * _spacing(document) and at is not None and not faults:
        x, y = at.flat
        odd = ", or an odd one, which has a node in its middle" if min(k % 2 for k in document.grid) == 0 else ""
        job.console.warn(
            f"the mold stands {through:.3g} mm out through the net, between the nodes about ({x:.4g}, {y:.4g}) mm of "
            f"the flat sheet: take a finer --grid{odd}"
        )
    return document.converged and not faults


def _faults(document: DrapeDocument, fields: Answers) -> Iterator[str]:
    """Yield why a sheet that came to rest is no equilibrium to rely on."""
    if fields.cells is not None and float(fields.cells.margin.min()) < 0.0:
        worst = np.unravel_index(int(fields.cells.margin.argmin()), fields.cells.margin.shape)
        yield (
            f"the law is unstable where it is used: at a stretch of {fields.cells.stretch[worst]:.3f} more strain "
            "takes less stress; fit the fabric again with --stable"
        )
    elif fields.cells is not None and (gone := lost(fields.cells.law, fields.cells.strain)).any():
        stretch = float(fields.cells.stretch.ravel()[gone].max())
        yield (
            f"at a stretch of {stretch:.3f} the law lets the stretch gather in bands without width (ellipticity is "
            "lost): no finer --grid would find this sheet again; less --depth, or fit a law that stiffens"
        )
    for name, use in (("warp", document.warp), ("weft", document.weft)):
        if use.softens_at is not None:
            yield (
                f"the constants along {name} are unstable where they are used: the stress falls beyond stretch "
                f"{use.softens_at:.3f}, and springs reach {use.stretch_max:.3f}; fit the fabric again with --stable"
            )
        if use.ends_at is not None:
            yield (
                f"springs along {name} reach a stretch of {use.stretch_max:.3f}, and the law ends at "
                f"{use.ends_at:.3f}: less --depth, a larger --size, or a law that goes further"
            )
    through = document.stands_through_mm or 0.0
    if document.depth_mm > 0.0 and not (document.contact_nodes or document.contact_edges):
        yield (
            f"no node of the grid rests on the mold: it passes between the nodes ({_held_by(fields)}), or the sheet "
            "has slipped off it (less --depth)"
        )
    elif through >= 0.5 * document.depth_mm > 0.0 and document.force_N <= document.residual_max_N:
        yield (
            f"the mold stands {through:.3g} mm out through the net and bears nothing of it: it has passed between the "
            f"nodes ({_held_by(fields)})"
        )
    elif through > PASSED * _spacing(document):
        yield (
            f"the mold stands {through:.3g} mm out through the net, more than {PASSED:g} spacings: part of it passes "
            f"between the nodes, and the force is too low ({_held_by(fields)})"
        )


def _spacing(document: DrapeDocument) -> float:
    """Return the longer side of the grid's cells in the flat sheet [mm]."""
    return max(side / (count - 1) for side, count in zip(document.size_mm, document.grid, strict=True))


def _held_by(fields: Answers) -> str:
    """Return what to do where a mold has passed between nodes: of a law that gives way no finer grid would hold it."""
    from_on = None if fields.cells is None else lost_from(fields.cells.law, LOOKED)
    if from_on is None:
        return "take a finer --grid"
    return (
        f"the law lets the stretch gather in bands from a stretch of {from_on:.3g} on, and the sheet gives way "
        "there: less --depth, or fit a law that stiffens"
    )


def tears(job: Job, document: DrapeDocument, sheet: Sheet, state: State, largest: float | None) -> bool:
    """Note and say where springs are stretched further than the fabric can bear."""
    torn = False
    for name, use in (("warp", document.warp), ("weft", document.weft)):
        if use.fails_at is not None:
            torn = True
            job.console.warn(
                f"{name} springs are stretched up to {use.stretch_max:.3f}; the tested specimen failed at "
                f"{use.fails_at:.3f}: the fabric would tear"
            )
    if largest is None:
        return torn
    fields = state.fields
    over = sum(int(np.count_nonzero(one > largest)) for one in fields.stretched)
    document.max_stretch, document.over_max_stretch = largest, over
    if over:
        x, y = peak(sheet, state).flat
        what = "springs" if fields.cells is None else "cells"
        document.over_max_stretch_at_mm = [x, y]
        job.console.warn(
            f"{over} {what} are stretched beyond {largest:g}, up to {fields.stretch_max:.3f} at ({x:.4g}, {y:.4g}) "
            "mm of the flat sheet: the fabric would tear"
        )
    return torn or over > 0


def say(job: Job, document: DrapeDocument) -> None:
    """One line for the terminal: what a person asks first."""
    place = document.stretch_max_at_mm
    x, y = (round(one, 3) + 0.0 for one in place.flat[:2]) if place else (0.0, 0.0)
    at = f" at ({x:.4g}, {y:.4g}) mm of the flat sheet" if place else ""
    edges = f", {document.contact_edges} springs over edges" if document.contact_edges else ""
    slack = "slack springs" if document.sheet == "net" else "cells wrinkled or slack"
    job.console.note(
        f"force {document.force_N:.4g} N, stretch up to {document.stretch_max:.3f}{at}, thinnest "
        f"{document.thickness_min_mm:.3g} mm, {document.slack_springs} {slack}, "
        f"{document.contact_nodes} nodes on the mold{edges}"
    )
