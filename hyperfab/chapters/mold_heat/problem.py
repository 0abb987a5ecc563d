"""From a mold document to the equations: geometry, mesh, materials and conditions, each mistake named by its key."""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import dataclass, field

import numpy as np

from hyperfab.arrays import Array
from hyperfab.chapters.field import read_field
from hyperfab.chapters.mold_heat.conditions import Placing
from hyperfab.chapters.mold_heat.meshing import geometry_of, mesh_mold
from hyperfab.chapters.mold_heat.production import Pieces, pieces_of
from hyperfab.chapters.mold_heat.tables import Tables, refuse_exposed, refuse_unknown_names
from hyperfab.documents.base import read_document
from hyperfab.documents.heat import HeatDocument
from hyperfab.documents.mold import EarlierField, MoldDocument, ProbeSection
from hyperfab.errors import InputError, placed
from hyperfab.io.inputs import Inputs
from hyperfab.io.vtu_read import Grid
from hyperfab.thermal.apart import Apart, apart, barely
from hyperfab.thermal.condition import Renewal, Thermostat
from hyperfab.thermal.faces import Faces
from hyperfab.thermal.facet_operator import FacetOperator
from hyperfab.thermal.geometry import Geometry
from hyperfab.thermal.locate import Locator
from hyperfab.thermal.medium import ThermalMaterial
from hyperfab.thermal.mesh import HeatMesh, build_mesh, split_contacts
from hyperfab.thermal.mesher import RawMesh, mesh_job
from hyperfab.thermal.model import HeatModel
from hyperfab.thermal.plausibility import doubts
from hyperfab.thermal.tables import Table

#: A mesh whose volume is off by more than this share follows the curves of a part too coarsely.
COARSE = 0.005
#: A node further than this many elements outside the earlier mold has no temperature there.
BEYOND = 1.5
#: A place that is less of an element outside a part, and of another, is on both.
ON_JOINT = 1e-3


@dataclass
class Problem:
    """A mold ready to be heated."""

    model: HeatModel
    geometry: Geometry
    faces: Faces
    probes: dict[str, Array]
    lags: dict[str, tuple[float, float]]
    work_surface: FacetOperator | None
    thermostats: list[Thermostat]
    corners: list[float]
    renewals: list[Renewal]
    areas: dict[str, float]
    notes: list[str] = field(default_factory=list)
    pieces: Pieces | None = None

    @property
    def mesh(self) -> HeatMesh:
        """The mesh."""
        return self.model.mesh


