"""``contact.json``: a sphere pushed into a clamped sheet, and the verdict on the constants."""

from __future__ import annotations

from typing import ClassVar

from pydantic import Field

from hyperfab.documents.base import Part, optional
from hyperfab.documents.uncertainty import Computed


class SetupPart(Part):
    """What was pressed, in canonical units."""

    model: str
    fabric: str = Field(description="how the sheet's law was made of the material document")
    shape: str = Field(description="disc, square, or the file that the outline was read from")
    size_mm: float = Field(description="diameter or side; the longer side of the box around an outline")
    area_mm2: float | None = optional("of the undeformed sheet, where it was read from a file")
    thickness_mm: float
    sphere_radius_mm: float | None = optional("absent with a punch")
    punch: str | None = optional("file of the surface pressed in place of a sphere")
    punch_facets: int | None = None
    depth_mm: float
    prestretch: float
    rim_slip_mm2_N: float | None = optional("slip of the rim in mm for each N/mm of tension; absent where it is held")
    frame_stiffness_N_mm: float | None = optional(
        "of the machine that reads the depth: the punch is less deep by the force over this; absent where it is rigid"
    )
    temperature_degC: float | None = optional("of the fabric, where known")
    constants_degC: float | None = optional("temperature of the constants, where none are known at that of the fabric")
    effects: list[str] | None = optional("effects of the material document that are obeyed")
    friction: str
    mesh_size_mm: float
    elements: str


class StabilityPart(Part):
    """Drucker stability of the constants over the stretches that occur in the sheet."""

    stable: bool
    first_unstable_depth_mm: float | None = None
    at_mm: tuple[float, float] | None = optional("place on the undeformed sheet (x, y)")
    stretches: tuple[float, float] | None = optional("principal stretches there")
    bands_depth_mm: float | None = optional(
        "where the path ends because the stretch gathers in bands (ellipticity is lost)"
    )
    bands_at_mm: tuple[float, float] | None = None
    bands_stretches: tuple[float, float] | None = None


class OtherPart(Part):
    """The result with the constants of ``--against``."""

    model: str
    converged: bool
    status: str | None = None
    depth_reached_mm: float | None = None
    force_N: float | None = None
    force_depth: list[tuple[float, float]] = Field(default_factory=list)
    stretch_max: float | None = None
    stress_max_MPa: float | None = None
    stability: StabilityPart


class BalancePart(Part):
    """Laws of mechanics that the result must obey."""

    work_J: float = Field(description="of the punch: integral of the force over the path")
    stored_J: float = Field(description="energy above that of the mounted sheet")
    dissipated_J: float = Field(default=0.0, description="by friction")
    imbalance_relative: float = Field(description="(work - stored - dissipated) / stored")
    reaction_N: float = Field(description="of the rim, along z")
    force_imbalance_relative: float = Field(description="(reaction - contact force) / force")


class ContactDocument(Computed):
    """The result of ``hf fabric-contact``.

    Where the full depth was not reached, force, radius, stretch and stress are those at ``depth_reached_mm``.
    """

    KIND: ClassVar[str] = "contact"

    converged: bool
    status: str | None = optional("what stood in the way")
    depth_reached_mm: float | None = optional(
        "where the full depth was not reached, or constants are unstable on the way: what was computed"
    )
    turning_point_mm: float | None = optional("depth beyond which there is no equilibrium")
    newton_iterations: int = Field(description="on the fitted mesh of the last depth")
    newton_iterations_total: int = Field(description="over all depths and meshes")
    unknowns: int
    linear_solver: str | None = optional("what solved Newton's equations")
    force_N: float | None = None
    force_error_relative: float | None = optional("estimated from two meshes")
    cut_max_mm: float | None = optional("how deep elements cut into sharp edges of a punch, between their nodes")
    force_extrapolated_N: float | None = optional(
        "for load steps of length zero, where the force hangs on them (stick)"
    )
    force_depth: list[tuple[float, float]] = Field(description="[depth_mm, force_N], as the machine reads it")
    punch_depth_mm: float | None = optional("of the punch in the sheet at last, where the machine yields")
    contact_radius_mm: float | None = optional("deformed; the mean around the sphere")
    contact_radius_undeformed_mm: float | None = None
    stretch_max: float | None = None
    stress_max_MPa: float | None = optional("largest Cauchy principal stress")
    stress_nominal_max_MPa: float | None = optional("largest nominal principal stress: force per undeformed section")
    pressure_max_MPa: float | None = optional("largest contact pressure of the punch")
    energy_J: float | None = optional("strain energy of the sheet")
    wrinkled_area_fraction: float | None = optional("of the undeformed area; slack included")
    stability: StabilityPart
    balance: BalancePart | None = None
    setup: SetupPart
    compared_at_depth_mm: float | None = optional("depth of the comparison")
    stress_difference_percent: float | None = optional(
        "100 max|sB - sA| / max|sA|, Cauchy principal stresses at the same points"
    )
    force_ratio: float | None = optional("F_A / F_B")
    against: OtherPart | None = None
    left_out: list[str] = Field(default_factory=list, description="what this result does not contain")
