"""What is asked of ``hf fabric-contact``."""

from __future__ import annotations

from dataclasses import dataclass

from hyperfab.cases.case import Case
from hyperfab.cases.field import amount, choice, file, flag, setting, stl_unit, thickness, uncertainty, whole
from hyperfab.cases.kinds import Amount, File, OrName
from hyperfab.errors import UsageError

#: Outlines that are no file.
SHAPES = ("disc", "square")
STICK = "stick"


@dataclass(frozen=True, kw_only=True)
class ContactCase(Case):
    """Push a rigid sphere or punch into a clamped sheet: nonlinear membrane finite elements.

    \b
    Example:
      hf fabric-contact fabric.json --shape disc --size 200mm --thickness 1mm \\
         --sphere-radius 40mm --depth 60mm -o contact.json
    """

    COMMAND = "fabric-contact"
    KIND = "contact"

    material: str = file("FABRIC.json", "Material document of hf fit, or -.", argument=True, required=True)
    against: str | None = file("OTHER.json", "Material to compare with (case B).")
    shape: str = setting(
        File(SHAPES),
        "SHAPE",
        "Outline of the sheet: disc, square, or a file (flat STL or mesh, CSV of x, y).",
        "disc",
    )
    size: float | None = amount(
        "length", "LENGTH",
        "Diameter or side of the undeformed sheet, 200mm; longer side of an outline from a file.", example="200mm",
        above=0.0,
    )  # fmt: skip
    thickness: float | None = thickness()
    sphere_radius: float | None = amount(
        "length", "LENGTH", "Radius of the rigid sphere, 40mm where not given.", example="40mm", above=0.0,
        over=("punch",),
    )  # fmt: skip
    middle_surface: bool = flag(
        "The sheet's middle surface meets the sphere, half a thickness off it, not the sheet's lower face."
    )
    punch: str | None = file(
        "PUNCH.stl", "A surface in place of the sphere, its top at depth 0.", over=("sphere_radius",)
    )
    edge_radius: float | None = amount(
        "length", "LENGTH", "Sharp edges of the punch are rounded by this, as those of a tool are.", example="2.5mm",
        above=0.0,
    )  # fmt: skip
    depth: float = amount("length", "LENGTH", "How far the sphere or the punch is pushed in.", "60mm", above=0.0)
    prestretch: float = amount(
        "dimensionless", "S", "The rim is held at S times its undeformed place.", "1", example="1.05 for 5 %",
        least=0.5, most=5.0,
    )  # fmt: skip
    rim_slip: float = amount(
        "compliance", "MM2/N", "The rim creeps inward by this times the tension, as 0.5mm^2/N.", "0mm^2/N",
        example="0.5mm^2/N", least=0.0, most=1e4,
    )  # fmt: skip
    frame_stiffness: float | None = amount(
        "stiffness", "STIFFNESS", "The machine yields: --depth is as it reads, the punch less deep by force over this.",
        example="50N/mm", above=0.0,
    )  # fmt: skip
    friction: float | str = setting(
        OrName(Amount("dimensionless", "0.3, a coefficient", least=0.0, most=2.0), (STICK,)), "MU",
        "Coulomb coefficient, or stick.", "0", called="friction_coefficient",
    )  # fmt: skip
    temperature: float | None = amount(
        "temperature",
        "T",
        "Of the fabric, as 80degC; beyond its tests the nearest constants hold.",
        example="80degC",
    )
    steps: int = whole("N", "Load steps shown; halved where needed.", "8", least=1, most=500)
    mesh_size: float | None = amount(
        "length",
        "LENGTH",
        "Edge length of the elements; finer at the edge of contact.",
        example="5mm",
        above=0.0,
    )
    element: str = choice(
        "P1|P2", "Straight elements of constant strain, or curved ones.", ("P1", "P2"), "P2", lenient=True
    )
    tolerance: float = amount(
        "dimensionless", "R", "Relative error of the force, for which elements are refined.", "1e-4", least=1e-7,
        most=0.1,
    )  # fmt: skip
    uncertainty: str | None = uncertainty()
    stl_unit: str = stl_unit()

    @property
    def yields(self) -> float:
        """What the machine yields by [mm/N]."""
        return 1.0 / self.frame_stiffness if self.frame_stiffness else 0.0

    def check(self) -> None:
        """Refuse what means nothing together."""
        super().check()
        if self.punch is not None and self.sphere_radius is not None:
            raise UsageError("--punch and --sphere-radius: one or the other is pushed in")
        if self.edge_radius is not None and self.punch is None:
            raise UsageError("--edge-radius is for the edges of a --punch; a sphere has none")
        if self.punch is not None and self.middle_surface:
            raise UsageError("--middle-surface is for the sphere; offset the punch's surface by half the thickness")
