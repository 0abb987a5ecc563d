"""``drape.json``: the sheet at equilibrium on the mold: forces, stresses, thickness, slack, penetration."""

from __future__ import annotations

from typing import ClassVar

from pydantic import BaseModel, ConfigDict, Field

from hyperfab.documents.base import Document


class Part(BaseModel):
    """A table of the document."""

    model_config = ConfigDict(extra="allow", allow_inf_nan=False)


class DrapeMold(Part):
    """The mold as it stood: the STL moved by ``shift_mm`` is where the draped sheet's coordinates lie."""

    facets: int
    closed: bool
    shift_mm: list[float] = Field(description="[x, y, z] added to the STL's coordinates")


class SpringUse(Part):
    """How far the law of a direction was used."""

    model: str
    stretch_max: float = Field(description="largest stretch of a spring")
    tested_stretch_max: float | None = Field(
        default=None, description="largest stretch of the uniaxial tests behind the constants"
    )
    beyond_tested: int = Field(default=0, description="springs stretched beyond the tests")
    softens_at: float | None = Field(default=None, description="stretch at which the stress stops rising")


class DrapeDocument(Document):
    """A fabric draped on a mold."""

    KIND: ClassVar[str] = "drape"

    converged: bool = Field(description="residual_relative is at or below the tolerance")
    status: str | None = Field(default=None, description="why it did not converge, and where")
    iterations: int = Field(description="Newton steps on all grids")
    iterations_finest: int = Field(description="Newton steps on the grid asked for")
    residual_max_N: float = Field(description="largest unbalanced force on a node")
    residual_relative: float = Field(description="residual_max_N over the largest spring force")
    tolerance: float
    energy_J: float = Field(description="strain energy of the springs")
    force_N: float = Field(description="force of the press: sum of the contact forces along z")
    imbalance_N: float = Field(description="contact forces + clamp reactions + weight: zero at equilibrium")
    contact_nodes: int
    penetration_max_mm: float = Field(description="deepest point of the net, nodes and springs, in the mold")
    penetration_nodes_mm: float
    penetration_edges_mm: float
    penetration_edges_at_mm: list[float] | None = Field(
        default=None, description="place on the flat sheet of the spring that cuts deepest"
    )
    slack_springs: int
    stress_warp_max_MPa: float = Field(description="nominal: force per undeformed section")
    stress_weft_max_MPa: float
    thickness_min_mm: float
    thickness_mm: float = Field(description="of the flat sheet")
    grid: list[int] = Field(description="nodes along warp and weft")
    size_mm: list[float]
    depth_mm: float
    clamp: list[str]
    slide: list[str] = Field(default_factory=list, description="edges held but free along their line")
    solver: str = Field(default="newton")
    prestretch: list[float] = Field(default_factory=lambda: [1.0, 1.0], description="along warp and weft")
    mass_g_m2: float | None = None
    shear_modulus_MPa: float | None = None
    draw_in_mm: dict[str, float] | None = Field(
        default=None, description="how far each edge that is not clamped is drawn in"
    )
    max_stretch: float | None = Field(default=None, description="--max-stretch")
    over_max_stretch: int | None = Field(default=None, description="springs stretched further")
    warp: SpringUse
    weft: SpringUse
    mold: DrapeMold
    left_out: list[str] = Field(default_factory=list, description="effects this run does not model")
