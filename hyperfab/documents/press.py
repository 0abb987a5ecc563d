"""``press.json``: where two hot molds touch through the sandwich, and how hard."""

from __future__ import annotations

from typing import ClassVar

from pydantic import Field

from hyperfab.documents.base import Part, optional
from hyperfab.documents.uncertainty import Computed

Place = tuple[float, float, float]


class GapRange(Part):
    """A gap over the molding surface."""

    min_mm: float | None = None
    mean_mm: float | None = None
    max_mm: float | None = None
    missed_area_fraction: float = Field(default=0.0, description="share of the area whose ray misses the female")


class ThicknessRange(Part):
    """A thickness over the molding surface."""

    min_mm: float
    mean_mm: float
    max_mm: float


class RegionPart(Part):
    """A connected touching or open region of the male surface."""

    contact: bool
    area_mm2: float
    centroid_mm: Place
    gap_mean_mm: float
    pressure_mean_MPa: float
    force_N: float = Field(description="pressure times area, whatever its direction: see normal_force_N")
    normal_force_N: float | None = optional(
        "integral of the pressure over the region, across the surface; on slopes more than its share of "
        "the closing force, the document's force_N"
    )


class MoldPart(Part):
    """What was assumed of one mold."""

    temperature_degC: float
    temperature_from: str = Field(description="how the temperature is known")
    expansion_1_K: float = Field(description="mean coefficient up to that temperature")
    growth_strain: float
    mount_mm: float = Field(description="coordinate of the mounting face along the axis; it grows from there")


class StateAreas(Part):
    """Area of the molding surface by what happens there."""

    open_mm2: float
    touching_mm2: float
    bottomed_mm2: float
    interfering_mm2: float


class Histogram(Part):
    """Area of the molding surface by its nearest gap."""

    edges_mm: list[float]
    area_mm2: list[float]


class LeverPart(Part):
    """One setting that could be changed, and what the gap makes of it."""

    change: str
    unit: str
    gap_rms_mm_per_unit: float = Field(description="change of the gap over the molding surface, rms")
    closest_gap_mm_per_unit: float = Field(description="change where the molds are closest; negative: closer")
    typical_step: float = Field(description="a change as shops make or suffer it, in the unit")
    gap_rms_at_step_mm: float


class DesignPart(Part):
    """The male of constant gap that was written as STL."""

    gap_mm: float
    spread_mm: float = Field(description="greatest less least hot gap of its vertices to the female")
    gap_min_mm: float | None = optional("least hot gap of its molding surface, between its vertices too")
    gap_max_mm: float | None = optional("greatest")
    clearance_to_set_mm: float | None = optional(
        "cold, with which the female stands where it stood: --gap; absent where the frame yields"
    )
    facets: int


class WarmingPart(Part):
    """Temperature of the sandwich while the press stays closed: of the foam's middle, over the molding surface."""

    dwell_s: float
    start_degC: float = Field(description="as the sandwich was laid in")
    middle_min_degC: float = Field(description="at the end of the dwell")
    middle_mean_degC: float
    middle_max_degC: float
    middle_spread_K: float = Field(description="greatest less least")
    middle_sd_K: float = Field(description="standard deviation over the area")
    coldest_at_mm: Place
    over_time: list[tuple[float, float, float, float]] = Field(
        description="[time_s, least, mean, greatest degC] from the closing on"
    )
    target_degC: float | None = None
    reached_first_s: float | None = optional("when the first place passes the target")
    reached_last_s: float | None = optional("when all have; absent where some do not within the dwell")
    reached_fraction: float | None = optional("area that passes it within the dwell")


class SetPart(Part):
    """How much of the foam's strain stays."""

    law: str = Field(description="share, table or arrhenius")
    source: str
    rate_1_s: float | None = None
    activation_J_mol: float | None = None
    rms: float | None = optional("of the measured shares about the law identified from them")
    share_min: float = Field(description="over the area where the sandwich is pressed")
    share_mean: float
    share_max: float


class FormedPart(Part):
    """The sandwich when the press has opened, over the molding surface."""

    thickness_min_mm: float
    thickness_mean_mm: float
    thickness_max_mm: float
    thinnest_at_mm: Place
    springback_mean_mm: float = Field(description="formed thickness less that in the closed press")
    springback_max_mm: float
    set: SetPart


class WantedPart(Part):
    """The formed thickness beside the wanted one, over the molding surface."""

    wanted_min_mm: float
    wanted_max_mm: float
    worst_mm: float = Field(description="formed less wanted where they differ most")
    worst_at_mm: Place
    rms_mm: float
    tolerance_mm: float
    outside_area_fraction: float = Field(description="area that misses by more than the tolerance")


