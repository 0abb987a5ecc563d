"""What is asked of ``hf drape``."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from hyperfab.cases.case import Case
from hyperfab.cases.field import (
    amount,
    choice,
    file,
    files,
    series,
    setting,
    stl_unit,
    thickness,
    uncertainty,
    whole,
)
from hyperfab.cases.kinds import Amount, Kind, Whole
from hyperfab.errors import UsageError

SIDES = ("x-", "x+", "y-", "y+")
#: In the place of an edge of the blank holder: each edge that is clamped.
CLAMPED = "clamped"
MOST_NODES = 4_000_000
MOST_STATES = 1000
#: Load steps to the full depth where friction makes the way matter, and steps of the slow solvers.
LOAD_STEPS = 20
DYNAMIC_STEPS, RELAXATION_STEPS = 100_000, 400
_EDGES = "edges, or some of x-,x+,y-,y+"


@dataclass(frozen=True)
class Edges(Kind):
    """Edges of the sheet: ``edges`` (all four) or some of x-,x+,y-,y+."""

    def read(self, text: Any, option: str) -> tuple[str, ...]:
        """Return the edges, in the order of SIDES."""
        names = list(SIDES) if text.strip() == "edges" else [part.strip() for part in text.split(",")]
        return tuple(self.checked(text, option, lambda: self.load(names)))

    def words(self, value: tuple[str, ...]) -> str:
        return "edges" if value == SIDES else ",".join(value)

    def load(self, data: Any) -> tuple[str, ...]:
        if not isinstance(data, (list, tuple)):
            raise ValueError("a list of edges is needed")
        for name in data:
            if name not in SIDES:
                raise ValueError(f"{name!r} is no edge; write {_EDGES}")
        return tuple(side for side in SIDES if side in data)

    def schema(self) -> dict[str, Any]:
        return {"type": "array", "items": {"enum": list(SIDES)}}


@dataclass(frozen=True)
class Holder(Kind):
    """The friction of a blank holder by edge: ``2 N/mm`` (all clamped edges), ``x-,x+=2 N/mm``."""

    force = Amount("membrane-stress", "2N/mm; an edge that nothing holds is left out of --clamp", above=0.0)
    unit = "N/mm"
    repeated = True

    def read(self, text: Any, option: str) -> dict[str, float]:
        """Return the friction in N/mm by edge, or for each edge that is clamped; the last that names an edge counts."""
        found: dict[str, float] = {}
        for one in text:
            edges, mark, size = one.rpartition("=")
            sides = Edges().read(edges, option) if mark else (CLAMPED, *SIDES)
            force = self.force.read(size, option)
            found = {side: value for side, value in found.items() if side not in sides}
            found |= dict.fromkeys(sides if mark else [CLAMPED], force)
        return found

    def words(self, value: Mapping[str, float]) -> list[str]:
        return [("" if side == CLAMPED else f"{side}=") + self.force.words(force) for side, force in value.items()]

    def load(self, data: Any) -> dict[str, float]:
        if not isinstance(data, Mapping) or not set(data) <= {CLAMPED, *SIDES}:
            raise ValueError(f"a friction by edge is needed, the edges {', '.join(SIDES)}")
        return {side: self.force.load(force) for side, force in data.items()}

    def dump(self, value: Any) -> dict[str, float]:
        return dict(value)

    def schema(self) -> dict[str, Any]:
        return {"type": "object", "additionalProperties": self.force.schema()}


@dataclass(frozen=True, kw_only=True)
class DrapeCase(Case):
    """Relax a grid of tension-only springs, or a membrane, onto a mold (STL).

    \b
    Example:
      hf drape fabric.json --mold molds/cup-male.stl --grid 100x100 \\
         --size 220mmx220mm --depth 60mm -o drape.json
    """

    COMMAND = "drape"
    KIND = "drape"

    material: str | None = file("FABRIC.json", "Material document of hf fit, or -; or --warp, --weft.", argument=True)
    mold: tuple[str, ...] = files("MOLD.stl", "Surface of the mold; repeated for several in one frame.", required=True)
    grid: tuple[int, int] = series(
        Whole("100", least=3),
        "x",
        (2,),
        "NxM",
        "Nodes along x (warp) and y (weft).",
        "101x101",
        example="100x100",
    )
    size: tuple[float, float] = series(
        Amount("length", "220mm", above=0.0),
        "x",
        (1, 2),
        "LxL",
        "The flat sheet, as 220mmx220mm.",
        "220mmx220mm",
    )
    shape: str = choice(
        "NAME", "Of the flat sheet: rectangle; disc, clamped all round, with --sheet membrane.",
        ("rectangle", "disc"), "rectangle",
    )  # fmt: skip
    offset: tuple[float, float] = series(
        Amount("length", "3mm"), "x", (2,), "LxL", "How far the mold's middle is from the sheet's, along x and y.",
        "0mmx0mm", example="3mmx-2mm",
    )  # fmt: skip
    depth: float = amount("length", "LENGTH", "How far the mold is pushed up.", "60mm", least=0.0, over=("depths",))
    states: int | None = whole(
        "N", "Also the sheet at N equal depths up to --depth.", example="6 for six equal depths", least=1,
        most=MOST_STATES, over=("depths",),
    )  # fmt: skip
    depths: tuple[float, ...] | None = series(
        Amount("length", "20mm", least=0.0), ",", (), "L,L,...", "In place of --depth: several, as 20mm,40mm,60mm.",
        example="20mm,40mm,60mm", over=("states",),
    )  # fmt: skip
    sheet: str = choice(
        "NAME", "net: springs, warp and weft each with its uniaxial curve; membrane: the document's own law.",
        ("net", "membrane"), "net",
    )  # fmt: skip
    warp: str | None = file("TEST.csv", "Uniaxial test taken as the warp's law as it stands.")
    weft: str | None = file("TEST.csv", "Uniaxial test taken as the weft's law as it stands.")
    thickness: float | None = thickness()
    temperature: float | None = amount(
        "temperature",
        "T",
        "Of the fabric, as 80degC; beyond its tests the nearest constants hold.",
        example="90degC",
    )
    clamp: tuple[str, ...] = setting(
        Edges(), "EDGES", "Clamped edges: edges (all four), or some of x-,x+,y-,y+.", "edges"
    )
    slide: tuple[str, ...] | None = setting(Edges(), "EDGES", "Edges held down but free to slide along their line.")
    blank_holder: Mapping[str, float] | None = setting(
        Holder(), "[EDGES=]F/L", "Clamped edges give way where pulled by more, as 0.5N/mm or y-,y+=0.5N/mm."
    )
    friction: float = amount(
        "dimensionless",
        "MU",
        "Coulomb friction on the mold, as 0.3.",
        "0",
        example="0.3",
        least=0.0,
        most=2.0,
    )
    load_steps: int | None = whole(
        "N", f"Steps of the mold's way with friction; {LOAD_STEPS} if not given.", example="20", least=1
    )
    prestretch: tuple[float, float] = series(
        Amount("dimensionless", "1.05", least=0.5, most=3.0), "x", (1, 2), "S[xS]",
        "Stretch along warp x weft in which the sheet is mounted.", "1", example="1.05 or 1.05x1.1",
    )  # fmt: skip
    mass: float = amount(
        "mass-per-area", "MASS/AREA", "Fabric's mass per area: lets its weight act.", "0g/m^2", example="180g/m^2",
        least=0.0, most=1e6,
    )  # fmt: skip
    shear_modulus: float | None = amount(
        "stress", "STRESS", "Threads resist turning by this shear modulus.", example="0.05MPa", above=0.0,
        over=("shear_law",),
    )  # fmt: skip
    shear_law: str | None = file(
        "BIAS.csv", "Threads resist turning as a test cut at 45 deg shows.", over=("shear_modulus",)
    )
    max_stretch: float | None = amount(
        "dimensionless", "S", "Exit 1 where a spring is stretched further.", example="1.8 for 80 %", above=1.0
    )
    solver: str = choice(
        "NAME", "newton; to compare: dynamic (a slow second opinion), relaxation (the report's own).",
        ("newton", "dynamic", "relaxation"), "newton",
    )  # fmt: skip
    steps: int | None = whole(
        "N",
        f"Steps of the relaxation ({RELAXATION_STEPS}), of the dynamic ({DYNAMIC_STEPS}).",
        example="400",
        least=1,
    )
    divisor: float = amount("dimensionless", "C", "Constant c of the relaxation's step.", "40", above=0.0)
    tolerance: float = amount(
        "dimensionless",
        "R",
        "Largest nodal residual over the largest spring force.",
        "1e-6",
        least=1e-12,
        most=1e-2,
    )
    uncertainty: str | None = uncertainty()
    stl_unit: str = stl_unit()
    axis: str = choice("AXIS", "Axis of the STL that points up, into the sheet: x, y or z.", ("x", "y", "z"), "z")

    def check(self) -> None:
        """Refuse what means nothing together."""
        super().check()
        if self.material is None and self.warp is None and self.weft is None:
            raise UsageError(
                "no fabric: name a material document (FABRIC.json), or uniaxial tests with --warp and --weft"
            )
        nodes = self.grid[0] * self.grid[1]
        if nodes > MOST_NODES:
            shown = f"{self.grid[0]}x{self.grid[1]}"
            raise UsageError(f"--grid {shown}: {nodes} nodes are more than the {MOST_NODES} that fit; take fewer")
        if self.depths is not None:
            if self.states is not None:
                raise UsageError("--states and --depths both say where the sheet is wanted; give one of them")
            if not self.depths or len(set(self.depths)) < len(self.depths) or len(self.depths) > MOST_STATES:
                raise UsageError("--depths: different depths of 0mm or more; write 20mm,40mm,60mm")
        both = [side for side in self.clamp if side in self.sliding]
        if both:
            raise UsageError(f"--slide {both[0]}: that edge is clamped; leave it out of --clamp")
        loose = [side for side in self.blank_holder or () if side not in (CLAMPED, *self.clamp)]
        if loose:
            raise UsageError(f"--blank-holder: {loose[0]} is not held; name it in --clamp too")
        if self.shear_modulus is not None and self.shear_law is not None:
            raise UsageError("--shear-modulus and --shear-law both say what resists shear; give one of them")
        if self.solver != "newton" and self.has_friction:
            raise UsageError(f"--solver {self.solver} knows no friction; leave out --friction and --blank-holder")
        if self.sheet == "membrane":
            self._check_membrane()
        if self.shape == "disc":
            self._check_disc()
        if self.load_steps is not None and not self.has_friction:
            raise UsageError(
                f"--load-steps {self.load_steps}: only where --friction or --blank-holder makes the way matter"
            )

    def _check_membrane(self) -> None:
        """Refuse what a membrane has of its own, or what only a net knows."""
        if self.warp is not None or self.weft is not None:
            option = "--warp" if self.warp is not None else "--weft"
            raise UsageError(
                f"--sheet membrane obeys a law of the whole sheet, and {option} is a test along one direction; fit it "
                "with hf fit, and leave it out here"
            )
        if self.shear_modulus is not None or self.shear_law is not None:
            option = "--shear-modulus" if self.shear_modulus is not None else "--shear-law"
            raise UsageError(
                f"--sheet membrane resists shear as the document's law says; leave {option} out (hf fit --model "
                "orthotropic finds the shear of a fabric)"
            )
        if self.solver == "relaxation":
            raise UsageError(
                "--solver relaxation is the report's own for its springs; --sheet membrane takes newton or dynamic"
            )

    def _check_disc(self) -> None:
        """Refuse what a round sheet cannot be, or what only one with sides knows."""
        if self.sheet != "membrane":
            raise UsageError(
                "--shape disc: springs along warp and weft have no round rim to end at; take --sheet membrane"
            )
        if self.size[0] != self.size[1]:
            raise UsageError(
                f"--shape disc: {self.size[0]:g} mm by {self.size[1]:g} mm are two diameters; write one: --size 200mm"
            )
        if self.clamp != SIDES or self.slide or self.blank_holder:
            option = "--slide" if self.slide else "--blank-holder" if self.blank_holder else "--clamp"
            raise UsageError(
                f"{option}: a disc has one rim, which is clamped; leave {option} out, or take --shape rectangle"
            )

    @property
    def wanted(self) -> list[float]:
        """Depths in mm at which the sheet is wanted, rising; the last is how far the mold is pushed."""
        if self.depths is not None:
            return sorted(self.depths)
        if self.states is None or self.depth == 0.0:
            return [self.depth]
        return [self.depth * (k + 1) / self.states for k in range(self.states)]

    @property
    def sliding(self) -> list[str]:
        """Edges held but free along their line."""
        return list(self.slide or ())

    @property
    def holder(self) -> dict[str, float]:
        """The blank holder's friction in N/mm by edge."""
        given = self.blank_holder or {}
        found = {side: given.get(side, given.get(CLAMPED)) for side in self.clamp}
        return {side: force for side, force in found.items() if force is not None}

    @property
    def has_friction(self) -> bool:
        """Does the sheet remember the way it was draped?"""
        return self.friction > 0.0 or bool(self.blank_holder)