class MoldBuilder:
    """Turns ``document`` (file ``name``) into equations.

    Made, it has read all files the document names and refused what makes no sense without a mesh; ``build`` meshes.
    Raises InputError naming file and key.
    """

    def __init__(self, document: MoldDocument, name: str, inputs: Inputs, stl_unit: str = "mm") -> None:
        self.document = document
        self.name = name
        self._read_by = inputs, stl_unit
        self.tables = Tables(inputs, name)
        self.doubts: list[str] = []
        self.corners: set[float] = set()
        with placed(name):
            refuse_exposed(document)
            refuse_unknown_names(document)
        self.materials = {key: self._material(key) for key in document.material}
        self.functions = self._read_functions()
        self.geometry = geometry_of(document, name, inputs, stl_unit, self.doubts)
        start = document.run.start
        #: The mesh once it is made, with the geometry that was meshed.
        self.meshed: tuple[Geometry, RawMesh] | None = None
        self.earlier: Grid | None = None
        if isinstance(start, EarlierField):
            heat = inputs.beside(name, start.document)
            self.earlier = read_field(inputs, heat, read_document(inputs, heat, HeatDocument))

    def of(self, document: MoldDocument) -> MoldBuilder:
        """Return a builder of a changed document of the same file."""
        return MoldBuilder(document, self.name, *self._read_by)

    def take_mesh(self, other: MoldBuilder) -> None:
        """Take the mesh that another builder has made, where it is one of the same bodies."""
        asked = [mesh_job(one.geometry, one.document.run.mesh_size) for one in (self, other)]
        if other.meshed is not None and asked[0] == asked[1]:
            self.meshed = other.meshed

    def build(
        self,
        waiting: Callable[[float], None] = lambda seconds: None,
        say: Callable[[str], None] = lambda text: None,
    ) -> Problem:
        """Mesh the mold and set up its equations.

        While the mesher works ``waiting`` is called, and ``say`` with what the mold is as a whole.
        """
        with placed(self.name):
            problem = self._build(waiting, say)
        return problem

    def _build(self, waiting: Callable[[float], None], say: Callable[[str], None]) -> Problem:
        document = self.document
        notes: list[str] = []
        if self.meshed is None:
            self.meshed = mesh_mold(
                self.geometry,
                document.run.mesh_size,
                self.name,
                notes,
                waiting,
                lambda volumes: say(self.as_one_body(volumes * 1e-9)),
            )
        geometry, raw = self.meshed
        mesh = build_mesh(raw.points / 1e3, raw.elements, raw.parts, raw.surface, raw.surface_face)
        self.doubts += [self._alone(one) for one in apart(mesh)]
        self.doubts += [self._barely(*pair) for pair in barely(mesh)]
        faces = Faces(mesh, geometry)
        joints = []
        split = np.zeros(len(mesh.facets.element), dtype=bool)
        for number, contact in enumerate(document.contact):
            with placed(key=f"contact.{number}.between"):
                joints.append(faces.interface(*contact.between))
            split |= joints[-1].mask
        mesh = split_contacts(mesh, split)
        placing = Placing(document, Faces(mesh, geometry), joints, self.functions)
        laid = pieces_of(document, placing)
        if laid is not None:
            mesh = placing.mesh = laid[0]
        prescribed = placing.prescribed()
        materials = [self.materials[part.material] for part in document.part]
        conditions = placing.conditions()
        notes += placing.notes
        pieces = None if laid is None else laid[1](placing, mesh)
        if pieces is not None:
            conditions.append(pieces.lying)
        loose = np.zeros(0) if pieces is None else pieces.piece.capacity
        model = HeatModel(mesh, materials, conditions, prescribed, loose)
        meshed = model.medium.masses / [material.density for material in materials]
        for part, volume, exact in zip(document.part, meshed, raw.volumes * 1e-9, strict=True):
            if abs(volume / exact - 1.0) > COARSE:
                self.doubts.append(
                    f"part {part.name!r} has {100.0 * abs(volume / exact - 1.0):.2g} % "
                    f"{'less' if volume < exact else 'more'} volume in its mesh than by its shapes: its curves are "
                    "followed better with a smaller mesh_size"
                )
        placing.fill_volume_heaters(model)
        probes = self._probes(mesh)
        work = None
        if document.work_surface is not None:
            work = placing.operator(placing.facets_of("work_surface.on", document.work_surface.on))
        thermostats = [
            Thermostat(heater, probes[section.control.probe], section.control.set_point, section.control.band)
            for section, heater in zip(document.heater, model.heaters, strict=True)
            if section.control is not None
        ]
        return Problem(
            model=model,
            geometry=geometry,
            faces=placing.faces,
            probes=probes,
            lags={probe.name: probe.lags for probe in document.probe},
            work_surface=work,
            thermostats=thermostats,
            corners=sorted(self.corners),
            renewals=self._renewals(mesh) + (pieces.turns(placing.bare) if pieces is not None else []),
            areas=placing.areas,
            notes=notes,
            pieces=pieces,
        )

    def _alone(self, one: Apart) -> str:
        """Say that bodies touch no other, and how far the nearest is."""
        own = [repr(self.document.part[number].name) for number in one.parts]
        whose = ("" if one.whole else "a body of ") + f"part{'s' if len(own) > 1 else ''} {' and '.join(own)}"
        touches = "touches" if len(own) == 1 else "touch each other and"
        nearest = repr(self.document.part[one.nearest].name)
        return (
            f"{whose} {touches} no other: the nearest, {nearest}, is {1e3 * one.gap:.2g} mm away, and no heat passes "
            "between them; if they are to touch, let their faces lie in one plane"
        )

    def _barely(self, first: int, second: int) -> str:
        """Say that two parts meet in no face."""
        one, other = (repr(self.document.part[number].name) for number in (first, second))
        return (
            f"parts {one} and {other} meet in an edge or a point alone, and the heat that passes there is the mesh's "
            "doing: let faces of both lie in one plane, or leave a gap between them"
        )

    def as_one_body(self, volumes: Array) -> str:
        """Say what the parts, of these volumes [m^3], weigh, and what takes them to the target if nothing is lost.

        That comes long before the mesh, and shows a wrong unit or constant.
        """
        document = self.document
        run, start = document.run, document.run.start
        materials = [self.materials[part.material] for part in document.part]
        masses = [volume * material.density for volume, material in zip(volumes, materials, strict=True)]
        said = f"the mold weighs {sum(masses):.4g} kg"
        if run.target is None or isinstance(start, EarlierField):
            return said
        heat = 0.0
        for part, mass, material in zip(document.part, masses, materials, strict=True):
            cold = start if part.start is None else part.start
            ends = material.specific_heat.integral(np.array([cold, run.target]))
            heat += mass * float(ends[1] - ends[0])
        said += f"; {heat / 1e6:.3g} MJ take it to {run.target:g} degC"
        powers = [heater.power for heater in document.heater if heater.schedule is None]
        power = sum(one for one in powers if one is not None)
        if None in powers or len(powers) < len(document.heater) or document.temperature or power <= 0.0:
            return said
        return f"{said}, {heat / power / 60.0:.3g} min of {power:g} W if it were even and lost nothing"

    @property
    def around(self) -> tuple[float, float]:
        """The least and greatest temperature [degC] of all the mold stands in, is held at or has laid on it, ever."""
        tables = [
            table.y for key, table in self.functions.items() if key.endswith("ambient") or key.startswith("temperature")
        ]
        pieces = [contact.fresh for contact in self.document.contact if contact.fresh is not None]
        met = np.concatenate([*tables, pieces])
        return float(met.min(initial=np.inf)), float(met.max(initial=-np.inf))

    def _renewals(self, mesh: HeatMesh) -> list[Renewal]:
        """Return when parts that come fresh are put in: each time their contact closes."""
        names = [part.name for part in self.document.part]
        found = []
        for number, contact in enumerate(self.document.contact):
            if contact.fresh is None:
                continue
            name = contact.between[1]
            nodes = np.unique(mesh.elements[mesh.parts == names.index(name)])
            others = np.unique(mesh.elements[mesh.parts != names.index(name)])
            if np.isin(nodes, others).any():
                raise InputError(
                    f"{name!r} also touches a part without a [[contact]], so it cannot come fresh",
                    key=f"contact.{number}.fresh",
                    remedy="give each of its joints a [[contact]]",
                )
            closed = self.functions[f"contact.{number}"]
            opened = np.flatnonzero((closed.y[:-1] == 0.0) & (closed.y[1:] > 0.0))
            times = tuple(float(t) for t in closed.x[opened] if t >= 0.0)
            # One that is closed as the run begins holds a new part too, unless something else says how that begins.
            begun = (
                isinstance(self.document.run.start, EarlierField)
                or self.document.part[names.index(name)].start is not None
            )
            if closed.at(0.0) > 0.0 and not begun:
                times = (0.0, *times)
            found.append(Renewal(f"fresh {name}", nodes, contact.fresh, times))
        return found

    def start_field(self, problem: Problem) -> Array:
        """Return the temperatures at the start (n,) [degC]."""
        start, solid = self.document.run.start, problem.mesh.solid
        field = np.zeros(problem.model.size)
        if problem.pieces is not None:
            problem.pieces.fresh(field)
        own = {number: part.start for number, part in enumerate(self.document.part) if part.start is not None}
        if isinstance(start, EarlierField):
            assert self.earlier is not None
            field[:solid] = start_from(self.earlier, problem.mesh, self.name, own)
        else:
            field[:solid] = start
        if own:
            by_part = np.repeat(field[:solid, None], len(self.document.part), axis=1)
            for number, temperature in own.items():
                by_part[:, number] = temperature
            field[:solid] = problem.model.medium.joined(by_part)
        for renewal in problem.renewals:
            if 0.0 in renewal.times:
                renewal.apply(field)
        return field

    def _material(self, key: str) -> ThermalMaterial:
        section = self.document.material[key]
        conductivity = self.tables.function(section.conductivity, "conductivity")
        specific_heat = self.tables.function(section.specific_heat, "specific-heat")
        room = 20.0
        self.doubts += [
            f"{self.name}, material.{key}: {text}"
            for text in doubts(key, section.density, conductivity.at(room), specific_heat.at(room))
        ]
        return ThermalMaterial(key, section.density, conductivity, specific_heat)

    def _read_functions(self) -> dict[str, Table]:
        """Read all tables of conditions, by key; corners of those against time are hit by the time steps."""
        document, found = self.document, {}
        for i, convection in enumerate(document.convection):
            found[f"convection.{i}"] = self.tables.function(convection.h, "film-coefficient")
        around = {f"temperature.{i}": held.value for i, held in enumerate(document.temperature)}
        around |= {f"convection.{i}.ambient": film.ambient for i, film in enumerate(document.convection)}
        around |= {f"radiation.{i}.ambient": face.ambient for i, face in enumerate(document.radiation)}
        timed = {key: self.tables.function(own, "temperature", "time") for key, own in around.items()}
        for i, heater in enumerate(document.heater):
            if heater.schedule is not None:
                timed[f"heater.{i}"] = self.tables.file(heater.schedule, "power", "time")
                if heater.power is not None:
                    self.doubts.append(f"heater.{i}: its schedule says the power, power beside it is not used")
        for i, contact in enumerate(document.contact):
            if contact.schedule is not None:
                timed[f"contact.{i}"] = self.tables.file(contact.schedule, "dimensionless", "time")
        for table in timed.values():
            if len(table.x) > 1:
                self.corners.update(float(t) for t in table.x)
        return found | timed

    def _probes(self, mesh: HeatMesh) -> dict[str, Array]:
        locator = Locator(mesh.points, mesh.elements)
        found = {}
        for number, probe in enumerate(self.document.probe):
            sensor = locator.sensor(np.array(probe.at) / 1e3)
            if sensor is None:
                place = ", ".join(f"{x:g}" for x in probe.at)
                raise InputError(
                    f"probe {probe.name!r} at ({place}) mm is in no part",
                    key=f"probe.{number}.at",
                    remedy="move it into a part",
                )
            found[probe.name] = sensor
            self._at_joint(probe, sensor, mesh)
        return found

    def _at_joint(self, probe: ProbeSection, sensor: Array, mesh: HeatMesh) -> None:
        """Say which side of a joint a probe reads that lies in both parts, between which the temperature jumps."""
        names, place = [part.name for part in self.document.part], np.array([probe.at]) / 1e3
        felt = int(np.argmax(sensor))
        for contact in self.document.contact:
            sides = {name: mesh.elements[mesh.parts == names.index(name)] for name in contact.between}
            if all(Locator(mesh.points, side).find(place)[2][0] < ON_JOINT for side in sides.values()):
                first, second = contact.between
                read = first if felt in sides[first] else second
                self.doubts.append(
                    f"probe {probe.name!r} lies on the joint of {first!r} and {second!r}, where the temperature jumps, "
                    f"and reads that of {read!r}: move it into the part that is meant"
                )