class CompensationStep(Part):
    """One male that was tried."""

    worst_mm: float
    rms_mm: float


class CompensationPart(Part):
    """The male that was changed until the product is what is wanted, and written as STL."""

    converged: bool
    iterations: int
    history: list[CompensationStep] = Field(
        description="formed less wanted: of the male as given, of that of a constant gap, then after each iteration"
    )
    wanted: WantedPart = Field(description="with the last male")
    clearance_to_set_mm: float = Field(
        description="cold and unloaded, with which the female stands where it stood: --gap"
    )
    gap_min_mm: float
    gap_max_mm: float
    facets: int
    unreached_area_fraction: float = Field(
        description="area where no gap forms what is wanted: it is thicker than the sandwich, or too little sets"
    )


class PressDocument(Computed):
    """The result of ``hf press-contact``."""

    KIND: ClassVar[str] = "press"

    converged: bool
    status: str | None = None

    gap_min_mm: float = Field(description="hot, nearest distance; negative: metal in metal")
    gap_mean_mm: float
    gap_max_mm: float
    gap_min_at_mm: Place
    gap_normal: GapRange = Field(description="along the male's normal: what a gauge reads")
    gap_axial: GapRange = Field(description="along the closing axis")
    contact_area_mm2: float
    contact_fraction: float = Field(description="of the molding area")
    molding_area_mm2: float = Field(description="male surface that faces the female, without the flat flange")
    flange_area_mm2: float
    force_N: float = Field(description="closing force: the part of all pressure along the axis")
    bearing_area_ratio: float | None = optional(
        "area of the female over that of the male where the sandwich bears, by pressure: forces count the "
        "pressure on the male's area"
    )
    force_beside_fraction: float | None = optional(
        "share of all pressure beside the touching area: borne by the nearest gap, not met by the normal"
    )
    pressure_max_MPa: float
    pressure_mean_MPa: float = Field(description="over the touching area, of the pressure that acts on it")
    stroke_mm: float = Field(description="travel from the first touch of the sandwich; negative: not yet touched")
    tilt_deg: float
    tilt_vector_deg: Place | None = optional("rotation vector of a floating or tilted female")
    centre_of_pressure_mm: Place | None = None
    energy_J: float
    regions: list[RegionPart]
    states: StateAreas

    clearance_cold_mm: float = Field(description="axial clearance at the datum, cold")
    clearance_to_set_mm: float | None = optional("clearance to set, cold and unloaded, before the press frame yields")
    clearance_drawn_mm: float | None = optional(
        "axial clearance at the datum as drawn; negative: drawn into each other"
    )
    clearance_hot_mm: float = Field(description="axial clearance at the datum of the hot molds")
    datum_mm: Place = Field(description="the datum: closest pair along the axis, on the male, cold")
    zero: str = Field(description="whether the clearance was set cold or hot")
    axis: str = Field(description="closing axis, signed from the male to the female")
    reference_temperature_degC: float
    male: MoldPart
    female: MoldPart
    sandwich_mm: float = Field(description="thickness of foam and fabric, unpressed; the mean where draped")
    sandwich_min_mm: float | None = optional("where the drape thins it most")
    sandwich_max_mm: float | None = None
    foam_shrinkage: float = Field(description="share of the foam's thickness lost to heat by the end of the dwell")
    foam_relaxation: float = Field(default=0.0, description="share of the foam's stress lost by the end of the dwell")
    foam_thinning: str | None = optional("how foam thins where it is draped: by which Poisson's ratio, or by its law")
    frame_stiffness_N_mm: float | None = optional("of the press; absent: rigid")
    final_thickness: ThicknessRange | None = optional(
        "of the sandwich when the press has opened; absent where no recovery of the foam is given"
    )
    formed: FormedPart | None = optional("of the sandwich after --dwell; absent where no set of the foam is given")
    wanted: WantedPart | None = optional("what was asked for (--wanted), and what is formed")
    compensation: CompensationPart | None = None
    warming: WarmingPart | None = optional("temperature of the sandwich (--dwell)")
    chord_error_mm: float = Field(description="how far the facets stand off the smooth molds (95 % of the area)")
    search: str = Field(description="how the gap was searched: by an exact tree, every distance proven")
    border_area_fraction: float = Field(description="area whose nearest point is an open edge of the female")
    oblique_area_fraction: float = Field(description="area where nearest and normal direction part by over 30 deg")
    force_stroke: list[tuple[float, float]] = Field(description="[stroke_mm, force_N] from the first touch on")
    histogram: Histogram
    sensitivity: list[LeverPart] = Field(description="what to change first: strongest first")
    design: DesignPart | None = None
    left_out: list[str] = Field(default_factory=list, description="what this result does not contain")
