"""What is asked of ``hf mold-heat``."""

from __future__ import annotations

from dataclasses import dataclass

from hyperfab.cases.case import Case
from hyperfab.cases.field import amount, file, flag, stl_unit, uncertainty
from hyperfab.errors import UsageError


@dataclass(frozen=True, kw_only=True)
class MoldCase(Case):
    """Heat a mold: transient conduction and convection on 10-node tetrahedra.

    \b
    Example:
      hf mold-heat molds/proposed.toml -o heat.json
      hf mold-heat molds/original.toml --warmup-in 20min -o fast.json
      hf mold-heat molds/original.toml --variations factors.csv -o varied.json
    """

    COMMAND = "mold-heat"
    KIND = "heat"

    mold: str = file("MOLD.toml", "Mold document: parts, heaters, conditions.", argument=True, required=True)
    warmup_in: float | None = amount(
        "time", "TIME", "Scale all heaters so that the target is reached in TIME.", example="20min", above=0.0
    )
    share_power: bool = flag("Share the power among the heaters for an even work surface.")
    heater_max: float | None = amount("power", "POWER", "Most that --share-power may give one heater.", example="900W")
    variations: str | None = file(
        "FILE.csv", "Factors on film, power, conductivity, specific heat, one run a row, on a reduced model."
    )
    uncertainty: str | None = uncertainty()
    stl_unit: str = stl_unit()

    def check(self) -> None:
        """Refuse what means nothing together."""
        super().check()
        if self.heater_max is not None and not self.share_power:
            raise UsageError("--heater-max bounds what --share-power gives each heater: give both")
