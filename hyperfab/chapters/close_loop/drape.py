"""The loop on a draped sheet: a drape document against markers."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from hyperfab.arrays import Array
from hyperfab.cases.drape import LOAD_STEPS, DrapeCase
from hyperfab.chapters.close_loop.domain import Given
from hyperfab.chapters.close_loop.extended_sheet import FABRIC, SIZED, THREADS, drape_applied, extend_drape
from hyperfab.chapters.close_loop.finalise import MODEL_SUFFIXES, Extension, Traces, finish
from hyperfab.chapters.close_loop.readings import Files, spread, unread
from hyperfab.chapters.close_loop.readings import read_files as read_measured
from hyperfab.chapters.close_loop.softening import linear_of, scaled_material, widths
from hyperfab.chapters.close_loop.taken import at_places, once
from hyperfab.chapters.close_loop.upstream_written import WRITTEN
from hyperfab.chapters.drape.fabric import note_ranges, read_fabric
from hyperfab.chapters.drape.model import Model, model_of, read_files
from hyperfab.chapters.job import Job
from hyperfab.chapters.molds import PlacedMold
from hyperfab.chapters.rerun import Listener, Overlay, check_unchanged, unchanged
from hyperfab.cloth import Equilibrium, HeldNodeInside, Sheet, answers, drape, follow, load_steps, raised
from hyperfab.cloth.net import GRAVITY
from hyperfab.documents.base import read_document
from hyperfab.documents.loop import LoopDocument
from hyperfab.documents.material import MaterialDocument
from hyperfab.errors import InputError, NotConverged
from hyperfab.io.csv_table import Table, read_table
from hyperfab.io.json_io import dump_json
from hyperfab.io.layout import Layout
from hyperfab.loop.drape import (
    ASIDE,
    SIZES,
    Draped,
    DrapeProblem,
    Markers,
    at_markers,
    drape_problem,
    mistracked,
    places,
    reached,
    settings_of,
)
from hyperfab.loop.emulator import Axis as Setting
from hyperfab.loop.emulator import Kriged, krige
from hyperfab.loop.engine import Finding

#: Columns of a marker's place on the flat sheet, and of how far it moved from there.
FLAT, MOVES = ("x0", "y0"), ("u", "v", "w")
#: Markers that are no farther from the middle than this share of half the sheet were read in another unit.
_SPREAD = 0.05
#: So many markers at one and the same draped place were not seen.
_LOST = 3
#: Places whose height differs by less than this share of how it changes lie on a flat sheet.
_LEVEL = 0.2
#: Nodes a side of the loop's own grid, its load steps where it rubs, and the residual it is brought to.
_NODES, _STEPS, _TOLERANCE = 25, 10, 1e-6
#: The residual with which a run counts where no step gets nearer: places are then off by some thousandths of a mm.
_NEAR = 1e-2
#: A sheet that rests this far from where it was thought to (rms, standard deviations of the noise) is run anew, there
#: and beside, this share of each setting's reach away.
_OFF, _ASIDE = 0.2, 0.12
#: How far an added prestretch and the friction may go, and how slack a sheet may be mounted.
_MOST_STRETCH, _MOST_FRICTION, _SLACK = 0.12, 0.6, 0.95
#: How far constants of the law are run, as shares of a stiffness, and how far down at the most, of themselves.
_STIFFER, _LEAST = 0.35, 0.95
#: How much larger or smaller a mold may be than it is drawn.
_LARGER = 0.06
#: How far off the sheet's middle a mold may stand, as a share of the sheet's shorter side.
_SIDEWAYS = 0.04
#: Weight of the sheet over what a unit strain of it pulls with, at the most; and the masses that has to lie between.
_SAG, _MASSES = 0.025, (200.0, 5000.0)


def run(job: Job, given: Given) -> int:
    """Close the loop on a drape document."""
    series = (".model.[0-9]*.vtu", ".model.pvd", ".model.mold.stl")
    out = job.opened(*MODEL_SUFFIXES, *WRITTEN, *series, FABRIC, SIZED, *THREADS, ".png", ".csv")
    made = unchanged(DrapeCase, given.data, given.case.model)
    files = read_measured(job, given, read_markers, ("length",))
    out.refuse_inputs(job.inputs)
    material = None if made.case.material is None else read_document(job.inputs, made.case.material, MaterialDocument)
    forward = Forward(job, made.case, material)
    check_unchanged(job, made, [*given.case.readings, *given.case.held])
    _check_places(forward.sheet, [*files.measured, *files.apart])
    with job.console.progress("Closing the loop") as advance:
        draped = pose_sheet(forward, lambda share: advance(0.3 * share, "forward runs"))
    files = _tracked(job, draped, files)
    problem = drape_problem(draped, files.measured, prior=given.surely, fixed=given.case.fix)
    # These drape sheets as this module does.
    from hyperfab.chapters.close_loop.coupled import InsteadOfNet
    from hyperfab.chapters.close_loop.upstream_drape import tracing

    def extend(forward: Forward, problem: DrapeProblem, found: Finding) -> Extension:
        return extend_drape(out, forward.case, material, forward.sheet, forward.placed, problem, found)

    def traced(forward: Forward, problem: DrapeProblem) -> Traces:
        trace = tracing(forward, problem, given, out) if given.case.upstream else None

        def follow_up(found: Finding, result: LoopDocument) -> list[str]:
            return membrane.said(found) + (trace(found, result) if trace is not None else [])

        return follow_up

    membrane = InsteadOfNet(forward, files, given, extend, traced)
    return finish(
        job,
        out,
        problem,
        files,
        given=given,
        axis="from the middle_mm",
        extend=lambda found: extend(forward, problem, found),
        rounds=forward.corrected,
        upstream=traced(forward, problem),
        instead=membrane.closed,
    )


def read_markers(job: Job, name: str, layout: Layout, left_out: Counter[str]) -> list[Markers]:
    """Read markers of each specimen: their places on the flat sheet and on the draped one, or the one of them and how
    far each moved; and the sd of x, y and z where stated.

    Rows without a marker of their own are counted in ``left_out``.
    """
    columns, optional = dict.fromkeys((*FLAT, *"xyz"), "length"), {"x sd": "length", "position sd": "length"}
    moved = [dict.fromkeys((*own, *MOVES), "length") for own in (FLAT, "xyz")]
    data = job.inputs.read(name)
    table = read_table(data, name, columns, instead=moved, optional=optional, whole=True, layout=layout)
    if MOVES[0] in table:
        table = _moved(job, table)
    there, again = np.unique(np.stack([table[one] for one in "xyz"], axis=1), axis=0, return_counts=True)
    for place in there[again >= _LOST]:  # what a camera writes for a marker that it does not see
        same = np.all([table[one] == value for one, value in zip("xyz", place, strict=True)], axis=0)
        if len(np.unique(np.stack([table[one][same] for one in FLAT], axis=1), axis=0)) >= _LOST:
            table = table.without(same, "marker that was not seen, at one place with others")
    parts = at_places(table, FLAT)
    unread(job, name, parts[0])
    found = []
    for one in parts:
        part = once(one, (*"xyz", *optional), left_out)
        sd = spread(part, "position")
        if sd is None:
            sd = spread(part, "x")
        flat, there = (np.stack([part[axis] for axis in axes], axis=1) for axes in (FLAT, "xyz"))
        found.append(Markers(part.name, flat, there, lines=part.lines, sd=None if sd is None else np.tile(sd, 3)))
    return found


def _moved(job: Job, table: Table) -> Table:
    """Return markers whose displacements u, v, w were read with both places: from the flat one to the draped one.

    Of a file that has x, y and z alone the flat places are those whose height stays the same.
    """
    u, v, w = (table[one] for one in MOVES)
    columns = {one: values for one, values in table.columns.items() if one not in MOVES}
    if FLAT[0] in table:
        return replace(table, columns=columns | {"x": table["x0"] + u, "y": table["y0"] + v, "z": w})
    x, y, z = (table[one] for one in "xyz")
    before, behind = float(np.ptp(z)), float(np.ptp(z - w))
    if min(before, behind) > _LEVEL * float(np.ptp(w)):
        raise InputError(
            "neither x, y, z nor these less u, v, w lie on a flat sheet", file=table.name,
            remedy="give the displacements from the flat sheet on, in its plane and along its normal",
        )  # fmt: skip
    flat = before < behind
    columns |= {"x0": x, "y0": y, "x": x + u, "y": y + v, "z": z + w} if flat else {"x0": x - u, "y0": y - v}
    where = "flat" if flat else "draped"
    job.console.note(f"{table.name}: x, y and z are the places on the {where} sheet, u, v and w how far each moved")
    return replace(table, columns=columns)


def _tracked(job: Job, draped: Draped, files: Files[Markers]) -> Files[Markers]:
    """Return the files without markers that were lost, by what the model as delivered leaves of them and of their
    neighbours; each is told and counted."""

    def kept(one: Markers) -> Markers:
        lost = mistracked(one.flat, one.found - at_markers(draped, one.flat)[0][0])
        if lost.size:
            lines = ", ".join(str(one.lines[row]) for row in lost) if one.lines is not None else ""
            job.console.warn(f"{one.name}, line {lines}: off its neighbours, as a marker that was lost is; left out")
            files.left_out[f"{one.name}: marker off its neighbours"] += len(lost)
        return one.of(np.setdiff1d(np.arange(len(one.flat)), lost))

    return replace(files, measured=[*map(kept, files.measured)], apart=[*map(kept, files.apart)])


def _check_places(sheet: Sheet, files: Sequence[Markers]) -> None:
    half, order = 0.5 * np.array(sheet.size), 2 if sheet.round else np.inf
    for one in files:
        away = np.linalg.norm(one.flat / half, order, axis=1)
        worst = int(np.argmax(away))
        if away[worst] > 1.0 + 1e-6:
            x, y = one.flat[worst]
            raise InputError(
                f"the marker at ({x:g}, {y:g}) mm is not on the sheet of {sheet.size[0]:g} by {sheet.size[1]:g} mm",
                file=one.name,
                remedy="count x0 and y0 from the middle of the flat sheet, along warp and weft",
            )
        if away[worst] < _SPREAD:
            raise InputError(
                f"all markers lie within {100.0 * away[worst]:.2g} % of the sheet of {sheet.size[0]:g} by "
                f"{sheet.size[1]:g} mm, about its middle",
                file=one.name,
                remedy="look at the units of their places",
            )


class Forward:
    """The forward model on the loop's coarse grid."""

    def __init__(self, job: Job, case: DrapeCase, material: MaterialDocument | None) -> None:
        self.case, self.material = case, material
        # Laws that came straight from tests are scaled along warp and weft.
        self.names, self.scales = (("warp", "weft"), (True, True)) if material is None else linear_of(material)
        self.widths = np.ones(len(self.names))
        if material is not None:
            self.widths = widths(material.model, material.parameters, self.names)
        # What the files are warned of was said when the document was made.
        self.job = replace(job, console=Listener())
        self.files = read_files(self.job, case)
        self.sheet = model_of(case, self.files).sheet
        n, m = case.grid
        share = min(1.0, (_NODES - 1) / (max(n, m) - 1))
        self.grid = max(round((n - 1) * share) + 1, 5), max(round((m - 1) * share) + 1, 5)

    def model(self, law: Array, added: Mapping[str, float], grid: tuple[int, int] | None = None) -> Model:
        """Return the model with relative constants of the laws, in the order of ``names``, and added effects.

        On a grid that is asked for it takes the load steps that the command does, else few.
        """
        case = replace(drape_applied(self.case, added), grid=grid or self.grid, load_steps=None)
        if case.has_friction:
            case = replace(case, load_steps=(self.case.load_steps or LOAD_STEPS) if grid else _STEPS)
        ratios = {name: float(ratio) for name, ratio in zip(self.names, law, strict=True)}
        files = replace(self.files, placed=self.placed(added))
        if self.material is not None and any(v != 1.0 for v in ratios.values()):
            changed = dump_json(scaled_material(self.material, ratios).to_json())
            inputs = Overlay({str(case.material): changed})
            files = replace(files, fabric=read_fabric(replace(self.job, inputs=inputs), case))
        elif self.material is None:
            warp, weft = (
                replace(thread, pieces=thread.pieces * ratios[way])
                for way, thread in (("warp", self.sheet.warp), ("weft", self.sheet.weft))
            )
            files = replace(files, fabric=files.fabric.with_laws(warp, weft))
        return model_of(case, files)

    def placed(self, added: Mapping[str, float]) -> PlacedMold:
        """Return the mold, as much larger as what is added says."""
        return self.files.placed.larger(*(added.get(way, 0.0) for way in SIZES))

    def nodes(self, law: Array, added: Mapping[str, float], grid: tuple[int, int] | None = None) -> Array:
        """Return where the nodes (n, m, 3) rest; NotConverged where there is no equilibrium."""
        return np.asarray(self.rest(self.model(law, added, grid)).state.x)

    def rest(self, model: Model) -> Equilibrium:
        """Return the equilibrium of a model at its depth; NotConverged where there is none."""
        rise = model.case.wanted[-1]
        try:
            if model.case.load_steps is not None:
                heights = load_steps([rise], model.case.load_steps)
                path = follow(model.sheet, model.mold, heights, model.case.friction, _TOLERANCE, enough=_NEAR)
                rest = list(path)[-1]
                found, there = rest.found, bool(np.isclose(rest.height, rise))
            else:
                found, there = drape(model.sheet, raised(model.mold, rise), _TOLERANCE), True
        except HeldNodeInside as error:
            raise NotConverged(str(error)) from None
        if found.residual_relative > _NEAR or not there:
            raise NotConverged("the sheet finds no equilibrium")
        return found

    def corrected(self, problem: DrapeProblem, found: Finding) -> DrapeProblem | None:
        """Return the problem with runs at and around what was found, where the nodes rest elsewhere than thought."""
        draped, fit, sd = problem.draped, found.after.fit, found.noise.sd
        own, amounts = np.asarray(fit.x[: fit.own]), problem.amounts(fit.terms)
        settings = settings_of(draped, own, amounts)

        def is_off(gone: Array) -> bool:
            return float(np.sqrt(np.mean((gone / sd[: len(gone)]) ** 2))) >= _OFF

        better = problem
        try:
            true = self.at(draped.kriged.axes, settings)
            off = (true - draped.kriged(settings)).reshape(-1, 3)
            if is_off(np.concatenate([(w @ off).T.ravel() for w in problem.weights])):
                better = problem.on(replace(draped, kriged=self._beside(draped.kriged, settings, true)))
            # The loop's own grid and load steps are coarser than those of the model that is written.
            there = self._finer(draped, settings)
            finest = problem.on(replace(better.draped, finer=(*draped.finer, there)))
            if is_off(np.concatenate(finest.at(own, amounts)) - np.concatenate(better.at(own, amounts))):
                better = finest
                # By how much is no straight line in what was added: half of it too.
                half = 0.5 * (settings + [axis.base for axis in draped.kriged.axes])
                better = problem.on(replace(finest.draped, finer=(*finest.draped.finer, self._finer(draped, half))))
        except NotConverged:
            pass
        return None if better is problem else better

    def _finer(self, draped: Draped, settings: Array) -> tuple[Array, Array]:
        """Return settings and the nodes (n, m, 3) there on the document's own grid."""
        nodes = self.at(draped.kriged.axes, settings, (self.sheet.n, self.sheet.m))
        return settings, nodes.reshape(self.sheet.n, self.sheet.m, 3)

    def _beside(self, kriged: Kriged, settings: Array, true: Array) -> Kriged:
        """Return what is emulated with runs at ``settings``, where the nodes are ``true``, and beside them."""
        places, values = [settings], [true]
        for index, axis in enumerate(kriged.axes):
            beside = settings.copy()
            # Inwards where the reach ends.
            way = -1.0 if settings[index] + _ASIDE * axis.up > axis.base + axis.up else 1.0
            beside[index] += way * _ASIDE * axis.up
            try:
                values.append(self.at(kriged.axes, beside))
            except NotConverged:
                continue
            places.append(beside)
        return kriged.with_runs(np.stack(places), np.stack(values))

    def at(self, axes: Sequence[Setting], settings: Array, grid: tuple[int, int] | None = None) -> Array:
        """Return the nodes (3 n m,) at settings of the axes: those of the laws' constants stand first."""
        count = len(self.names)
        added = {axis.name: float(v) for axis, v in zip(axes[count:], settings[count:], strict=True)}
        return self.nodes(settings[:count], added, grid).ravel()


