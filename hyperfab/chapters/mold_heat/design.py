"""The design aids of ``hf mold-heat``: they set the heaters before the run that is written."""

from __future__ import annotations

from collections.abc import Callable

from hyperfab.arrays import Array
from hyperfab.cases.mold import MoldCase
from hyperfab.chapters.mold_heat.problem import Problem
from hyperfab.documents.heat import Design
from hyperfab.documents.mold import MoldDocument
from hyperfab.errors import InputError, NotConverged
from hyperfab.thermal.design import scale_for_warmup, scaled, share_power
from hyperfab.thermal.model import without_route


def check(case: MoldCase, document: MoldDocument) -> None:
    """Refuse aids that this mold cannot have."""
    if document.production is not None and (case.share_power or case.warmup_in is not None):
        raise InputError(
            "the powers are chosen for the warm-up, before the first piece",
            file=case.mold,
            key="production",
            remedy='choose them without it, then start = { document = "heat.json" } here',
        )
    if not document.heater and (case.share_power or case.warmup_in is not None):
        raise InputError("has no heater whose power could be chosen", file=case.mold, key="heater")
    if case.warmup_in is not None and (document.run.target is None or document.run.steady):
        raise InputError(
            "--warmup-in needs the temperature to reach",
            file=case.mold,
            key="run.target",
            remedy='add target = "200 degC" to [run], without steady',
        )
    if case.share_power and document.work_surface is None:
        raise InputError(
            "--share-power needs the surface to make even",
            file=case.mold,
            key="work_surface",
            remedy="add it",
        )
    if case.share_power and any(h.schedule is not None or h.control is not None for h in document.heater):
        raise InputError(
            "--share-power is for heaters of constant power",
            file=case.mold,
            key="heater",
            remedy="take schedule and control out",
        )


def design(
    case: MoldCase,
    document: MoldDocument,
    problem: Problem,
    start: Array,
    warmup: Callable[[], float | None],
) -> Design | None:
    """Set the heaters as asked; return what was chosen. ``warmup`` runs the mold as it is set."""
    if not case.share_power and case.warmup_in is None:
        return None
    heaters = problem.model.heaters
    result = Design()
    if case.share_power:
        assert problem.work_surface is not None
        if without_route(problem.model) is not None:
            raise InputError(
                "--share-power works on the steady state, and a part has no route for the heat out",
                file=case.mold,
                key="convection",
                remedy="add convection, radiation or a held temperature",
            )
        mean = None if case.warmup_in is not None else document.run.target
        shared = share_power(problem.model, problem.work_surface, start, most=case.heater_max, mean=mean)
        result.steady_spread_before_K = shared.spread_before
        result.steady_spread_K = shared.spread
        result.steady_mean_degC = shared.mean
    if case.warmup_in is not None:
        powers = [heater.power for heater in heaters]

        def scale(factor: float) -> None:
            for heater, power in zip(heaters, powers, strict=True):
                heater.power = power
                heater.power = scaled(heater, factor)

        def time(factor: float) -> float | None:
            scale(factor)
            return warmup()

        result.warmup_wanted_s = case.warmup_in
        result.power_factor, result.runs = scale_for_warmup(case.warmup_in, time)
        scale(result.power_factor)
    result.power_W = {heater.name: float(heater.power.y.max()) for heater in heaters}
    most = max(result.power_W, key=lambda name: result.power_W[name])
    if case.heater_max is not None and result.power_W[most] > case.heater_max * (1.0 + 1e-6):
        raise NotConverged(
            f"the target in {case.warmup_in:g} s takes {result.power_W[most]:.6g} W of {most}, more than the "
            f"{case.heater_max:g} W of --heater-max",
            remedy="allow more power a heater, or a longer --warmup-in",
        )
    return result
