"""A stiffness that changes with temperature."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from hyperfab.materials.effects.path import Acts, State
from hyperfab.materials.effects.smooth import through
from hyperfab.materials.law import Array


def factor(temperature: Array, reference: float, softening: float, curvature: float = 0.0) -> Array:
    """Return ``exp(-softening dT - curvature dT^2)``, dT [K] above ``reference``: a first-order softening
    of all moduli.

    Where the curvature would turn the law round it stays as it is there: what softens does not stiffen again.
    ``softening`` [1/K] may be negative (entropic elasticity stiffens with temperature). Ferry (1980), Viscoelastic
    Properties of Polymers, ch. 11 (vertical shift).

    >>> factor(np.array([20.0]), 20.0, 0.01)
    array([1.])
    >>> factor(np.array([50.0, 90.0]), 0.0, 0.02, -0.0002)
    array([0.60653066, 0.60653066])
    """
    rise = temperature - reference
    if curvature:
        turn = -0.5 * softening / curvature
        rise = np.minimum(rise, turn) if turn > 0.0 else np.maximum(rise, turn)
    return np.asarray(np.exp(-softening * rise - curvature * rise**2))


def towards_glass(
    temperature: Array, reference: float, softening: float, step: float, at: float, width: float
) -> Array:
    """Return ``factor`` of a polymer that stiffens in the cold by ``exp(step)`` some ``width`` [K] about ``at`` [degC].

    A logistic step of the logarithm of the stiffness, 1 at the ``reference``: Mahieux & Reifsnider (2001), Polymer 42,
    3281, doi:10.1016/S0032-3861(00)00614-5, for one transition.

    >>> towards_glass(np.array([-200.0, 20.0]), 20.0, 0.0, np.log(100.0), -30.0, 1.0).round(6)
    array([100.,   1.])
    """

    def frozen(degrees: Array) -> Array:
        return np.asarray(0.5 * (1.0 - np.tanh(0.5 * (degrees - at) / width)))

    moved = frozen(np.asarray(temperature)) - frozen(np.array(reference))
    return np.asarray(np.exp(step * moved - softening * (temperature - reference)))


def with_strain(at: State, stress: Array, values: Array) -> Array:
    """Return the stress of a fabric that softens otherwise at another strain.

    ``P exp(-dT (softening + more(e/reach)) - curvature dT^2)``: ``values`` are the reach, softening [1/K], curvature
    [1/K2] and what is ``more`` [1/K] at halves of the reach.
    """
    reach, softening, curvature = values[:3]
    rise = at.path.temperature_degC - at.reference_degC
    more = through(np.maximum(at.path.stretch - 1.0, 0.0) / reach, values[3:])
    return np.asarray(stress * np.exp(-rise * (softening + more) - curvature * rise**2))


def by_heat(at: State, stress: Array, values: Array) -> Array:
    """Return the stress of a fabric whose stiffness is a smooth function of temperature, and otherwise at another
    strain.

    ``P exp(softened(T0) - softened(T) - dT more(e/reach))``, T0 the reference: ``values`` are the reach, the coldest
    and the hottest [degC], what is ``more`` [1/K] at halves of the reach, and ``softened`` at even parts of the way
    from the coldest to the hottest, 0 at the first. A stiffness of each temperature tested: ISO 6721-1.
    """
    reach, cold, hot = values[:3]

    def softened(degrees: Array) -> Array:
        return through((degrees - cold) / (hot - cold), values[5:])

    degrees = at.path.temperature_degC
    more = through(np.maximum(at.path.stretch - 1.0, 0.0) / reach, values[3:5])
    fallen = softened(degrees) - softened(np.array([at.reference_degC])) + (degrees - at.reference_degC) * more
    return np.asarray(stress * np.exp(-fallen))


#: The law of each form: of the temperature, the reference and the form's constants.
LAWS: Mapping[str, Callable[..., Array]] = {"exponential": factor, "curved": factor, "glass": towards_glass}


def _acts(law: Callable[..., Array]) -> Acts:
    return lambda at, stress, values: stress * law(at.path.temperature_degC, at.reference_degC, *values)


#: What each form makes of the stress.
FORMS: Mapping[str, Acts] = {form: _acts(law) for form, law in LAWS.items()} | {
    "smooth": with_strain,
    "smooth-heat": by_heat,
}