def pose_sheet(forward: Forward, tick: Callable[[float], None]) -> Draped:
    """Drape the sheet at chosen settings of its constants and effects, and return what stands for it."""
    sheet, plain = forward.sheet, np.ones(len(forward.names))
    # A modulus of the threads sets the scale of what resists shear, and of the weight that shows.
    modulus = float(np.mean([float(law(1.001)[2][0]) for law in (sheet.warp, sheet.weft)]))
    heavy = _SAG * modulus * sheet.thickness / (GRAVITY * 1e-9 * max(sheet.size))
    down = min(max(min(sheet.prestretch) - _SLACK, 0.0), 0.1)
    axes = [
        Setting(f"law {name}", 1.0, _STIFFER * far, min(_STIFFER * far, _LEAST), mixes=False)
        for name, far in zip(forward.names, forward.widths, strict=True)
    ]
    axes += [
        Setting("depth", 0.0, 0.4, 0.4, mixes=False),
        Setting("prestretch", 0.0, _MOST_STRETCH, down),
        Setting("weft more", 0.0, _MOST_STRETCH, _MOST_STRETCH),
        Setting("friction", 0.0, _MOST_FRICTION),
    ]
    if sheet.membrane is None:  # a membrane's law has its own shear
        axes.append(Setting("shear", 0.0, 0.4 * modulus))
    axes += [Setting(way, 0.0, _LARGER, _LARGER, mixes=False) for way in SIZES]
    aside = _SIDEWAYS * min(sheet.size)
    axes += [Setting(way, 0.0, aside, aside, mixes=False) for way in ASIDE]
    axes.append(Setting("mass", 0.0, float(np.clip(heavy, *_MASSES))))
    model = forward.model(plain, {})
    rest = forward.rest(model)
    base = np.asarray(rest.state.x)
    settings, values = [np.array([axis.base for axis in axes])], [base.ravel()]
    plan = places(axes)
    for count, place in enumerate(plan):
        at = np.array([axis.base + axis.up * place.get(axis.name, 0.0) for axis in axes])
        try:
            values.append(forward.at(axes, at))
            settings.append(at)
        except NotConverged:
            continue  # no rest there: the others tell as much as can be told
        finally:
            tick((count + 1) / len(plan))
    axes = [reached(axis, np.array(settings)[:, i]) for i, axis in enumerate(axes)]
    if max(sheet.n, sheet.m) > _NODES or model.case.has_friction:
        model = forward.model(plain, {}, (sheet.n, sheet.m))
        rest = forward.rest(model)
    told = answers(model.sheet, raised(model.mold, model.case.wanted[-1]), rest)
    note_ranges(forward.job, forward.files.fabric, told.stretch_warp, told.stretch_weft)
    case = forward.case
    alike = not case.blank_holder and case.shear_law is None
    carried = (case.shear_modulus or 0.0, case.mass) if alike else None
    kriged = krige(axes, np.array(settings), np.array(values))
    fine = np.asarray(rest.state.x)
    return Draped(
        kriged, forward.grid, fine, sheet.size, forward.names, forward.scales, carried, sheet.round,
        widths=tuple(forward.widths),
    )  # fmt: skip
