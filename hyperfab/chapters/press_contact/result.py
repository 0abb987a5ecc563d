"""What is told of a press: all that the outputs of ``hf press-contact`` tell of, and the document."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from hyperfab.arrays import Array, Flags, Ints
from hyperfab.chapters.press_contact.formed import Formed, Wanted, place
from hyperfab.chapters.press_contact.formed import part_of as formed_part
from hyperfab.chapters.press_contact.model import Model
from hyperfab.chapters.press_contact.warmth import Warmed, left_out, part_of
from hyperfab.documents.foam import MaterialLaw
from hyperfab.documents.press import (
    CompensationPart,
    DesignPart,
    GapRange,
    Histogram,
    LeverPart,
    MoldPart,
    PressDocument,
    RegionPart,
    StateAreas,
    ThicknessRange,
    WantedPart,
)
from hyperfab.pressing.closing import Closed
from hyperfab.pressing.mold import Mold, PressFrame, guide_line
from hyperfab.pressing.regions import regions
from hyperfab.pressing.sandwich import State
from hyperfab.pressing.sensitivity import Tooling, levers

#: Molds within this [K] of the drawing's temperature are cold.
_COLD = 1.0
#: Of a face's area that is cut into parts.
_ROUNDING = 1e-12
_SIGNS = {1: "+", -1: "-"}


@dataclass(frozen=True)
class PressResult:
    """All that the outputs tell: the model, the closed press, what the dwell does and the design."""

    model: Model
    closed: Closed
    warmed: Warmed | None = None
    design: DesignPart | None = None
    formed: Formed | None = None
    wanted: Wanted | None = None
    compensation: CompensationPart | None = None

    @cached_property
    def curve(self) -> Array:
        """From the first touch to the answer (strokes, 5): stroke [mm], closing force [N], touching area [mm2],
        smallest gap [mm] and energy [J]; the female keeps the tilt it has at the answer."""
        closed, last = self.closed, max(self.closed.stroke, 0.0)
        rows = []
        for stroke in np.linspace(0.0, last, self.model.case.strokes if last > 0.0 else 1):
            pose = replace(closed.pose, opening=closed.first_touch - stroke)
            here = closed.press.at(pose)
            area = closed.press.touching(closed.press.touch(pose, here.gap)[1]).area.sum()
            rows.append((stroke, here.closing_force, area, here.gap.min(), 1e-3 * here.energy))
        return np.array(rows)

    @property
    def beside(self) -> WantedPart | None:
        """By how much what is formed misses what is wanted."""
        if self.formed is None or self.wanted is None:
            return None
        return self.wanted.beside(self.formed, self.closed, self.frame)

    @property
    def guided(self) -> bool:
        """Whether the molds stay parallel."""
        return not self.closed.case.floating and self.closed.pose.angle == 0.0

    @property
    def frame(self) -> PressFrame:
        """How the molds close."""
        return self.model.files.frame

    @property
    def reference(self) -> float:
        """Temperature [degC] at which the drawing holds."""
        return self.model.files.document.expansion.reference

    @property
    def final_thickness(self) -> Array | None:
        """Thickness (n,) [mm] of the sandwich when the press has opened: foam springs back by its recovery."""
        if self.model.foam.recovery is None:
            return None
        sandwich, gap = self.closed.press.sandwich, self.closed.contact.gap
        foam = np.broadcast_to(np.asarray(sandwich.foam), gap.shape)
        pressed, _ = sandwich.pressed(gap)
        return np.asarray(sandwich.fabric + pressed + self.model.foam.recovery * (foam - pressed))


def document_of(told: PressResult) -> PressDocument:
    """Return the document, without its force over stroke and provenance."""
    closed, frame = told.closed, told.frame
    front, contact = closed.front, closed.contact
    molding = ~front.flange
    area = front.molding_areas
    molded = area > 0.0
    lowest = int(np.argmin(contact.gap))
    touching = float(closed.touching.sum())
    thickness = np.broadcast_to(np.asarray(closed.press.sandwich.thickness), area.shape)
    states = closed.press.sandwich.state(contact.gap)
    found = regions(front, closed.touch, contact, closed.press.sandwich)
    shift = closed.cold - front.vertices
    final = told.final_thickness
    on_touching = sum(region.load for region in found if region.contact)
    male_part, female_part = (
        _mold_part(mold, told, index) for index, mold in enumerate((closed.case.male, closed.case.female))
    )
    return PressDocument(
        converged=True,
        gap_min_mm=float(contact.gap[lowest]),
        gap_mean_mm=float(np.average(contact.gap, weights=area)),
        gap_max_mm=float(contact.gap[molded].max()),
        gap_min_at_mm=place(frame.outward(closed.cold[lowest])),
        gap_normal=_gap_range(closed.normal, area),
        gap_axial=_gap_range(closed.axial, area),
        contact_area_mm2=touching,
        contact_fraction=touching_fraction(closed.touching[molding], front.areas[molding]),
        molding_area_mm2=float(front.areas[molding].sum()),
        flange_area_mm2=float(front.areas[~molding].sum()),
        force_N=contact.closing_force,
        bearing_area_ratio=_bearing_area_ratio(closed),
        force_beside_fraction=max(1.0 - on_touching / contact.load, 0.0) if contact.load > 0.0 else None,
        pressure_max_MPa=float(contact.pressure.max()),
        pressure_mean_MPa=on_touching / touching if touching > 0.0 else 0.0,
        stroke_mm=closed.stroke,
        tilt_deg=float(np.degrees(closed.pose.angle)),
        tilt_vector_deg=None if told.guided else place(frame.outward(np.degrees([*closed.pose.tilt, 0.0]))),
        centre_of_pressure_mm=_centre_of_pressure(told),
        energy_J=1e-3 * contact.energy,
        regions=[
            RegionPart(
                contact=region.contact,
                area_mm2=region.area,
                # Regions are found on the hot male; their place is told on the drawing.
                centroid_mm=place(frame.outward(region.centroid + shift[_nearest(front.vertices, region.centroid)])),
                gap_mean_mm=region.gap,
                pressure_mean_MPa=region.pressure,
                force_N=region.load,
                normal_force_N=region.load,
            )
            for region in found
        ],
        states=_state_areas(states, area, closed, molding),
        clearance_cold_mm=closed.clearance_cold,
        clearance_to_set_mm=_to_set(closed),
        clearance_drawn_mm=closed.datum.gap,
        clearance_hot_mm=closed.clearance_hot,
        datum_mm=place(frame.outward(closed.datum.at)),
        zero="hot" if closed.case.zero_hot else "cold",
        axis=f"{frame.axis}{_SIGNS[frame.sign]}",
        reference_temperature_degC=told.reference,
        male=male_part,
        female=female_part,
        sandwich_mm=float(np.average(thickness, weights=area)),
        sandwich_min_mm=float(thickness[molded].min()) if told.model.foam.uneven else None,
        sandwich_max_mm=float(thickness[molded].max()) if told.model.foam.uneven else None,
        foam_shrinkage=told.model.foam.lost,
        foam_relaxation=told.model.foam.relaxed,
        foam_thinning=told.model.files.thinning or None,
        frame_stiffness_N_mm=closed.case.frame,
        final_thickness=None if final is None else _range(final, area),
        formed=None if told.formed is None else formed_part(told.formed, closed, frame.outward(closed.cold)),
        wanted=told.beside,
        compensation=told.compensation,
        warming=None if told.warmed is None else part_of(told.warmed, closed, frame.outward(closed.cold)),
        chord_error_mm=told.model.files.chord_error,
        search="exact tree: every distance is proven the least",
        border_area_fraction=float(area[closed.at_border].sum() / area.sum()),
        oblique_area_fraction=float(area[closed.oblique].sum() / area.sum()),
        force_stroke=[],
        histogram=_histogram(contact.gap, area),
        sensitivity=_sensitivity(told, area),
        design=told.design,
        left_out=_left_out(told),
    )


def _centre_of_pressure(told: PressResult) -> tuple[float, float, float] | None:
    """Where the closing force acts: on the mean height of what touches."""
    contact = told.closed.contact
    if contact.closing_force <= 0.0:
        return None
    height = float(np.average(told.closed.front.vertices[:, 2], weights=contact.pressure))
    x, y, z = contact.force
    across = ((height * x - contact.moment[1]) / z, (contact.moment[0] + height * y) / z)
    return place(told.frame.outward(np.array([*across, height])))


def _to_set(closed: Closed) -> float | None:
    """The clearance to set, cold and unloaded, so that the press stands here when its frame has yielded."""
    if closed.case.frame is None:
        return None
    return closed.clearance_cold - closed.contact.closing_force / closed.case.frame


def _histogram(gap: Array, area: Array) -> Histogram:
    """Area by gap over the molding surface, in steps that are round numbers."""
    low, high = float(gap[area > 0.0].min()), float(gap[area > 0.0].max())
    step = 10.0 ** np.floor(np.log10(max(high - low, 1e-6) / 10.0))
    step = next(step * k for k in (1.0, 2.0, 5.0, 10.0) if (high - low) / (step * k) <= 40.0)
    first, last = int(np.floor(low / step)), int(np.floor(high / step)) + 1
    edges = step * np.arange(first, last + 1)
    share, _ = np.histogram(gap, edges, weights=area)
    return Histogram(edges_mm=[round(float(edge), 12) for edge in edges], area_mm2=[float(a) for a in share])


def _sensitivity(told: PressResult, area: Array) -> list[LeverPart]:
    closed = told.closed
    line = guide_line(closed.case.male)
    rates = [
        float(expansion.strain(mold.temperature + 0.5) - expansion.strain(mold.temperature - 0.5))
        for expansion, mold in zip(told.model.files.expansions, told.model.grown, strict=True)
    ]
    tooling = Tooling(
        points=closed.front.vertices,
        gap=closed.contact.gap,
        direction=closed.contact.direction,
        area=area,
        closest=int(np.argmin(closed.contact.gap)),
        pivot=np.array([line[0], line[1], closed.female.mount]),
        male_fixed=np.array([line[0], line[1], closed.case.male.mount]),
        female_fixed=np.array([line[0], line[1], closed.female.mount]),
        male_rate=rates[0],
        female_rate=rates[1],
        male_strain=told.model.grown[0].strain,
        female_strain=told.model.grown[1].strain,
    )
    return [
        LeverPart(
            change=lever.name,
            unit=lever.unit,
            gap_rms_mm_per_unit=lever.rms,
            closest_gap_mm_per_unit=lever.at_closest,
            typical_step=lever.step,
            gap_rms_at_step_mm=lever.step_rms,
        )
        for lever in levers(tooling)
    ]


def touching_fraction(touching: Array, areas: Array) -> float:
    """Return which share of faces (m,) of ``areas`` [mm^2] touches; 1 where each touches whole but for rounding, so
    that a bound of 100 % holds.

    >>> touching_fraction(np.array([0.1 + 0.2, 0.0]), np.array([0.3, 0.3]))
    0.5
    """
    left = areas - touching
    return float(1.0 - left[left > _ROUNDING * areas].sum() / areas.sum())


def _gap_range(gap: Array, area: Array) -> GapRange:
    met = np.isfinite(gap) & (area > 0.0)
    if not met.any():
        return GapRange(missed_area_fraction=1.0)
    return GapRange(**vars(_range(gap[met], area[met])), missed_area_fraction=float(area[~met].sum() / area.sum()))


def _range(values: Array, area: Array) -> ThicknessRange:
    there = area > 0.0
    return ThicknessRange(
        min_mm=float(values[there].min()),
        mean_mm=float(np.average(values, weights=area)),
        max_mm=float(values[there].max()),
    )


def _bearing_area_ratio(closed: Closed) -> float | None:
    """Area of the places nearest on the female over that of the male's facets, weighted by the pressure there."""
    front, contact = closed.front, closed.contact
    load = (front.areas * contact.pressure[front.faces].mean(axis=1)).sum()
    if load <= 0.0:
        return None
    feet = front.vertices - contact.gap[:, None] * contact.direction
    a, b, c = (feet[front.faces[:, k]] for k in range(3))
    across = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)
    return float((across * contact.pressure[front.faces].mean(axis=1)).sum() / load)