def start_from(grid: Grid, mesh: HeatMesh, mold: str, own: Collection[int]) -> Array:
    """Return an earlier field (points in mm) at the nodes of ``mesh``: part by part where the parts agree.

    Parts by the numbers ``own`` begin at temperatures of their own, and need not have been there.
    Raises InputError where a node lies outside the earlier mold.
    """
    temperature = grid.point_data["temperature_degC"].astype(np.float64)
    points, elements = grid.points / 1e3, grid.cells["tetra10"]
    parts = np.asarray(grid.cell_data.get("part", np.zeros(len(elements))), dtype=np.int64)
    same = len(points) == mesh.solid and np.array_equal(elements, mesh.elements)
    if same and np.allclose(points, mesh.points[: mesh.solid], atol=1e-9):
        return temperature
    together = parts.max() != mesh.parts.max()
    result = np.full(mesh.solid, np.nan)
    for part in sorted(set(range(int(mesh.parts.max()) + 1)) - set(own)):
        theirs = np.ones(len(elements), dtype=bool) if together else parts == part
        mine = np.unique(mesh.elements[mesh.parts == part])
        nodes, weights, outside = Locator(points, elements[theirs]).find(mesh.points[mine])
        if outside.max() > BEYOND:
            x, y, z = 1e3 * mesh.points[mine[int(np.argmax(outside))]]
            raise InputError(
                f"the earlier mold has nothing at ({x:.1f}, {y:.1f}, {z:.1f}) mm",
                file=mold,
                key="run.start",
                remedy="start from a run of the same mold",
            )
        result[mine] = np.einsum("pi,pi->p", weights, temperature[nodes])
    return result
