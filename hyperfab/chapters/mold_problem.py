"""From a mold document to the equations: geometry, mesh, materials and conditions, each mistake named by its key."""

from __future__ import annotations

import contextlib
import difflib
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from hyperfab.chapters.mold_geometry import geometry_of
from hyperfab.chapters.mold_start import read_field, start_from
from hyperfab.chapters.mold_tables import Tables
from hyperfab.documents.mold import EarlierField, FacesInBox, HeaterSection, MoldDocument, Place
from hyperfab.errors import InputError
from hyperfab.io.inputs import Inputs
from hyperfab.thermal.condition import Condition
from hyperfab.thermal.contact import Contact
from hyperfab.thermal.convection import Convection
from hyperfab.thermal.faces import Faces, FaceSet
from hyperfab.thermal.facet_operator import FacetOperator
from hyperfab.thermal.geometry import Body, Box, Geometry, Shape, Stl
from hyperfab.thermal.heater import Heater
from hyperfab.thermal.locate import Locator
from hyperfab.thermal.material import ThermalMaterial
from hyperfab.thermal.mesh import HeatMesh, build_mesh, split_contacts
from hyperfab.thermal.mesher import make_mesh, remesh_surface
from hyperfab.thermal.model import HeatModel
from hyperfab.thermal.plausibility import doubts
from hyperfab.thermal.prescribed import Prescribed
from hyperfab.thermal.radiation import Radiation
from hyperfab.thermal.tables import Table
from hyperfab.thermal.thermostat import Thermostat

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

#: Where ``exposed`` stands: every outer face without another condition.
EXPOSED = "exposed"

#: STL surfaces of more facets are meshed anew before booleans: sewing them takes a millisecond a facet and more.
MANY_FACETS = 3000
#: Edge lengths tried for it, and the deviation that is small enough, as shares of mesh_size.
COARSER = (1.0, 0.6, 0.4)
DEVIATION = 0.05


