"""What is asked of ``hf press-contact``."""

from __future__ import annotations

import math
from dataclasses import dataclass

from hyperfab.cases.case import Case
from hyperfab.cases.field import amount, choice, file, flag, series, setting, stl_unit, uncertainty, whole
from hyperfab.cases.kinds import Amount, AmountOrFile, Percent
from hyperfab.errors import UsageError


@dataclass(frozen=True, kw_only=True)
class PressCase(Case):
    """Press two hot molds on the fabric-foam-fabric sandwich: where do they touch, and how hard.

    \b
    Example:
      hf press-contact --male molds/cup-male.stl --female molds/cup-female.stl --axis z \\
         --foam specimens/foam.toml --gap 3mm --temperature 200degC -o press.json
    """

    COMMAND = "press-contact"
    KIND = "press"

    male: str = file("MALE.stl", "Surface of the male mold.", required=True)
    female: str = file("FEMALE.stl", "Surface of the female mold.", required=True)
    foam: str = file(
        "FOAM.toml",
        "The sandwich: foam and fabric layers; or the material document of a foam alone.",
        required=True,
    )
    axis: str = choice("AXIS", "Closing axis: x, y or z.", ("x", "y", "z"), "z")
    gap: float | None = amount(
        "length", "LENGTH", "Axial clearance at the datum, cold.", least=0.0, over=("force",),
        example="3mm; below 0 the molds would overlap at the datum",
    )  # fmt: skip
    force: float | None = amount(
        "force", "FORCE", "Closing force; the position is solved.", example="500N", above=0.0, over=("gap",)
    )
    temperature: float | None = amount(
        "temperature",
        "T",
        "Uniform temperature of both molds.",
        example="200degC",
        over=("male_heat", "female_heat"),
    )
    male_heat: str | None = file("HEAT.json", "The male mold's temperature.", over=("temperature",))
    female_heat: str | None = file("HEAT.json", "The female mold's temperature.", over=("temperature",))
    drape: str | None = file("DRAPE.json", "Fabric thickness from hf drape.")
    dwell: float | None = amount(
        "time", "TIME", "How long the press stays closed: also tells the sandwich's temperature.", example="60s",
        above=0.0,
    )  # fmt: skip
    target: float | None = amount(
        "temperature", "T", "With --dwell: when the foam's middle reaches this.", example="180degC"
    )
    mounted: str = choice(
        "HOW",
        "Mounting faces are held flat, or free to warp with the heat: flat or free.",
        ("flat", "free"),
        "flat",
    )
    zero: str = choice(
        "WHEN", "Whether --gap was set cold or again on the hot molds: cold or hot.", ("cold", "hot"), "cold"
    )
    floating: bool = flag(
        "The female hangs on a joint in its mounting face and finds its tilt.",
        option="--float",
        over=("tilt",),
    )
    force_at: tuple[float, float] | None = series(
        Amount("length", "10mm"), ",", (2,), "L,L", "Where the joint sits across the axis, as 10mm,0mm.",
        example="10mm,5mm: the two components across the axis",
    )  # fmt: skip
    frame_stiffness: float | None = amount(
        "stiffness", "STIFFNESS", "The press frame yields, as 50kN/mm.", example="50kN/mm", above=0.0
    )
    tilt: tuple[float, float] | None = series(
        Amount("angle", "0.05deg"), ",", (2,), "ANGLE,ANGLE",
        "The female stands tilted about the two axes across the closing axis, as 0.05deg,0deg.",
        example="0.05deg,0deg: the two components across the axis", over=("floating",),
    )  # fmt: skip
    strokes: int = whole("N", "Points of the force-stroke curve.", "21", least=2, most=1001)
    min_spotted: float | None = setting(
        Percent("dimensionless", "80%", least=0.0, most=100.0),
        "PERCENT",
        "Exit 1 where less of the molding surface touches.",
    )
    max_pressure: float | None = amount(
        "stress", "PRESSURE", "Exit 1 where the pressure is above this anywhere.", example="10kPa", above=0.0
    )
    design_gap: float | None = amount(
        "length", "LENGTH", "Also write the male that leaves this hot gap everywhere, as STL.", example="2mm",
        above=0.0,
    )  # fmt: skip
    wanted: str | None = setting(
        AmountOrFile(item=Amount("length", "3mm", above=0.0)), "LENGTH|FILE.csv",
        "Formed thickness that is wanted: a length, or x, y, z [mm] and thickness [mm] in a file; needs --dwell.",
    )  # fmt: skip
    within: float = amount(
        "length", "LENGTH", "The area that misses the wanted thickness by more is told.", "0.1mm", above=0.0
    )
    compensate: bool = flag("Change the male until what is formed is what is wanted, and write it as STL.")
    facets: str = choice(
        "KIND",
        "STL facets stand for a smooth surface, or are flat: smooth or flat.",
        ("smooth", "flat"),
        "smooth",
    )
    uncertainty: str | None = uncertainty()
    stl_unit: str = stl_unit()

    def check(self) -> None:
        """Refuse what means nothing together."""
        super().check()
        if (self.gap is None) == (self.force is None):
            raise UsageError("give --gap or --force" if self.gap is None else "give only one of --gap and --force")
        if self.male == self.female:
            raise UsageError(f"--male and --female name the same file, {self.male}")
        if self.temperature is not None and (self.male_heat or self.female_heat):
            raise UsageError("--temperature and heat documents exclude each other; give one of them")
        if self.target is not None and self.dwell is None:
            raise UsageError("--target is what the middle should reach: say within which --dwell")
        if self.tilt is not None:
            from hyperfab.documents.press_terms import MOST_TILT_DEG  # pydantic is not for the help page

            if math.hypot(*self.tilt) > MOST_TILT_DEG:
                raise UsageError(f"--tilt: a press does not tilt by more than {MOST_TILT_DEG:g} deg")
        if self.wanted is not None and self.dwell is None:
            raise UsageError(
                "--wanted is the formed thickness, which needs the time the press stays closed: give --dwell"
            )
        if self.compensate and self.wanted is None:
            raise UsageError("--compensate needs what is wanted: give --wanted 3mm")
        if self.force_at is not None and not self.floating:
            raise UsageError("--force-at says where a floating mold is pushed: add --float")
        if self.floating and self.tilt is not None and any(self.tilt):
            raise UsageError("a floating mold finds its tilt by itself: leave out --float, or the tilt")