def _nearest(vertices: Array, point: Array) -> int:
    return int(np.argmin(((vertices - point) ** 2).sum(axis=1)))


def _state_areas(states: Ints, area: Array, closed: Closed, molding: Flags) -> StateAreas:
    touching = float(closed.touching[molding].sum())
    bottomed = float(area[states == State.BOTTOMED].sum())
    interfering = float(area[states == State.INTERFERING].sum())
    return StateAreas(
        open_mm2=max(float(area.sum()) - touching, 0.0),
        touching_mm2=max(touching - bottomed - interfering, 0.0),
        bottomed_mm2=bottomed,
        interfering_mm2=interfering,
    )


def _mold_part(mold: Mold, told: PressResult, index: int) -> MoldPart:
    expansion, grown = told.model.files.expansions[index], told.model.grown[index]
    return MoldPart(
        temperature_degC=grown.temperature,
        temperature_from=grown.known_from,
        expansion_1_K=float(np.interp(grown.temperature, expansion.temperatures, expansion.coefficient)),
        growth_strain=grown.strain,
        mount_mm=told.frame.sign * mold.mount,
    )


def _left_out(told: PressResult) -> list[str]:
    out = ["tilt: the molds are guided and stay parallel (--float, --tilt)"] if told.guided else []
    if any(grown.even and "mean" in grown.known_from for grown in told.model.grown):
        out.append("uneven temperature: each mold grows with one mean temperature")
    document, fabrics = told.model.files.document, told.model.files.fabrics
    if fabrics.thickness > 0.0 and fabrics.law is None:
        out.append("compression of the fabric: it is rigid across (fabric.compression)")
    hot = max(abs(grown.temperature - told.reference) for grown in told.model.grown)
    if hot > _COLD and all(not isinstance(law, MaterialLaw) and law.temperature is None for law in document.laws):
        out.append("stiffness of the foam against temperature: its law is taken as it stands")
    if told.warmed is not None:
        out += left_out(document)
    elif hot > _COLD:
        out.append("temperature in the sandwich (--dwell)")
    return out
