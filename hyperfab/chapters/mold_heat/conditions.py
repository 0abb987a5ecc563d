"""The conditions of a mold document, placed on the facets of its mesh; what contradicts itself is refused by key."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from hyperfab.arrays import Flags
from hyperfab.chapters.mold_heat.tables import EXPOSED
from hyperfab.documents.mold import FacesInBox, HeaterSection, MoldDocument, Place
from hyperfab.errors import InputError, placed
from hyperfab.thermal.condition import Condition, Contact, Convection, Heater, Prescribed, Radiation, Switched
from hyperfab.thermal.faces import Faces, FaceSet
from hyperfab.thermal.facet_operator import FacetOperator
from hyperfab.thermal.geometry import Box
from hyperfab.thermal.model import HeatModel
from hyperfab.thermal.tables import Table


@dataclass(eq=False)
class Placing:
    """Places the conditions of ``document`` on ``faces``.

    ``joints`` are the interfaces of its contacts, ``functions`` its tables by key. ``areas`` collects the area each
    condition acts on [mm^2], ``notes`` what is to be told of where conditions act.
    """

    document: MoldDocument
    faces: Faces
    joints: Sequence[FaceSet]
    functions: Mapping[str, Table]

    def __post_init__(self) -> None:
        self.mesh = self.faces.mesh
        self.areas: dict[str, float] = {}
        self.notes: set[str] = set()
        #: Facets that pieces of a production cover, and the films on them, which act while they are bare.
        self.covered = np.zeros(len(self.mesh.facets.element), dtype=bool)
        self.bare: list[Switched] = []
        self._operators: dict[bytes, FacetOperator] = {}
        self.refuse_overlap([(f"contact.{i}.between", joint.mask) for i, joint in enumerate(self.joints)])

    def prescribed(self) -> list[Prescribed]:
        """Return the held nodes of every [[temperature]]."""
        found = []
        self.held = np.zeros(len(self.mesh.facets.element), dtype=bool)
        masks = []
        for number, section in enumerate(self.document.temperature):
            key = f"temperature.{number}.on"
            facets = self.facets_of(key, section.on)
            nodes = self.operator(facets).all_nodes
            found.append(
                Prescribed(f"temperature {_label(section.on)}", nodes, self.functions[f"temperature.{number}"])
            )
            self._use(found[-1].name, self.faces.area(facets))
            masks.append((key, facets.mask))
            self.held |= facets.mask
        self.refuse_overlap(masks)
        return found

    def conditions(self) -> list[Condition]:
        """Return what heats and cools: heaters, films, radiation, joints; after ``prescribed``."""
        document = self.document
        outer = self.mesh.facets.outer
        taken: dict[str, Flags] = {}
        explicit: list[tuple[str, FaceSet]] = []
        for kind in ("heater", "convection", "radiation", "insulated"):
            mine = []
            for number, section in enumerate(getattr(document, kind)):
                named = [place for place in section.on or [] if place != EXPOSED]
                if not named:
                    continue
                key = f"{kind}.{number}.on"
                facets = self.facets_of(key, named)
                if kind in ("convection", "radiation"):
                    facets = FaceSet(facets.name, facets.mask & outer, facets.flip)
                    if not facets.mask.any():
                        raise InputError(
                            "these faces are covered by another part", key=key, remedy="name faces that see the air"
                        )
                self._refuse_held(key, facets.mask)
                taken[key] = facets.mask
                mine.append((key, facets.mask))
                explicit.append((key, facets))
            self.refuse_overlap(mine)
        self._refuse_contradiction(taken)
        exposed = outer & ~self.faces.cavity & ~self.held
        for mask in taken.values():
            exposed &= ~mask
        self.exposed = exposed & ~self.faces.closed_in
        self._shut = exposed & self.faces.closed_in
        by_key = dict(explicit)
        heaters = enumerate(document.heater)
        conditions: list[Condition] = [self._heater(number, heater, by_key) for number, heater in heaters]
        for number, convection in enumerate(document.convection):
            key = f"convection.{number}.on"
            film, ambient = self.functions[f"convection.{number}"], self.functions[f"{key[:-3]}.ambient"]
            mask = self._with_exposed(key, convection.on, by_key)
            made: Callable[..., Condition] = partial(Convection, film=film, ambient=ambient)
            conditions += self._films(f"convection {_label(convection.on)}", mask, made)
        for number, radiation in enumerate(document.radiation):
            surroundings = self.functions[f"radiation.{number}.ambient"]
            mask = self._with_exposed(f"radiation.{number}.on", radiation.on, by_key)
            made = partial(Radiation, emissivity=radiation.emissivity, ambient=surroundings)
            conditions += self._films(f"radiation {_label(radiation.on)}", mask, made)
        for number, (contact, joint) in enumerate(zip(document.contact, self.joints, strict=True)):
            near = FacetOperator(self.mesh.points, self.mesh.facet_nodes(joint.mask))
            far = FacetOperator(self.mesh.points, self.mesh.facet_nodes(joint.mask, other_side=True))
            closed = self.functions.get(f"contact.{number}", Table.constant(1.0))
            name = self._name("contact", ["/".join(contact.between)])
            conditions.append(Contact(name, near, far, contact.h, closed))
            self._use(name, near.area)
        return conditions

    def _films(self, base: str, mask: Flags, made: Callable[[str, FacetOperator], Condition]) -> list[Condition]:
        """Return a condition on faces that see the air; where pieces lie it acts between them alone."""
        found: list[Condition] = []
        for name, mine in ((base, mask & ~self.covered), (f"{base}, between pieces", mask & self.covered)):
            if not mine.any():
                continue
            operator = self._operators.get(mine.tobytes())  # one for films and radiation of the same faces
            if operator is None:
                operator = FacetOperator(self.mesh.points, self.mesh.facet_nodes(mine))
                self._operators[mine.tobytes()] = operator
            condition = made(self._named(name), operator)
            if mine[self.covered].any():
                condition = Switched(condition, on=False)
                self.bare.append(condition)
            found.append(condition)
            self._use(condition.name, operator.area)
        return found

    def fill_volume_heaters(self, model: HeatModel) -> None:
        """Spread the heaters in volumes, which needs the assembled medium."""
        parts = [part.name for part in self.document.part]
        for section, heater in zip(self.document.heater, model.heaters, strict=True):
            if section.volume is not None:
                heater.shape = model.medium.volume_load(parts.index(section.volume))

    def facets_of(self, key: str, places: list[Place]) -> FaceSet:
        """Return the facets of a list of places (key ``key``)."""
        whole = np.zeros(len(self.mesh.facets.element), dtype=bool)
        flip = whole.copy()
        for place in places:
            with placed(key=key):
                if isinstance(place, FacesInBox):
                    box = Box(place.box.origin, place.box.size)
                    found = self.faces.inside(place.part, box)
                else:
                    found = self.faces.named(place)
            fresh = found.mask & ~whole
            flip[fresh] = found.flip[fresh]
            whole |= found.mask
        return FaceSet(key, whole, flip)

    def operator(self, found: FaceSet) -> FacetOperator:
        """Return the operator of a set of facets, each seen from its named side."""
        near = self.mesh.facet_nodes(found.mask & ~found.flip)
        far = self.mesh.facet_nodes(found.mask & found.flip, other_side=True)
        return FacetOperator(self.mesh.points, np.concatenate([near, far]))

    def _heater(self, number: int, section: HeaterSection, by_key: dict[str, FaceSet]) -> Heater:
        power = self.functions.get(f"heater.{number}")
        if section.volume is not None:
            name = self._name("heater", [section.volume])
            assert power is not None or section.power is not None
            return Heater(name, np.zeros(len(self.mesh.points)), power or Table.constant(section.power or 0.0))
        operator = self.operator(by_key[f"heater.{number}.on"])
        name = self._name("heater", section.on or [])
        if section.flux is not None:
            power = Table.constant(section.flux * operator.area)
        self._use(name, operator.area)
        power = power or Table.constant(section.power or 0.0)
        return Heater(name, operator.mean_weights, power)

    def _with_exposed(self, key: str, places: list[Place], by_key: dict[str, FaceSet]) -> Flags:
        mask = np.zeros(len(self.mesh.facets.element), dtype=bool)
        if key in by_key:
            mask |= by_key[key].mask
        if EXPOSED in places:
            if not self.exposed.any():
                raise InputError(
                    "no exposed face is left: all have another condition",
                    key=key,
                    remedy="take the table out, or name its faces",
                )
            mask |= self.exposed
            if self._shut.any():
                area = 1e4 * float(self.faces.areas[self._shut].sum())
                self.notes.add(
                    f"{area:.3g} cm^2 of walls that are closed in see no air: not exposed, they count as insulated"
                )
        return mask

    def refuse_overlap(self, masks: list[tuple[str, Flags]]) -> None:
        """Refuse two conditions of a kind on one facet."""
        for i, (key, mask) in enumerate(masks):
            for other, earlier in masks[:i]:
                if (mask & earlier).any():
                    area = float(self.faces.areas[mask & earlier].sum()) * 1e6
                    raise InputError(
                        f"acts on {area:.6g} mm^2 that {other} has already",
                        key=key,
                        remedy="each face takes one condition of a kind",
                    )

    def _refuse_held(self, key: str, mask: Flags) -> None:
        if (mask & self.held).any():
            raise InputError(
                "these faces have their temperature held: the two contradict each other",
                key=key,
                remedy="take one of the two out",
            )

    def _refuse_contradiction(self, taken: dict[str, Flags]) -> None:
        for key, mask in taken.items():
            if not key.startswith("insulated"):
                continue
            for other, theirs in taken.items():
                if other.startswith(("convection", "radiation")) and (mask & theirs).any():
                    raise InputError(
                        f"faces of {other} are insulated: the two contradict each other",
                        key=key,
                        remedy="take one of the two out",
                    )

    def _name(self, kind: str, places: list[Place]) -> str:
        return self._named(f"{kind} {_label(places)}")

    def _named(self, base: str) -> str:
        name, count = base, 2
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
