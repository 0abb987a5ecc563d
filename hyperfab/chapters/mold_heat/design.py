"""The design aids of ``hf mold-heat``: they set the heaters before the run that is written."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from hyperfab.chapters.mold_heat.problem import Problem
from hyperfab.documents.heat import Design
from hyperfab.documents.mold import MoldDocument
from hyperfab.errors import InputError, UsageError
from hyperfab.io.units import quantity
from hyperfab.thermal.design import scale_for_warmup, scaled, share_power
from hyperfab.thermal.routes import without_route

Array = NDArray[np.float64]


class Wishes:
    """What the options ask for: a warm-up time, an even surface, the most a heater can give."""

    def __init__(self, warmup_in: str | None, share: bool, heater_max: str | None) -> None:
        self.seconds = None if warmup_in is None else quantity(warmup_in, "time", option="--warmup-in")
        if self.seconds is not None and self.seconds <= 0.0:
            raise UsageError(f"--warmup-in {warmup_in}: must be more than zero")
        self.share = share
        self.most = None if heater_max is None else quantity(heater_max, "power", option="--heater-max")
        if self.most is not None and not share:
            raise UsageError("--heater-max bounds what --share-power gives each heater: give both")

    def check(self, document: MoldDocument, name: str) -> None:
        """Refuse wishes that this mold cannot have."""
        if not document.heater and (self.share or self.seconds is not None):
            raise InputError("has no heater whose power could be chosen", file=name, key="heater")
        if self.seconds is not None and (document.run.target is None or document.run.steady):
            raise InputError(
                "--warmup-in needs the temperature to reach",
                file=name,
                key="run.target",
                remedy='add target = "200 degC" to [run], without steady',
            )
        if self.share and document.work_surface is None:
            raise InputError(
                "--share-power needs the surface to make even", file=name, key="work_surface", remedy="add it"
            )
        if self.share and any(h.schedule is not None or h.control is not None for h in document.heater):
            raise InputError(
                "--share-power is for heaters of constant power",
                file=name,
                key="heater",
                remedy="take schedule and control out",
            )


def design(
    wishes: Wishes,
    document: MoldDocument,
    name: str,
    problem: Problem,
    start: Array,
    warmup: Callable[[], float | None],
) -> Design | None:
    """Set the heaters as wished; return what was chosen. ``warmup`` runs the mold as it is set."""
    if not wishes.share and wishes.seconds is None:
        return None
    heaters = problem.model.heaters
    result = Design()
    if wishes.share:
        assert problem.work_surface is not None
        if without_route(problem.model) is not None:
            raise InputError(
                "--share-power works on the steady state, and a part has no route for the heat out",
                file=name,
                key="convection",
                remedy="add convection, radiation or a held temperature",
            )
        mean = None if wishes.seconds is not None else document.run.target
        shared = share_power(problem.model, problem.work_surface, start, most=wishes.most, mean=mean)
        result.steady_spread_before_K = shared.spread_before
        result.steady_spread_K = shared.spread
        result.steady_mean_degC = shared.mean
    if wishes.seconds is not None:
        powers = [heater.power for heater in heaters]

        def time(factor: float) -> float | None:
            for heater, power in zip(heaters, powers, strict=True):
                heater.power = power
                heater.power = scaled(heater, factor)
            return warmup()

        result.warmup_wanted_s = wishes.seconds
        result.power_factor, result.runs = scale_for_warmup(wishes.seconds, time)
        time_factor = result.power_factor
        for heater, power in zip(heaters, powers, strict=True):
            heater.power = power
            heater.power = scaled(heater, time_factor)
    result.power_W = {heater.name: float(heater.power.y.max()) for heater in heaters}
    return result
