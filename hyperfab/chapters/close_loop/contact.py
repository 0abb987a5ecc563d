"""The loop on a punched sheet: a contact document against force over depth."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial

import numpy as np
from scipy.interpolate import CubicSpline

from hyperfab.arrays import Array
from hyperfab.cases.contact import ContactCase
from hyperfab.chapters.close_loop.domain import Given
from hyperfab.chapters.close_loop.extended_sheet import FABRIC, PRESSED, contact_applied, extend_contact
from hyperfab.chapters.close_loop.finalise import MODEL_SUFFIXES, finish
from hyperfab.chapters.close_loop.readings import read_files, spread, stated_in, unread
from hyperfab.chapters.close_loop.softening import linear_of, scaled_material
from hyperfab.chapters.close_loop.taken import AS_READ, once, past_touch, pushed, specimens
from hyperfab.chapters.fabric import FabricDocument
from hyperfab.chapters.fabric_contact.setup import read_geometry, setup_of
from hyperfab.chapters.fit.prepare import Steps
from hyperfab.chapters.job import Job
from hyperfab.chapters.rerun import Listener, Overlay, check_unchanged, unchanged
from hyperfab.chapters.sheet import read_fabric
from hyperfab.documents.base import parse_document, read_document
from hyperfab.documents.contact import ContactDocument
from hyperfab.documents.material import MaterialDocument
from hyperfab.errors import NotConverged
from hyperfab.io.csv_table import read_tables
from hyperfab.io.json_io import dump_json
from hyperfab.io.layout import Layout
from hyperfab.loop.contact import ContactProblem, ForceDepth, Sheet, contact_problem
from hyperfab.loop.emulator import Axis as Setting
from hyperfab.loop.emulator import Emulator, emulate
from hyperfab.loop.engine import Finding
from hyperfab.loop.slack import Slack
from hyperfab.materials.registry import bind
from hyperfab.membrane.contact import Coulomb, Stick
from hyperfab.membrane.equilibrium import NoEquilibriumError, State
from hyperfab.membrane.measures import fields
from hyperfab.membrane.sheet import Sheet as SheetAlone
from hyperfab.membrane.sphere_contact import SphereTest, rough_path

#: Depths the force is emulated at; the mesh of the loop, relative to half the sheet, and the order of its elements.
_KNOTS, _MESH, _ORDER = 12, 0.16, 1
#: How far an added prestretch and the friction may go.
_MOST_STRETCH, _MOST_FRICTION = 0.10, 0.8
#: How much a clamp may give [mm2/N], as --rim-slip: of a depth of next to nothing the sheet's tension says no end.
_MOST_SLIP = 1e4
#: How much larger or smaller a sphere may be than is stated, and how near to the clamp: shares of it.
_LARGER, _CLEAR = 0.15, 0.94
_ROOM_TEMPERATURE = 23.0


def run(job: Job, given: Given) -> int:
    """Close the loop on a contact document."""
    out = job.opened(*MODEL_SUFFIXES, FABRIC, ".png", ".csv")
    made = unchanged(ContactCase, given.data, given.case.model)
    files = read_files(job, given, partial(read_force_depth, steps=given.how.steps), ("force",))
    out.refuse_inputs(job.inputs)
    document = parse_document(given.data, given.case.model, ContactDocument)
    material = read_document(job.inputs, made.case.material, MaterialDocument)
    forward = Forward(job, made.case, material)
    note_temperatures(job, FabricDocument(material, made.case.material), files.measured)
    check_unchanged(job, made, [*given.case.readings, *given.case.held])
    with job.console.progress("Closing the loop") as advance:
        sheet = pose_sheet(forward, document, files.measured, lambda s: advance(0.3 * s, "forward runs"))
    problem = pose(sheet, files.measured, material, given.surely, given.case.fix, made.case.temperature)
    return finish(
        job,
        out,
        problem,
        files,
        given=given,
        extend=lambda found: extend_contact(out, made.case, material, problem, found),
        rounds=forward.corrected,
    )


def note_temperatures(job: Job, fabric: FabricDocument, files: Sequence[ForceDepth]) -> None:
    """Note the temperatures at which force over depth was read, beside those that the fabric was tested at."""
    for one in files:
        met = () if one.temperature is None else one.temperature
        job.ranges.used("temperature_degC", met, known=fabric.known or None, source=fabric.name)


def read_force_depth(
    job: Job, name: str, layout: Layout, left_out: Counter[str], steps: Steps = AS_READ
) -> list[ForceDepth]:
    """Read depth and force of each specimen, with temperature from a column or the metadata; and the force's sd column.

    Rows without a reading of their own are counted in ``left_out``.
    """
    optional = {"temperature": "temperature", "force sd": "force"}
    columns, data = {"depth": "length", "force": "force"}, job.inputs.read(name)
    tables = read_tables(data, name, columns, along="depth", optional=optional, layout=layout)
    parts = [part for one in tables for part in specimens(one, "depth")]
    unread(job, name, parts[0])
    found = []
    for one in parts:
        part = once(pushed(job, one, "depth", steps), ("force", "force sd"), left_out, along="depth")
        temperature, stated = part.columns.get("temperature"), stated_in(part, "temperature")
        if temperature is None and stated is not None:
            temperature = np.full(len(part["depth"]), stated)
        friction = stated_in(part, "friction", "dimensionless")
        sd = spread(part, "force")
        found.append(ForceDepth(part.name, part["depth"], part["force"], temperature, friction=friction, sd=sd))
    return found


def pose_sheet(
    forward: Forward,
    document: ContactDocument,
    files: Sequence[ForceDepth],
    tick: Callable[[float], None],
) -> Sheet:
    """Run the sheet on a sparse grid of its constants and effects, on a coarse mesh, and return what stands for it."""
    test = forward.test()
    for pushed_in in files:
        past_touch(pushed_in.name, pushed_in.depth, "depth")
    deepest = float(max(np.max(one.depth) for one in files))
    knots = np.linspace(0.0, 1.02 * deepest, _KNOTS + 1)[1:]
    names, linear = linear_of(forward.material)
    first = linear.index(True) if any(linear) else -1
    reach = 0.35
    axes = [Setting(one, 1.0, reach, reach, level=1, mixes=False) for i, one in enumerate(names) if i != first]
    held, states = forward.states(test, knots)
    base = np.array([state.force for state in states]) / knots
    # A sheet that hangs slack carries nothing: its law is not asked below 1.
    met = np.maximum(fields(held, states[-1].places).stretch, 1.0)
    forward.job.ranges.used(
        "stretch", met, known=forward.fabric.tested, source=forward.fabric.name, then="extrapolated"
    )
    tension = float(base[-1] * knots[-1]) / (2.0 * np.pi * 0.5 * test.outline.reach)
    # From the model on: taut or slacker where the model is taut already.
    down = min(test.prestretch - 1.0, 0.05) if test.prestretch > 1.0 else 0.0
    slips = min(0.06 * test.outline.reach / max(tension, 1e-9), _MOST_SLIP)
    sticks = isinstance(test.friction, Stick)
    # Down to none: a test may tell that its punch was oiled.
    coefficient = test.friction.coefficient if isinstance(test.friction, Coulomb) else 0.0
    larger = _larger(test)
    if larger:
        axes.append(Setting("sphere", 0.0, larger, larger, level=1, mixes=False))
    axes += [
        Setting("prestretch", 0.0, _MOST_STRETCH, down),
        Setting("friction", 0.0, _MOST_FRICTION, coefficient, level=0 if sticks else 2, mixes=not sticks),
        Setting("slip", 0.0, slips),
    ]

    # Over a ball a sheet as long as its rim is wide bears at once.
    at_once = test.prestretch == 1.0 and test.facets is None
    slack = Slack(test.radius, test.outline.reach, float(knots[-1])) if at_once else None
    runs: dict[tuple[float, ...], Array] = {}

    def one(settings: Array) -> Array:
        key = tuple(float(v) for v in settings)
        if key not in runs:
            ratios = dict(zip((axis.name for axis in axes), key, strict=True))
            here = None if slack is None else slack.over(ratios.get("sphere", 0.0))
            runs[key] = np.concatenate(forward.path(forward.test(ratios), knots, here, ratios["prestretch"]))
        return runs[key]

    emulator = _emulated(one, axes, lambda share: tick(0.75 * share if slack else share))
    slacker = None
    if slack is not None and slack.most > 0.0:
        # The one side bends where the sheet begins to hang: each has a polynomial of its own.
        reached = [replace(axis, up=-slack.most) if axis.name == "prestretch" else axis for axis in emulator.axes]
        slacker = _emulated(one, reached, lambda share: tick(0.75 + 0.25 * share))
    correction = _finer(document, knots, base, test.frame)
    return Sheet(
        emulator, knots, correction, names, linear, np.ones_like(knots),
        friction=not sticks, coefficient=coefficient, slip=test.rim_slip, frame=test.frame,
        slack=slack, slacker=slacker,
    )  # fmt: skip


def _larger(test: SphereTest) -> float:
    """Return by how much the radius of the sphere may be off [mm]: 0 of a punch, and of one that nearly fills the
    clamp."""
    free = _CLEAR * test.prestretch * test.outline.reach - test.radius
    return 0.0 if test.facets is not None or free < 0.02 * test.radius else min(_LARGER * test.radius, free)


def _emulated(run: Callable[[Array], Array], axes: Sequence[Setting], tick: Callable[[float], None]) -> Emulator:
    """Return the polynomial of runs that reaches as far as the sheet has an equilibrium."""
    for _ in range(4):
        try:
            return emulate(run, axes, tick)
        except NoEquilibriumError:
            axes = [replace(axis, up=0.5 * axis.up, down=0.5 * axis.down) for axis in axes]
    raise NotConverged("the sheet has no equilibrium near the model's constants", remedy="measure to a smaller depth")


class Forward:
    """The forward model on the loop's coarse mesh."""

    def __init__(self, job: Job, case: ContactCase, material: MaterialDocument) -> None:
        self.case, self.material = case, material
        # What the files are warned of was said when the document was made.
        self.job = replace(job, console=Listener())
        self.geometry = read_geometry(self.job, case)
        self.fabric = read_fabric(self.job, case.material, case.temperature, case.thickness)

    def test(self, settings: Mapping[str, float] = {}) -> SphereTest:
        """Return the test with relative law constants and added effects."""
        fabric = self.fabric
        ratios = {key: value for key, value in settings.items() if key not in PRESSED}
        if any(value != 1.0 for value in ratios.values()):
            changed = dump_json(scaled_material(self.material, ratios).to_json())
            job = replace(self.job, inputs=Overlay({self.case.material: changed}))
            fabric = read_fabric(job, self.case.material, self.case.temperature, self.case.thickness)
        test = setup_of(contact_applied(self.case, settings), self.geometry, fabric).test(fabric)
        return replace(test, mesh_size=max(test.mesh_size, _MESH * test.outline.reach), order=_ORDER)

    def path(
        self, test: SphereTest, knots: Array, slack: Slack | None = None, added: float = 0.0
    ) -> tuple[Array, Array]:
        """Return force over depth at ``knots`` (k,) [N/mm] and the pull of the rim there; NoEquilibriumError where
        they are not all reached. Of a sheet slack by ``added``, below 0, over the depths as ``slack`` tells them."""
        depths = knots if slack is None else slack.depths(knots, added)
        held, states = self.states(test, depths)
        pulls = [held.pull(state.places) for state in states]
        over = knots if slack is None else slack.taut(depths, added)
        return np.array([state.force for state in states]) / over, np.array(pulls)

    def states(self, test: SphereTest, knots: Array) -> tuple[SheetAlone, Sequence[State]]:
        """Return the sheet and its states at depths ``knots`` (k,); NoEquilibriumError where not all are reached."""
        press, path = rough_path(test, [float(v) for v in knots])
        if path.limit is not None or len(path.states) < len(knots):
            raise NoEquilibriumError("the path ends early")
        return SheetAlone(press.sheet.mesh, test.law, test.thickness, test.prestretch), path.states

    def corrected(self, problem: ContactProblem, found: Finding) -> ContactProblem | None:
        """Return the problem with the force corrected by a run of what was found, where the emulated one is off."""
        sheet, fit = problem.sheet, found.after.fit
        own, effects = np.asarray(fit.x[: fit.own - 1]), problem.added(fit.terms)
        if effects[3] > 0.0:
            # A clamp that holds at first is no spring: there is no such run.
            return None
        scale = sheet.scale(own)
        settings = {key: float(v) / scale if one else float(v)
                    for key, v, one in zip(sheet.names, own, sheet.linear, strict=True)}  # fmt: skip
        slip = float(sheet.slips(own, effects, 1.0)[0])
        settings |= {"prestretch": effects[0], "friction": effects[1], "slip": slip, "sphere": effects[5]}
        slack = sheet.slack_of(float(effects[5]))
        try:
            true = self.path(self.test(settings), sheet.knots, slack, float(effects[0]))[0] * scale
        except NoEquilibriumError:
            return None
        plain = replace(sheet, correction=np.ones_like(sheet.correction))
        ratio = true / plain.stiffness(own, effects, 1.0)
        read = problem.states["depth_mm"]
        force = sheet.force(own, effects, read)
        depth = read - (sheet.frame + effects[4]) * force
        depth = depth if slack is None else slack.knots(depth, float(effects[0]))
        off = force * (np.interp(depth, sheet.knots, ratio / sheet.anchor) - 1.0)
        if float(np.sqrt(np.mean((off / found.noise.sd[: len(off)]) ** 2))) < 0.2:
            return None
        anchored = replace(sheet, correction=sheet.correction * ratio / sheet.anchor, anchor=ratio)
        return replace(problem, sheet=anchored)