@dataclass
class Problem:
    """A mold ready to be heated."""

    model: HeatModel
    geometry: Geometry
    faces: Faces
    probes: dict[str, Array]
    work_surface: FacetOperator | None
    thermostats: list[Thermostat]
    corners: list[float]
    areas: dict[str, float]
    notes: list[str] = field(default_factory=list)

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
        self.tables = Tables(inputs, name)
        self.doubts: list[str] = []
        self.notes: list[str] = []
        self.areas: dict[str, float] = {}
        self.corners: set[float] = set()
        self._refuse_exposed()
        self._refuse_unknown_names()
        self.materials = {key: self._material(key) for key in document.material}
        self.functions = self._read_functions()
        self.geometry = geometry_of(document, name, inputs, stl_unit, self.doubts)
        start = document.run.start
        self.earlier = read_field(inputs, name, start.document) if isinstance(start, EarlierField) else None

    def build(self, waiting: Callable[[float], None] = lambda seconds: None) -> Problem:
        """Mesh the mold and set up its equations; ``waiting`` is called while the mesher works."""
        document = self.document
        try:
            self.geometry = self._coarsened(waiting)
            raw = make_mesh(self.geometry, document.run.mesh_size, waiting=waiting)
        except InputError as error:
            raise InputError(error.message, file=self.name, key="part", remedy=error.remedy) from None
        mesh = build_mesh(raw.points / 1e3, raw.elements, raw.parts, raw.surface, raw.surface_face)
        self.faces = Faces(mesh, self.geometry)
        self.joints = []
        split = np.zeros(len(mesh.facets.element), dtype=bool)
        for number, contact in enumerate(document.contact):
            with self._at(f"contact.{number}.between"):
                self.joints.append(self.faces.interface(*contact.between))
            split |= self.joints[-1].mask
        self._refuse_overlap([(f"contact.{i}.between", joint.mask) for i, joint in enumerate(self.joints)])
        self.mesh = split_contacts(mesh, split)
        self.faces = Faces(self.mesh, self.geometry)
        prescribed = self._prescribed()
        conditions = self._conditions()
        materials = [self.materials[part.material] for part in document.part]
        model = HeatModel(self.mesh, materials, conditions, prescribed)
        self._fill_volume_heaters(model)
        probes = self._probes()
        work = None
        if document.work_surface is not None:
            found = self._facets("work_surface.on", document.work_surface.on)
            work = self._operator(found)
        thermostats = []
        heaters = model.heaters
        for section, heater in zip(document.heater, heaters, strict=True):
            if section.control is not None:
                control = section.control
                thermostats.append(Thermostat(heater, probes[control.probe], control.set_point, control.band))
        return Problem(
            model,
            self.geometry,
            self.faces,
            probes,
            work,
            thermostats,
            sorted(self.corners),
            self.areas,
            self.notes,
        )

    def _coarsened(self, waiting: Callable[[float], None]) -> Geometry:
        """Mesh STL surfaces of many facets anew: each facet would become a face of the solid."""
        size = self.document.run.mesh_size

        def coarser(shape: Shape) -> Shape:
            if not isinstance(shape, Stl) or len(shape.triangles) <= MANY_FACETS:
                return shape
            for share in COARSER:
                found, deviation = remesh_surface(shape, share * size, waiting=waiting)
                if deviation <= DEVIATION * size:
                    break
            self.notes.append(
                f"an STL surface of {len(shape.triangles)} facets was meshed anew with {len(found.triangles)}; "
                f"they deviate by {deviation:.2g} mm at most"
            )
            return found

        def body(given: Body) -> Body:
            return Body(given.name, tuple(coarser(shape) for shape in given.shapes))

        g = self.geometry
        return Geometry(tuple(map(body, g.parts)), tuple(map(body, g.cavities)), g.patches)

    def start_field(self, problem: Problem) -> Array:
        """Return the temperatures at the start (n,) [degC]."""
        start = self.document.run.start
        if isinstance(start, EarlierField):
            assert self.earlier is not None
            return start_from(self.earlier, problem.mesh, self.name)
        return np.full(problem.model.size, start)

    # Reading, before anything is meshed

    def _refuse_unknown_names(self) -> None:
        """Names of faces are checked before the mesher runs: a mistake is told at once."""
        document = self.document
        bodies = [*document.part, *document.cavity]
        known = [b.name for b in bodies] + [s.name for b in bodies for s in b.shapes or [] if s.name]
        parts = [part.name for part in document.part]
        for key, place in document.places():
            if isinstance(place, FacesInBox):
                self._known(key, place.part, parts, "part")
            elif place != EXPOSED:
                body, _, way = place.rpartition(".")
                if not body:
                    raise InputError(
                        f"{place!r} names no face",
                        file=self.name,
                        key=key,
                        remedy=f"write NAME.WAY, as {known[0]}.z+, with WAY one of x- x+ y- y+ z- z+ all",
                    )
                self._known(key, body, known, "body", f".{way}")
        for number, heater in enumerate(document.heater):
            if heater.volume is not None:
                self._known(f"heater.{number}.volume", heater.volume, parts, "part")
        for number, contact in enumerate(document.contact):
            for part in contact.between:
                self._known(f"contact.{number}.between", part, parts, "part")

    def _known(self, key: str, name: str, known: list[str], what: str, tail: str = "") -> None:
        if name not in known:
            near = difflib.get_close_matches(name, known, 4, 0.4) or known[:8]
            offered = ", ".join(other + tail for other in near)
            raise InputError(
                f"there is no {what} {name!r}",
                file=self.name,
                key=key,
                remedy=f"the nearest names are {offered}",
            )

    def _refuse_exposed(self) -> None:
        """``exposed`` is for films and radiation, once for each."""
        seen: dict[str, str] = {}
        for key, place in self.document.places():
            kind = key.split(".")[0]
            if place != EXPOSED:
                continue
            if kind not in ("convection", "radiation"):
                raise InputError(
                    "exposed is where convection and radiation act",
                    file=self.name,
                    key=key,
                    remedy="name the faces",
                )
            if kind in seen:
                raise InputError(
                    f"exposed has a {kind} already, {seen[kind]}",
                    file=self.name,
                    key=key,
                    remedy="take one of the two out, or name its faces",
                )
            seen[kind] = key

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
        timed: dict[str, Table] = {}
        for i, held in enumerate(document.temperature):
            timed[f"temperature.{i}"] = self.tables.function(held.value, "temperature", "time")
        for i, heater in enumerate(document.heater):
            if heater.schedule is not None:
                timed[f"heater.{i}"] = self.tables.file(heater.schedule, "power", "time")
        for i, contact in enumerate(document.contact):
            if contact.schedule is not None:
                timed[f"contact.{i}"] = self.tables.file(contact.schedule, "dimensionless", "time")
        for table in timed.values():
            if len(table.x) > 1:
                self.corners.update(float(t) for t in table.x)
        return found | timed

    # Conditions on the mesh

    @contextlib.contextmanager
    def _at(self, key: str) -> Iterator[None]:
        """Give errors of the physics their place in the document."""
        try:
            yield
        except InputError as error:
            raise InputError(error.message, file=self.name, key=key, remedy=error.remedy) from None

    def _facets(self, key: str, places: list[Place]) -> FaceSet:
        whole = np.zeros(len(self.mesh.facets.element), dtype=bool)
        flip = whole.copy()
        for place in places:
            with self._at(key):
                if isinstance(place, FacesInBox):
                    box = Box(place.box.origin, place.box.size)
                    found = self.faces.inside(place.part, box)
                else:
                    found = self.faces.named(place)
            fresh = found.mask & ~whole
            flip[fresh] = found.flip[fresh]
            whole |= found.mask
        return FaceSet(key, whole, flip)

    def _operator(self, found: FaceSet) -> FacetOperator:
        """Return the operator of a set of facets, each seen from its named side."""
        near = self.mesh.facet_nodes(found.mask & ~found.flip)
        far = self.mesh.facet_nodes(found.mask & found.flip, other_side=True)
        return FacetOperator(self.mesh.points, np.concatenate([near, far]))

    def _prescribed(self) -> list[Prescribed]:
        found = []
        self.held = np.zeros(len(self.mesh.facets.element), dtype=bool)
        masks = []
        for number, section in enumerate(self.document.temperature):
            key = f"temperature.{number}.on"
            facets = self._facets(key, section.on)
            nodes = np.unique(self._operator(facets).nodes)
            found.append(
                Prescribed(
                    f"temperature {_label(section.on)}", nodes, self.functions[f"temperature.{number}"]
                )
            )
            self._use(found[-1].name, self.faces.area(facets))
            masks.append((key, facets.mask))
            self.held |= facets.mask
        self._refuse_overlap(masks)
        return found

    def _conditions(self) -> list[Condition]:
        document = self.document
        outer = self.mesh.facets.outer
        taken: dict[str, Mask] = {}
        explicit: list[tuple[str, FaceSet]] = []
        for kind in ("heater", "convection", "radiation", "insulated"):
            mine = []
            for number, section in enumerate(getattr(document, kind)):
                named = [place for place in section.on or [] if place != EXPOSED]
                if not named:
                    continue
                key = f"{kind}.{number}.on"
                facets = self._facets(key, named)
                if kind in ("convection", "radiation"):
                    facets = FaceSet(facets.name, facets.mask & outer, facets.flip)
                    if not facets.mask.any():
                        raise InputError(
                            "these faces are covered by another part",
                            file=self.name,
                            key=key,
                            remedy="name faces that see the air",
                        )
                self._refuse_held(key, facets.mask)
                taken[key] = facets.mask
                mine.append((key, facets.mask))
                explicit.append((key, facets))
            self._refuse_overlap(mine)
        self._refuse_contradiction(taken)
        exposed = outer & ~self.faces.cavity & ~self.held
        for mask in taken.values():
            exposed &= ~mask
        self.exposed = exposed
        by_key = dict(explicit)
        conditions: list[Condition] = []
        for number, heater in enumerate(document.heater):
            conditions.append(self._heater(number, heater, by_key))
        for number, convection in enumerate(document.convection):
            key = f"convection.{number}.on"
            operator = self._with_exposed(key, convection.on, by_key)
            film, ambient = self.functions[f"convection.{number}"], Table.constant(convection.ambient)
            conditions.append(Convection(self._name("convection", convection.on), operator, film, ambient))
            self._use(conditions[-1].name, operator.area)
        for number, radiation in enumerate(document.radiation):
            operator = self._with_exposed(f"radiation.{number}.on", radiation.on, by_key)
            ambient = Table.constant(radiation.ambient)
            name = self._name("radiation", radiation.on)
            conditions.append(Radiation(name, operator, radiation.emissivity, ambient))
            self._use(name, operator.area)
        for number, (contact, joint) in enumerate(zip(document.contact, self.joints, strict=True)):
            near = FacetOperator(self.mesh.points, self.mesh.facet_nodes(joint.mask))
            far = FacetOperator(self.mesh.points, self.mesh.facet_nodes(joint.mask, other_side=True))
            closed = self.functions.get(f"contact.{number}", Table.constant(1.0))
            name = self._name("contact", ["/".join(contact.between)])
            conditions.append(Contact(name, near, far, contact.h, closed))
            self._use(name, near.area)
        return conditions

    def _heater(self, number: int, section: HeaterSection, by_key: dict[str, FaceSet]) -> Heater:
        power = self.functions.get(f"heater.{number}")
        if section.volume is not None:
            name = self._name("heater", [section.volume])
            assert power is not None or section.power is not None
            return Heater(
                name, np.zeros(len(self.mesh.points)), power or Table.constant(section.power or 0.0)
            )
        operator = self._operator(by_key[f"heater.{number}.on"])
        name = self._name("heater", section.on or [])
        if section.flux is not None:
            power = Table.constant(section.flux * operator.area)
        self._use(name, operator.area)
        power = power or Table.constant(section.power or 0.0)
        return Heater(name, operator.load(1.0) / operator.area, power)

    def _fill_volume_heaters(self, model: HeatModel) -> None:
        parts = [part.name for part in self.document.part]
        for section, heater in zip(self.document.heater, model.heaters, strict=True):
            if section.volume is not None:
                heater.shape = model.medium.volume_load(parts.index(section.volume))

    def _with_exposed(self, key: str, places: list[Place], by_key: dict[str, FaceSet]) -> FacetOperator:
        mask = np.zeros(len(self.mesh.facets.element), dtype=bool)
        if key in by_key:
            mask |= by_key[key].mask
        if EXPOSED in places:
            if not self.exposed.any():
                raise InputError(
                    "no exposed face is left: all have another condition",
                    file=self.name,
                    key=key,
                    remedy="take the table out, or name its faces",
                )
            mask |= self.exposed
        return FacetOperator(self.mesh.points, self.mesh.facet_nodes(mask))

    def _probes(self) -> dict[str, Array]:
        locator = Locator(self.mesh.points, self.mesh.elements)
        found = {}
        for number, probe in enumerate(self.document.probe):
            sensor = locator.sensor(np.array(probe.at) / 1e3)
            if sensor is None:
                place = ", ".join(f"{x:g}" for x in probe.at)
                raise InputError(
                    f"probe {probe.name!r} at ({place}) mm is in no part",
                    file=self.name,
                    key=f"probe.{number}.at",
                    remedy="move it into a part",
                )
            found[probe.name] = sensor
        return found

    # What contradicts itself

    def _refuse_overlap(self, masks: list[tuple[str, Mask]]) -> None:
        for i, (key, mask) in enumerate(masks):
            for other, earlier in masks[:i]:
                if (mask & earlier).any():
                    area = float(self.faces.areas[mask & earlier].sum()) * 1e6
                    raise InputError(
                        f"acts on {area:.6g} mm^2 that {other} has already",
                        file=self.name,
                        key=key,
                        remedy="each face takes one condition of a kind",
                    )

    def _refuse_held(self, key: str, mask: Mask) -> None:
        if (mask & self.held).any():
            raise InputError(
                "these faces have their temperature held: the two contradict each other",
                file=self.name,
                key=key,
                remedy="take one of the two out",
            )

    def _refuse_contradiction(self, taken: dict[str, Mask]) -> None:
        for key, mask in taken.items():
            if not key.startswith("insulated"):
                continue
            for other, theirs in taken.items():
                if other.startswith(("convection", "radiation")) and (mask & theirs).any():
                    raise InputError(
                        f"faces of {other} are insulated: the two contradict each other",
                        file=self.name,
                        key=key,
                        remedy="take one of the two out",
                    )

    def _name(self, kind: str, places: list[Place]) -> str:
        name = base = f"{kind} {_label(places)}"
        count = 2
        while name in self.areas:
            name, count = f"{base} ({count})", count + 1
        self.areas[name] = 0.0
        return name

    def _use(self, name: str, area: float) -> None:
        self.areas[name] = area * 1e6


def _label(places: list[Place]) -> str:
    """Return how a list of places is called in tables."""
    texts = [place if isinstance(place, str) else f"{place.part} box" for place in places]
    return ", ".join(texts) if len(texts) <= 3 else f"{texts[0]} ... {texts[-1]}"
