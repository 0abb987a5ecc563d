"""``drape.json``: the sheet at equilibrium on the mold: forces, stresses, thickness, slack, penetration."""

from __future__ import annotations

from typing import ClassVar

from pydantic import Field

from hyperfab.documents.base import Part, optional
from hyperfab.documents.uncertainty import Computed


class Place(Part):
    """A place of the net."""

    flat: list[float] = Field(description="[x, y] mm on the flat sheet")
    draped: list[float] = Field(description="[x, y, z] mm as draped")


class DrapeMold(Part):
    """The mold as it stood: the STL moved by ``shift_mm`` is where the draped sheet's coordinates lie."""

    facets: int
    closed: bool
    shift_mm: list[float] = Field(description="[x, y, z] added to the STL's coordinates, turned where axis is not z")
    axis: str = Field(
        default="z", description="of the STL, points up: its x, y, z are turned to y, z, x (x) or z, x, y (y)"
    )


class SpringUse(Part):
    """How far the law of a direction was used."""

    model: str
    stretch_max: float = Field(description="largest stretch of a spring; of a membrane along it in a cell")
    tested_stretch_max: float | None = optional("largest stretch of the uniaxial tests behind the constants")
    beyond_tested: int | None = optional(
        "springs, or cells of a membrane, beyond the tests; absent where nothing says how far these went"
    )
    softens_at: float | None = optional("stretch at which the stress stops rising")
    ends_at: float | None = optional("stretch at which the law ends (locks), where springs pass it")
    fails_at: float | None = optional("stretch at which the tested specimen failed, where springs pass it")


class Rubbing(Part):
    """What friction took on the way: the press's work is the energy stored plus what was rubbed away."""

    load_steps: int
    work_J: float = Field(description="of the press, by the trapezoidal rule over the load steps")
    rubbed_J: float = Field(description="dissipated on the mold")
    drawn_J: float = Field(description="dissipated under the blank holder")
    balance_relative: float = Field(
        description="(work - stored - dissipated)/work; vanishes with the square of the load step"
    )
    sticking_nodes: int = Field(description="nodes on the mold that do not slide in the last load step")
    sliding_nodes: int


class DrapeState(Part):
    """The sheet at one depth."""

    depth_mm: float
    converged: bool
    residual_relative: float
    force_N: float
    energy_J: float
    contact_nodes: int
    contact_edges: int | None = None
    slack_springs: int
    stress_warp_max_MPa: float
    stress_weft_max_MPa: float
    thickness_min_mm: float
    penetration_max_mm: float
    draw_in_mm: dict[str, float] | None = None


class DrapeDocument(Computed):
    """A fabric draped on a mold."""

    KIND: ClassVar[str] = "drape"

    converged: bool = Field(description="residual_relative is at or below the tolerance")
    status: str | None = optional("why it did not converge, and where")
    iterations: int = Field(description="Newton steps on all grids")
    iterations_finest: int = Field(description="Newton steps on the grid asked for")
    residual_max_N: float = Field(description="largest unbalanced force on a node")
    residual_relative: float = Field(
        description="residual_max_N over the largest spring force (of a membrane: that a cell passes on)"
    )
    tolerance: float
    sheet: str = Field(
        default="net", description="net: springs along warp and weft; membrane: one law of the whole sheet"
    )
    energy_J: float = Field(description="strain energy of the springs, or of the membrane")
    force_N: float = Field(description="force of the press: sum of the contact forces along z")
    imbalance_N: float = Field(description="contact forces + clamp reactions + weight: zero at equilibrium")
    contact_nodes: int
    contact_edges: int | None = optional("springs between two nodes that a sharp edge of the mold carries")
    penetration_max_mm: float = Field(description="deepest point of the net, nodes and springs, in the mold")
    penetration_nodes_mm: float
    penetration_edges_mm: float = Field(
        description="depth of the deepest point of any spring below the mold's surface, exact to 1e-6 mm"
    )
    penetration_edges_at_mm: list[float] | None = optional("place on the flat sheet of the spring that cuts deepest")
    stretch_max: float | None = optional(
        "largest stretch of a spring, of warp and weft; of a membrane the largest principal stretch"
    )
    stretch_max_at_mm: Place | None = optional("the middle of that spring, or of that cell of a membrane")
    stress_max_MPa: float | None = optional("of a membrane: largest Cauchy principal stress")
    stress_nominal_max_MPa: float | None = optional(
        "largest nominal stress, force per undeformed section: of springs, of a membrane the principal one"
    )
    wrinkled_area_fraction: float | None = optional("of a membrane: share of the undeformed area wrinkled or slack")
    stands_through_mm: float | None = optional(
        "how far a corner or tip of the mold stands out through the net, between its nodes"
    )
    stands_through_at_mm: Place | None = optional("where, on the sheet and in space")
    slack_springs: int = Field(
        description="springs without tension; of a membrane cells without tension in one direction or both"
    )
    stress_warp_max_MPa: float = Field(description="nominal: force per undeformed section")
    stress_weft_max_MPa: float
    thickness_min_mm: float
    thickness_mm: float = Field(description="of the flat sheet")
    grid: list[int] = Field(description="nodes along warp and weft")
    size_mm: list[float]
    shape: str = Field(default="rectangle", description="of the flat sheet: rectangle, or disc")
    depth_mm: float
    temperature_degC: float | None = optional("of the fabric's constants, where known")
    constants_degC: float | None = optional("temperature of the constants, where none are known at that of the fabric")
    clamp: list[str]
    slide: list[str] = Field(default_factory=list, description="edges held but free along their line")
    blank_holder_N_mm: dict[str, float] | None = optional(
        "friction of the blank holder a unit length of an edge: drawn in at this pull"
    )
    friction: float | None = optional("coefficient of Coulomb friction on the mold")
    rubbing: Rubbing | None = optional("where something rubs")
    depth_reached_mm: float | None = optional("where the way ended early: the last depth with an equilibrium")
    force_depth: list[list[float]] | None = optional("[[depth_mm, force_N], ...] at the states asked for")
    states: list[DrapeState] | None = optional("the sheet at each depth asked for")
    solver: str = Field(default="newton")
    prestretch: list[float] = Field(default_factory=lambda: [1.0, 1.0], description="along warp and weft")
    mass_g_m2: float | None = None
    shear_modulus_MPa: float | None = None
    shear_law: str | None = optional("measured: such that the net answers a bias test as measured")
    draw_in_mm: dict[str, float] | None = optional("how far each edge that is not clamped is drawn in")
    max_stretch: float | None = optional("--max-stretch")
    over_max_stretch: int | None = optional("springs stretched further")
    over_max_stretch_at_mm: list[float] | None = optional(
        "place on the flat sheet of the most stretched spring, where it is over"
    )
    warp: SpringUse
    weft: SpringUse
    mold: DrapeMold
    left_out: list[str] = Field(default_factory=list, description="effects this run does not model")