def _finer(document: ContactDocument, knots: Array, base: Array, frame: float) -> Array:
    """Return what the document's own, finer meshes say of the force at the knots, over the coarse one.

    Its depths are as a machine reads them that yields by ``frame`` [mm/N].
    """
    known = np.array([(depth - frame * force, force) for depth, force in document.force_depth if depth > 0.0])
    if not len(known):
        return np.ones_like(knots)
    inside = (known[:, 0] >= knots[0]) & (known[:, 0] <= knots[-1])
    if not np.any(inside):
        return np.ones_like(knots)
    coarse = CubicSpline(knots, base)(known[inside, 0]) * known[inside, 0]
    ratio = known[inside, 1] / coarse
    # Beyond a few percent it is no error of the mesh: the document was computed in another way.
    return np.interp(knots, known[inside, 0], np.clip(ratio, 0.95, 1.05))


def pose(
    sheet: Sheet,
    files: Sequence[ForceDepth],
    material: MaterialDocument,
    prior: float,
    fix: Sequence[str],
    run_at: float | None = None,
) -> ContactProblem:
    """Return the problem of a sheet, run at a temperature or that of its material, and its force-depth files."""
    own = material.temperature_degC if material.temperature_degC is not None else _ROOM_TEMPERATURE
    reference = own if run_at is None else run_at
    if material.temperatures:
        files = [one if one.temperature is None else replace(one, softened=_known(material, one.temperature, reference))
                 for one in files]  # fmt: skip
    return contact_problem(sheet, files, reference_degC=reference, prior=prior, fixed=fix)


def _known(material: MaterialDocument, temperature: Array, reference: float) -> Array:
    """Return what the material document itself says of the stiffness at temperatures, over that of the run."""

    def at(degrees: float) -> Mapping[str, float]:
        return FabricDocument(material, "", degrees).constants()

    here = at(reference)
    key = max(bind(material.model, here).law.stresses, key=lambda one: abs(here[one]))
    return np.array([at(float(v))[key] / here[key] for v in temperature])
