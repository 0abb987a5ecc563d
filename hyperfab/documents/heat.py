"""``heat.json``: what a heated mold does: warm-up time, evenness of the work surface, probes, account of heat."""

from __future__ import annotations

from typing import ClassVar

from pydantic import Field

from hyperfab.documents.base import Part, optional
from hyperfab.documents.uncertainty import Computed


class RunPart(Part):
    """What was run of the mold document, defaults included; what the command was asked for stands beside."""

    start_degC: float | None = optional("absent where the start is the end of an earlier run")
    target_degC: float | None = None
    until_s: float | None = None
    mesh_size_mm: float | None = None
    steady: bool | None = None
    tolerance_K: float | None = optional("of a step in time")


class ProbeResult(Part):
    """One probe; its curve is a column of the CSV."""

    final_degC: float
    max_degC: float


class Evenness(Part):
    """Temperatures of the work surface."""

    mean_degC: float
    min_degC: float
    max_degC: float
    spread_K: float = Field(description="greatest less least")


class WorkSurface(Evenness):
    """The work surface at the end of the run, and when the target was reached."""

    area_mm2: float
    at_end: Evenness
    at_warmup: Evenness | None = None


class Energy(Part):
    """The account of heat from the start to the end."""

    supplied_J: float | None = optional(
        "given by the heaters, and by held temperatures in steps in which they give heat; absent in a steady state"
    )
    lost_J: float | None = optional("left through all other conditions, and through held temperatures that took it")
    stored_J: float = Field(description="gained by the parts")
    imbalance_relative: float = Field(
        description="largest |supplied - lost - stored| after any step, over all heat turned over, "
        "at least what changes the parts by 0.1 mK"
    )
    by_condition_J: dict[str, float] = Field(
        default_factory=dict, description="heat that entered through each condition; lost heat is negative"
    )
    at_warmup: dict[str, float] | None = optional("supplied_J, lost_J, stored_J when the target was reached")


class Extreme(Part):
    """The hottest or coldest node of all parts at the end."""

    temperature_degC: float
    at_mm: tuple[float, float, float]


class FaceUse(Part):
    """What a condition was applied to."""

    area_mm2: float | None = None
    power_W: float | None = None


class Design(Part):
    """Heater powers that were chosen for a wish, and what they reach."""

    power_W: dict[str, float] = Field(default_factory=dict, description="power of each heater, at its greatest")
    warmup_wanted_s: float | None = None
    power_factor: float | None = optional("on all powers, for the wanted warm-up time")
    runs: int | None = optional("warm-ups that were computed to find the factor")
    steady_spread_before_K: float | None = None
    steady_spread_K: float | None = optional("spread of the work surface when shared")
    steady_mean_degC: float | None = None


class Variation(Part):
    """One variation of the mold: factors on what its document says, and what it then does."""

    factors: dict[str, float]
    warmup_time_s: float | None = optional("absent where the target is not reached in the time")
    work_surface_mean_degC: float | None = optional("at the warm-up, else at the end")
    work_surface_spread_K: float | None = None
    probes_final_degC: dict[str, float] = Field(default_factory=dict)
    probes_max_degC: dict[str, float] = Field(default_factory=dict)


class Variations(Part):
    """Variations that were run on the mold reduced to a few unknowns."""

    duration_s: float = Field(description="how long each is followed")
    unknowns: int = Field(description="vectors of the basis")
    difference_max_K: float = Field(
        description="greatest difference from the full run, over its steps, probes and work surface"
    )
    runs: list[Variation]


class PieceResult(Part):
    """One piece of a production, from the moment it is laid in to that of the next."""

    number: int
    time_s: float = Field(description="when it is laid in")
    surface_degC: float = Field(description="mean of the faces it lies on as it is laid in")
    lowest_degC: float = Field(description="least mean of these faces until the next")
    dip_K: float = Field(description="the first less the second")
    dip_max_K: float = Field(description="greatest fall at any node of these faces")
    heat_from_mold_J: float
    heat_from_other_J: float | None = optional("from what its other face meets")
    taken_out_degC: float = Field(description="mean of the piece, by its heat capacity, as it is taken out")
    supplied_J: float = Field(description="by the heaters, and held temperatures that give heat, until the next")
    lost_J: float = Field(description="by the mold through all conditions until the next, the piece apart")


class Production(Part):
    """Pieces laid in the mold and taken out, one after the other."""

    pieces: int
    period_s: float
    in_s: float
    area_mm2: float = Field(description="of the faces a piece lies on")
    piece_capacity_J_K: float
    came_round: bool = Field(
        description="whether what the mold would still change by, its changes from piece to piece summed on, is below "
        "run.tolerance"
    )
    drift_K: float | None = optional("greatest change of any node from one laying in to the next, at the end")
    power_W: float = Field(description="mean of what was supplied through the last period")
    power_to_hold_W: float = Field(
        description="what the mold lost and the piece took in the last period, over the period: with it the "
        "mold's heat stays what it is"
    )
    last: PieceResult


class ReducedRun(Part):
    """How much of a long run was followed on the mold reduced to a few unknowns, checked against the full one."""

    unknowns: int = Field(description="vectors of the basis")
    begun_s: float = Field(description="when it was first gone over to; before, the mold is followed in full")
    stretches: int = Field(description="from one switching or corner of a schedule to the next, on the reduced mold")
    checks: int = Field(description="stretches that were gone through in full too")
    error_bound_K: float = Field(
        description="what probes and work surface may be off by against the full mold: differences at the ends of "
        "checked stretches and what their shifted switching makes, summed over all, and the greatest on the way"
    )
    taken_back: int = Field(description="stretches that a check did not accept, gone through in full instead")


class HeatDocument(Computed):
    """The result of ``hf mold-heat``."""

    KIND: ClassVar[str] = "heat"

    converged: bool
    status: str | None = optional("why not, where converged is false; or a remark")
    steady: bool = False
    steps: int
    rejected_steps: int | None = None
    unknowns: int
    elements: int | None = None
    solver: str | None = None
    linear_iterations: int | None = None
    residual_max_K: float | None = optional("largest residual of a stage, as a temperature")
    end_time_s: float | None = None
    warmup_time_s: float | None = None
    target_degC: float | None = None
    target_reached: bool | None = None
    probes: dict[str, ProbeResult] = Field(default_factory=dict)
    work_surface: WorkSurface | None = None
    energy: Energy
    efficiency: float | None = optional(
        "heat stored in all parts over heat supplied, from the start to the warm-up where it "
        "was reached, else to the end; what is missing to 1 was lost on the way"
    )
    power_supplied_W: float | None = optional(
        "power at the end of the heaters; in a steady state also of held temperatures that give heat"
    )
    power_lost_W: dict[str, float] = Field(
        default_factory=dict, description="heat leaving through each condition at the end"
    )
    conditions: dict[str, FaceUse] = Field(default_factory=dict)
    mass_kg: float
    mass_by_part_kg: dict[str, float] = Field(default_factory=dict)
    heat_capacity_J_K: float | None = optional("heat to warm all parts by one kelvin")
    design: Design | None = None
    variations: Variations | None = None
    production: Production | None = None
    reduced: ReducedRun | None = optional("where a long run was followed on a reduced mold")
    hottest: Extreme | None = None
    coldest: Extreme | None = None
    flux_max_W_m2: float | None = None
    notes: list[str] = Field(default_factory=list, description="what was doubted, repaired or meshed anew")
    setup: RunPart | None = None
    switches_s: list[float] | None = None
