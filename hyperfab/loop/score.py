"""Which catalogue entry does the residual point at: scores, with what the model's own constants can do taken off."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from scipy.special import erfc

from hyperfab.arrays import Array
from hyperfab.loop.fitting import Fit
from hyperfab.loop.noise import Noise
from hyperfab.loop.problem import Effect, Form, Problem
from hyperfab.numerics.gram import orthonormal

#: A signature that keeps less of its square than this after projection cannot be seen on these data, unless at the size
#: a fit begins with it stands this many standard deviations of the noise out, and keeps what differences can tell.
_VISIBLE, _STANDS_OUT, _TOLD = 1e-5, 6.0, 1e-8
_DRAWS = 2000
#: Below this the sum of the single probabilities bounds that of the greatest well enough.
_CLEAR = 1e-6


@dataclass(frozen=True)
class Signature:
    """What a little of an effect would do to the whitened prediction, and how the residual lies along it.

    ``direction`` has unit length and is orthogonal to the model's own sensitivities; ``kept`` is the share
    of the imprint's square
    that they cannot imitate; ``z`` the residual's component in standard deviations; ``robust_z`` the same with smooth
    departures of the base law taken off too.
    """

    effect: Effect
    form: Form
    probe: tuple[float, ...]
    direction: Array
    kept: float
    size: float
    z: float
    robust_z: float


def signatures(problem: Problem, noise: Noise, fit: Fit, effects: Iterable[Effect]) -> list[Signature]:
    """Return the signatures of all forms of ``effects`` that the data could show.

    A form that refines another has one of its own only where the data could not show the simpler one.
    """
    own, terms, noise = fit.x[: fit.own], fit.terms, noise.at(fit.predicted)
    basis, residual = projected(fit)
    wide = basis
    if problem.nuisance is not None:
        smooth = noise.whiten(problem.nuisance)
        smooth = np.vstack([smooth, np.zeros((len(basis) - len(smooth), smooth.shape[1]))])
        wide = orthonormal(np.hstack([basis, smooth]))
    found: list[Signature] = []
    for effect in effects:
        for form in effect.forms:
            if any(one.effect is effect and form.enriches(one.form.name) for one in found):
                continue
            for probe in form.probes:
                value = problem.predict(own, {**terms, effect.id: (form.name, np.array(probe))})
                if not np.all(np.isfinite(value)):
                    continue
                total, left = beside(basis, noise.whiten(value - fit.by_model))
                length = float(left @ left)
                seen = length > _VISIBLE * total or (
                    length > _TOLD * total and np.sqrt(length) * _begins(form, probe) > _STANDS_OUT
                )
                if not seen or length <= 1e-16:
                    continue
                size = float(np.sqrt(length))
                z = float(left @ residual) / size
                robust = z
                if effect.smooth and wide is not basis:
                    bare = left - wide @ (wide.T @ left)
                    rest = float(bare @ bare)
                    robust = float(bare @ residual) / np.sqrt(rest) if rest > 1e-3 * length else 0.0
                found.append(Signature(effect, form, probe, left / size, length / total, size, z, robust))
    return found


def beside(basis: Array, imprint: Array) -> tuple[float, Array]:
    """Return the square of a whitened ``imprint`` on the readings, and what of it the ``basis`` cannot imitate."""
    whole = np.zeros(len(basis))
    whole[: len(imprint)] = imprint
    return float(whole @ whole), whole - basis @ (basis.T @ whole)


def _begins(form: Form, probe: tuple[float, ...]) -> float:
    """Return how many times as large as a probe an effect is where a fit of it begins."""
    away = np.array(probe) - np.array(form.null)
    moved = away != 0.0
    starts = np.array(form.starts)[:, moved] - np.array(form.null)[moved]
    return float(np.max(np.abs(starts / away[moved]))) if np.any(moved) else 0.0


def points_at(signature: Signature) -> float:
    """Return the score: how far the residual lies along the signature, 0 where it lies the impossible way."""
    first = signature.form.constants[0]
    both = first.low < first.value < first.high
    return abs(signature.robust_z) if both else max(signature.robust_z, 0.0)


def greatest_by_chance(found: list[Signature], noise: Noise) -> float:
    """Return the probability that noise alone gives a score as great as the greatest of ``found``.

    The look-elsewhere effect is counted: many entries, alike as they are. The draws have a fixed seed; the
    noise level is itself known with degrees of freedom only.
    """
    if not found:
        return 1.0
    seen = max(abs(signature.z) for signature in found)
    bound = float(len(found) * erfc(seen / np.sqrt(2.0)))
    if bound < _CLEAR and noise.dof > 30.0:
        return bound
    directions = np.stack([signature.direction for signature in found])
    alike = directions @ directions.T
    values, vectors = np.linalg.eigh(alike)
    root = vectors * np.sqrt(np.maximum(values, 0.0))
    random = np.random.default_rng(20240607)
    draws = np.abs(random.standard_normal((_DRAWS, len(found))) @ root.T).max(axis=1)
    if np.isfinite(noise.dof):
        draws = draws * np.sqrt(noise.louder(random.chisquare(noise.dof, _DRAWS)))
    return float((1 + np.sum(draws >= seen)) / (1 + _DRAWS))


def projected(fit: Fit) -> tuple[Array, Array]:
    """Return an orthonormal basis of the own sensitivities with the priors as extra rows, and the residual so too."""
    root = np.sqrt(fit.prior)
    basis = orthonormal(np.vstack([fit.jacobian, np.diag(root)]))
    # At the optimum the residual with its prior rows is orthogonal to the basis; held bounds leave a little.
    residual = np.concatenate([fit.residual, np.zeros(len(root))])
    return basis, residual - basis @ (basis.T @ residual)
