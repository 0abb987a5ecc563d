"""Stress that relaxes with time: linear viscosity on top of the elastic law."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from hyperfab.materials.effects.path import Acts, Path, State, second_stretch
from hyperfab.materials.effects.smooth import through
from hyperfab.materials.effects.ways import each_way
from hyperfab.materials.law import Array
from hyperfab.numerics.kernels import inlined, kernel

#: Steps of a branch in series for each of its times, and between two rows at most.
_STEPS, _MOST_STEPS = 6.0, 64


def relaxing(
    path: Path,
    stress: Array,
    weights: Sequence[float],
    times_s: Sequence[float],
    quick: Array | float = 1.0,
) -> Array:
    """Return the stress of Maxwell branches beside the elastic one: ``sum g_k int exp(-(t-s)/tau_k) dP(s)``.

    ``stress`` is the relaxed elastic stress at each row, taken linear in time between rows; the material's own clock
    goes ``quick`` times as fast. Quasi-linear viscoelasticity: Fung (1981), Biomechanics, ch. 7; recursion of Taylor,
    Pister & Goudreau (1970), doi:10.1002/nme.1620020106.
    """
    change, begins = _steps(path, stress)
    elapsed = np.ascontiguousarray(path.waited * quick)
    branches = np.array([*zip(weights, times_s, strict=True)], float).reshape(-1, 2)
    found: Array = _relaxing(change, elapsed, begins, branches)
    return found


@kernel
def _relaxing(change, elapsed, begins, branches):  # type: ignore[no-untyped-def]
    total = np.zeros_like(change)
    for weight, time in branches:
        if weight == 0.0:
            continue
        q = 0.0
        for i in range(len(change)):
            ratio = elapsed[i] / time
            fall = -np.expm1(-ratio)
            share = fall / ratio if ratio > 1e-9 else 1.0
            q = (0.0 if begins[i] else (1.0 - fall) * q) + weight * share * change[i]
            total[i] += q
    return total


def _steps(path: Path, stress: Array) -> tuple[Array, NDArray[np.bool_]]:
    """Return what a quantity (n,) or (n, k) changes by up to each row, from nothing where a test begins, and which rows
    begin one."""
    begins = np.zeros(len(stress), dtype=np.bool_)
    begins[list(path.starts[:-1])] = True
    change = np.empty_like(stress)
    np.subtract(stress[1:], stress[:-1], out=change[1:])
    change[begins] = stress[begins]
    return change, begins


def relaxing_bent(
    path: Path,
    stress: Array,
    weights: Sequence[float],
    times_s: Sequence[float],
    bend: float,
    quick: Array | float = 1.0,
) -> Array:
    """Return the stress of Maxwell branches driven by ``stress stretch^bend``: they stiffen or weaken.

    At ``bend`` 0 that of ``relaxing``; with a negative one the branch follows the strain rather than the stress.
    Simo (1987), doi:10.1016/0045-7825(87)90107-1: an energy of its own for the overstress.
    """
    return relaxing(path, stress * path.stretch**bend, weights, times_s, quick)


def relaxing_measured(
    path: Path, stress: Array, weights: Sequence[float], times_s: Sequence[float], measure: float
) -> Array:
    """Return the stress of Maxwell branches whose memory is of another stress measure, ``stress stretch^measure``.

    1 is the true stress, -1 the second Piola-Kirchhoff stress of Simo (1987), doi:10.1016/0045-7825(87)90107-1; at 0
    that of ``relaxing``.
    """
    scale = path.stretch**measure
    return relaxing(path, stress * scale, weights, times_s) / scale


def resisting(path: Path, size: float, power: float, pace: float) -> Array:
    """Return the stress of a dashpot beside the elastic law: ``size sign(v) |v/pace|^power`` at the strain rate v.

    Kelvin and Voigt's at ``power`` 1, dry friction at 0: Ostwald (1925), doi:10.1007/BF01431449, for the power.

    >>> import numpy as np
    >>> from hyperfab.materials.effects.path import uniaxial_pull
    >>> from dataclasses import replace
    >>> pull = replace(uniaxial_pull(np.array([1.0, 1.1, 1.2])), time_s=np.array([0.0, 1.0, 2.0]))
    >>> resisting(pull, 0.3, 1.0, 0.1).round(12)
    array([0. , 0.3, 0.3])
    """
    speed = path.speed
    return np.asarray(size * np.sign(speed) * np.maximum(np.abs(speed) / pace, 1e-9) ** power)


def thinning(path: Path, stress: Array, weight: float, tau_s: float, flow: float) -> Array:
    """Return the stress of a Maxwell branch whose dashpot thins: ``dq = g dP - (flow/tau) sinh(q/flow) dt``.

    Eyring (1936), doi:10.1063/1.1749836. At rest the branch decays so that ``tanh(q/(2 flow))`` falls exponentially,
    which each step obeys exactly, half before and half after what the stress adds. A large ``flow`` is ``relaxing``.
    """
    change, begins = _steps(path, stress)
    keep = np.exp(-0.5 * path.waited / tau_s)
    found: Array = _thinning(weight * change, keep, begins, float(flow))
    return found


def flowing(
    path: Path, stress: Array, weight: float, tau_s: float, power: float, size: float, strain: float = 0.0
) -> Array:
    """Return the stress of a Maxwell branch whose dashpot flows with a power of its stress and of the strain.

    ``dq = g dP - (q/tau) (|q|/size)^(power - 1) (e + 0.05)^strain dt``: Norton's law; with ``strain`` below zero the
    chains reptate less the more they are stretched, Bergstrom & Boyce (1998), doi:10.1016/S0022-5096(97)00075-6. At
    ``power`` 1 and ``strain`` 0 that of ``relaxing``. Each step flows half before and half after what the stress adds.
    """
    change, begins = _steps(path, stress)
    pace = 0.5 * path.waited / tau_s * (np.maximum(path.stretch - 1.0, 0.0) + 0.05) ** strain
    found: Array = _flowing(weight * change, pace, begins, float(power) - 1.0, float(size))
    return found


def stretched_in_series(at: State, moduli: Sequence[float], times_s: Sequence[float]) -> Array:
    """Return the nominal stress (n,) [MPa] of neo-Hookean springs, each in series with a dashpot that flows far.

    The stretch of a branch is that of its spring times that of its dashpot, whose logarithm grows by the deviatoric
    stress over twice the viscosity, ``modulus time``: Reese & Govindjee (1998), doi:10.1016/S0020-7683(97)00217-5.
    For small strains that of ``relaxing``.

    >>> import numpy as np
    >>> from dataclasses import replace
    >>> from hyperfab.materials.effects.path import uniaxial_pull
    >>> pull = replace(uniaxial_pull(np.array([1.0, 2.0, 2.0])), time_s=np.array([0.0, 1e-6, 1e6]))
    >>> state = State(pull, pull.stretch, 0.0 * pull.stretch, 20.0, None)
    >>> stretched_in_series(state, [0.4], [10.0]).round(3)
    array([0. , 0.7, 0. ])
    """
    total = np.zeros_like(at.stretch)
    for modulus, tau in zip(moduli, times_s, strict=True):
        if modulus:
            total += modulus * _spring(at, float(tau))
    return total


def _spring(at: State, tau_s: float) -> Array:
    """Return the nominal stress (n,) over the modulus of one spring in series with its dashpot.

    It asks for no stress: what law and modulus are has no say in it.
    """

    def followed() -> tuple[Array]:
        path, first = at.path, at.stretch
        second = second_stretch(path.mode, first, first**-0.5, path.across)
        change, begins = _steps(path, np.log(np.stack([first, second], axis=1)))
        return (_in_series(change, np.ascontiguousarray(path.waited * at.quick), begins, tau_s) / first,)

    [found] = at.kept.of(("in series", tau_s, np.asarray(at.quick).tobytes()), followed)
    return np.asarray(found)


@kernel
def _in_series(change, elapsed, begins, tau):  # type: ignore[no-untyped-def]
    """The true stress (n,) over the modulus of a branch, from what the logarithmic strains (n, 2) change by."""
    found = np.empty(len(change))
    x = y = 0.0
    for i in range(len(change)):
        dx, dy = change[i]
        if begins[i]:
            x = y = 0.0
        ratio = elapsed[i] / tau
        # A spring that is stretched far relaxes faster.
        far = min(max(abs(x), abs(y), abs(x + y)) + max(abs(dx), abs(dy), abs(dx + dy)), 2.0)
        steps = min(int(_STEPS * ratio * np.exp(2.0 * far)) + 1, _MOST_STEPS)
        h = ratio / steps
        if h > 1.0:
            # Beside so long a time all is flow, at an even pace.
            x, y = dx / ratio, dy / ratio
        else:
            dx, dy = dx / steps, dy / steps
            for _ in range(steps):
                a1, b1 = _pace(x, y, dx, dy, h)
                a2, b2 = _pace(x + 0.5 * a1, y + 0.5 * b1, dx, dy, h)
                a3, b3 = _pace(x + 0.5 * a2, y + 0.5 * b2, dx, dy, h)
                a4, b4 = _pace(x + a3, y + b3, dx, dy, h)
                x += (a1 + 2.0 * a2 + 2.0 * a3 + a4) / 6.0
                y += (b1 + 2.0 * b2 + 2.0 * b3 + b4) / 6.0
        found[i] = np.exp(2.0 * x) - np.exp(-2.0 * (x + y))
    return found


@inlined
def _pace(x, y, dx, dy, h):  # type: ignore[no-untyped-def]
    one, other, third = np.exp(2.0 * x), np.exp(2.0 * y), np.exp(-2.0 * (x + y))
    mean = (one + other + third) / 3.0
    return dx - 0.5 * h * (one - mean), dy - 0.5 * h * (other - mean)


@kernel
def _flowing(change, pace, begins, above, size):  # type: ignore[no-untyped-def]
    found = np.empty_like(change)
    q, drive, since = 0.0, 0.0, 0.0
    for i in range(len(change)):
        # What flows after one change and before the next is one flow: exact for a dashpot of that power at rest.
        q = 0.0 if begins[i] else _left(q, drive, since + pace[i], above)
        q += change[i]
        drive = (abs(q) / size) ** above if above >= 1e-6 else 1.0
        since = pace[i]
        found[i] = _left(q, drive, since, above)
    return found


@kernel
def _left(q, drive, pace, above):  # type: ignore[no-untyped-def]
    if q == 0.0:
        return q
    if above < 1e-6:
        return q * np.exp(-pace)
    return q / (1.0 + above * pace * drive) ** (1.0 / above)


@kernel
def _thinning(change, keep, begins, flow):  # type: ignore[no-untyped-def]
    found = np.empty_like(change)
    q = 0.0
    for i in range(len(change)):
        if begins[i]:
            q = 0.0
        for half in range(2):
            q = 2.0 * flow * np.arctanh(keep[i] * np.tanh(0.5 * q / flow))
            if half == 0:
                q += change[i]
        found[i] = q
    return found


def spectrum(at: State, stress: Array, values: Array) -> Array:
    """Return the stress with Maxwell branches at times spread evenly, in logarithm, from the first to the last.

    ``values`` are these two times [s], the power of the stretch with which the branches stiffen, how much the clock of
    the material quickens with strain (all times are shorter by ``exp(quick strain)``), and the share of each branch:
    the spectrum of relaxation by a few values. Ferry (1980), Viscoelastic Properties of Polymers, chs. 3 and 11.
    """
    first, last, bend, quick = values[:4]
    times = np.geomspace(first, last, len(values) - 4)
    clock = at.quick * np.exp(quick * (at.path.stretch - 1.0))
    return stress + relaxing_bent(at.path, stress, list(values[4:]), list(times), bend, clock)


def quickened(speed: Array, reference: float, amount: float) -> Array:
    """Return the factor ``1 + amount ln(speed/reference)`` of a strain-rate hardening law on the strain rate [1/s].

    The logarithmic law of Johnson & Cook (1983) for short ranges of rate.

    >>> quickened(np.array([0.1]), 0.1, 0.05)
    array([1.])
    """
    return np.asarray(1.0 + amount * np.log(np.maximum(speed, 1e-12) / reference))


def quickening(temperature: Array, reference: float, shift: float, fall: float) -> Array:
    """Return by how much all relaxation is faster than at the ``reference`` [degC]: ``exp(shift dT/(1 + dT/fall))``.

    The shift of Williams, Landel & Ferry (1955), doi:10.1021/ja01619a008: ``shift`` [1/K] is ln 10 C1/C2, ``fall`` [K]
    their C2. With the absolute temperature of the reference for ``fall`` it is that of Arrhenius.

    >>> import numpy as np
    >>> energy, gas, cold = 80e3, 8.314, 293.15  # J/mol, J/(mol K), K
    >>> hot = quickening(np.array([60.0]), 20.0, energy / (gas * cold**2), cold)
    >>> bool(np.isclose(hot[0], np.exp(energy / gas * (1 / cold - 1 / 333.15))))
    True
    """
    rise = np.where(np.isfinite(temperature), temperature - reference, 0.0)
    return np.asarray(np.exp(np.clip(shift * rise / np.maximum(1.0 + rise / fall, 0.05), -60.0, 60.0)))


def _shifted(acts: Acts) -> Acts:
    """Return a form whose times are those of the material's own clock; the shift's two constants come last."""

    def found(at: State, stress: Array, values: Array) -> Array:
        quick = quickening(at.path.temperature_degC, at.reference_degC, *values[-2:])
        return acts(replace(at, quick=quick), stress, values[:-2])

    return found


def _maxwell(at: State, stress: Array, values: Array) -> Array:
    return stress + relaxing(at.path, stress, list(values[0::2]), list(values[1::2]), at.quick)


def _maxwell_bent(at: State, stress: Array, values: Array) -> Array:
    branches = np.delete(values, 2)
    own = list(branches[0::2]), list(branches[1::2])
    return stress + relaxing_bent(at.path, stress, *own, values[2], at.quick)


def _maxwell_measure(at: State, stress: Array, values: Array) -> Array:
    branches = np.delete(values, 2)
    return stress + relaxing_measured(at.path, stress, list(branches[0::2]), list(branches[1::2]), values[2])


def _flow(at: State, stress: Array, values: Array) -> Array:
    return stress + flowing(at.path, stress, *values)


def _log_rate(at: State, stress: Array, values: Array) -> Array:
    assert at.rate is not None
    return stress * quickened(at.rate, at.usual_rate, values[0])


def _log_rate_smooth(at: State, stress: Array, values: Array) -> Array:
    """Return the stress times a smooth function of the logarithm of the strain rate, 1 at the slowest.

    ``values`` are the slowest and fastest rate [1/s], and what is more at thirds of the way between.
    """
    assert at.rate is not None
    slowest, fastest = values[:2]
    along = np.log(np.maximum(at.rate, 1e-12) / slowest) / np.log(fastest / slowest)
    return stress * (1.0 + through(along, values[2:]))


def _thinning_beside(at: State, stress: Array, values: Array) -> Array:
    found = stress + thinning(at.path, stress, *values[:3])
    return found + relaxing(at.path, stress, [values[3]], [values[4]])


def _thinning_driven(at: State, stress: Array, values: Array) -> Array:
    return stress + thinning(at.path, stress * at.path.stretch ** values[3], *values[:3])


#: What each form makes of the stress.
FORMS: Mapping[str, Acts] = {
    "prony-1": _maxwell,
    "prony-2": _maxwell,
    "prony-3": _maxwell,
    "prony-bent": _maxwell_bent,
    "prony-2-bent": _maxwell_bent,
    "prony-3-bent": _maxwell_bent,
    "prony-measure": _maxwell_measure,
    "prony-2-measure": _maxwell_measure,
    "thinning": lambda at, stress, values: stress + thinning(at.path, stress, *values[:3]),
    "thinning-prony": _thinning_beside,
    "thinning-bent": _thinning_driven,
    "flow": _flow,
    "flow-strain": _flow,
    "finite": lambda at, stress, values: stress + stretched_in_series(at, [values[0]], [values[1]]),
    "finite-2": lambda at, stress, values: stress + stretched_in_series(at, list(values[::2]), list(values[1::2])),
    "smooth": spectrum,
    "smooth-each-way": each_way(spectrum),
    "prony-1-shifted": _shifted(_maxwell),
    "prony-2-shifted": _shifted(_maxwell),
    "prony-3-shifted": _shifted(_maxwell),
    "prony-2-bent-shifted": _shifted(_maxwell_bent),
    "prony-3-bent-shifted": _shifted(_maxwell_bent),
    "smooth-shifted": _shifted(spectrum),
    "viscous": lambda at, stress, values: stress + resisting(at.path, values[0], values[1], at.pace),
    "log-rate": _log_rate,
    "log-rate-smooth": _log_rate_smooth,
}
