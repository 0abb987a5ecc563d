"""Is a form worth a fit? What a little of it would take of what a model leaves, to first order."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hyperfab.arrays import Array
from hyperfab.loop.fitting import Fit
from hyperfab.loop.judge import correlation_time
from hyperfab.loop.noise import Noise
from hyperfab.loop.problem import Form, Problem
from hyperfab.loop.score import Signature, beside, projected
from hyperfab.loop.thresholds import MARGIN
from hyperfab.numerics.gram import orthonormal


def worth_a_fit(problem: Problem, fitted: Fit, form: Form, found: Sequence[Signature]) -> bool:
    """Whether a form may pay beside a fit without its effect, by the signatures that were ``found`` there.

    One that is screened has to point at what is left; all others are always worth it.
    """
    if not form.screened:
        return True
    return _may_pay(problem, fitted, [one.direction for one in found if one.form is form])


def refining(problem: Problem, noise: Noise, fitted: Fit, name: str, *, free: bool = False) -> list[Form]:
    """Return the forms that refine that of ``name`` in a fit, and may pay: ``free`` ones, or formulas."""
    simpler = fitted.forms[name].name
    return [
        form
        for form in problem.effect(name).forms
        if form.enriches(simpler)
        and form.free is free
        # The probes of a form are what it has more than the first of those that it refines.
        and (not form.screened or form.simpler[0] != simpler or _points(problem, noise, fitted, name, form))
    ]


def _points(problem: Problem, noise: Noise, fitted: Fit, name: str, form: Form) -> bool:
    """Whether the probes of a form point at what the simpler one of ``name`` in a fit leaves."""
    simpler = fitted.forms[name]
    known = simpler.named(fitted.x[fitted.place(name)])
    own, terms, level = fitted.x[: fitted.own], fitted.terms, noise.at(fitted.predicted)
    basis, _ = projected(fitted)
    ways = []
    for probe in form.probes:
        values = [known.get(one.name, value) for one, value in zip(form.constants, probe, strict=True)]
        told = problem.predict(own, {**terms, name: (form.name, np.array(values))})
        if np.all(np.isfinite(told)):
            _, left = beside(basis, level.whiten(told - fitted.by_model))
            ways.append(left)
    return _may_pay(problem, fitted, ways)


def _may_pay(problem: Problem, fitted: Fit, ways: Sequence[Array]) -> bool:
    """Whether what lies along ``ways``, each (rows,), is more than a name has to lower BIC by.

    As where fits are compared, what would then be left counts as noise, and as many rows of it as one as are alike.
    """
    ways = [way for way in ways if np.any(way)]
    if not ways:
        return False
    _, residual = projected(fitted)
    span = orthonormal(np.stack(ways, axis=1))
    along = span.T @ residual
    rest = (residual - span @ along)[: len(fitted.residual)]
    level = max(float(rest @ rest) / max(len(rest) - len(fitted.x), 1), 1.0)
    return bool(along @ along > MARGIN * level * correlation_time(rest, problem.curves))
