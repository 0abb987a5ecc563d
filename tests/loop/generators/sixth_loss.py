"""What the way and the clock take of the sixth set's stresses: damage, friction, flow. Units: MPa, s."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
from loop.generators.sixth_energy import Array, Table

#: The numbers of an effect, None where the fabric lacks it.
Draws = Mapping[str, float] | None


def most_so_far(x: Array) -> Array:
    """Return the greatest so far."""
    return np.asarray(np.maximum.accumulate(x))


def less_amplified(d: Draws, own: Array) -> Array:
    """Return the stretch that the law is asked at: Mullins of kind 1.

    Stiff clusters make the strain between them greater, until they break (Klüppel & Schramm 2000). The plain law is
    what a first pull shows, the breaking in it.
    """
    if d is None or int(d["kind"]) != 1:
        return own
    most, now = (
        1.0 - d["amount"] * (1.0 - (1.0 + (one - 1.0) / (0.1 + 0.3 * d["u"])) ** -(1.0 + 2.0 * d["v"]))
        for one in (most_so_far(own), own)
    )
    return 1.0 + (own - 1.0) * most / now


def damage(d: Draws, own: Array, still: Table, top: float) -> Array:
    """Return what a stretch before has left of the stress of a first pull.

    Kind 0: chains of many lengths, which come off for good as they are drawn taut (Govindjee & Simo 1991).
    Kind 1: see ``less_amplified``.
    Kind 2: by the root of the greatest energy (Simo, Comput. Methods Appl. Mech. Eng. 60 (1987) 153).
    """
    if d is None or int(d["kind"]) == 1:
        return np.ones_like(own)
    if d["kind"] > 1:
        steps = 0.5 * (still.stress[1:] + still.stress[:-1]) * np.diff(still.stretch)
        energy = np.interp(own, still.stretch, np.concatenate([[0.0], np.cumsum(steps)]))
        sizes = (np.sqrt(one / top) / (0.06 + 0.15 * d["u"]) + 1e-9 for one in (energy, most_so_far(energy)))
        now, worst = (1.0 - d["amount"] * (1.0 + np.expm1(-one) / one) for one in sizes)
        return worst / now
    taut = np.linspace(1.03, 2.2, 160)
    share = np.exp(-0.5 * (np.log((taut - 1.0) / (0.2 + 0.25 * d["u"])) / 0.7) ** 2) / (taut - 1.0)
    share /= 4.0 * np.sum(share)
    x = np.minimum(0.8 * own[:, None] / taut, 0.8) ** 2
    bears = share * (3.0 - x) / (1.0 - x)
    now, worst = (
        1.0 / d["amount"] - 1.0 + np.sum(bears * np.clip((taut - one[:, None]) / 0.01 + 0.5, 0.0, 1.0), axis=1)
        for one in (own, most_so_far(own))
    )
    return worst / now


def friction(d: Draws, own: Array, p: Array, top: float) -> Array:
    """Return what is lost whatever the rate [MPa].

    Kind 0: Valanis's endochronic time: a singular memory of the way, not of the clock (Valanis & Fan 1983).
    Kind 1: yarns that stick on springs and slide at a power of the load (Howell's law; Gupta & El-Mogahzy 1991).
    Kind 2: crystals that come with stretch and melt later than they came; chains in them do not pull (Flory 1947).
    The plain law is the way up, with the crystals that come.
    """
    if d is None:
        return np.zeros_like(own)
    steps = np.diff(own)
    if d["kind"] < 1:
        lengths, found = 0.004 * 2.2 ** np.arange(6), [0.0]
        weights, state = lengths ** -(0.3 + 0.4 * d["u"]), np.zeros(6)
        for step in steps:
            fade = np.exp(-abs(step) / lengths)
            state = state * fade + math.copysign(1.0, step) * lengths * (1.0 - fade)
            found.append(float(weights @ state))
        pressed = 0.15 + 0.5 * d["v"] + p / top
        return d["amount"] * top * pressed * np.array(found) / float(weights @ lengths)
    if d["kind"] < 2:
        length, power, found = 0.012 + 0.03 * d["u"], 0.6 + 0.3 * d["v"], [0.0]
        limits, states = 0.5 * d["amount"] * (np.maximum(p, 0.0) / top) ** power, [0.0, 0.0]
        for step, limit in zip(steps, limits[1:], strict=True):
            for k, far in enumerate((length, 4.0 * length)):
                states[k] = min(max(states[k] + 0.5 * d["amount"] * step / far, -limit), limit)
            found.append(states[0] + states[1])
        return top * np.array(found)
    begins, wide, gap = 1.03 + 0.1 * d["u"], 0.25 + 0.25 * d["v"], 0.08 + 0.1 * d["w"]
    least, most = (np.maximum((own - begins + more) / wide, 0.0) ** 2 for more in (0.0, gap))
    least, most = (one / (1.0 + one) for one in (least, most))
    crystals, found = 0.0, [0.0]
    for low, high in zip(least[1:], most[1:], strict=True):
        crystals = min(max(crystals, low), high)
        found.append(crystals)
    return p * ((1.0 - d["amount"] * np.array(found)) / (1.0 - d["amount"] * least) - 1.0)


def flow(d: Draws, own: Array, p: Array, t: Array, top: float) -> Array:
    """Return what depends on the rate [MPa].

    Kind 0: a memory of the plain stress that fades as a hyperbola of the time (Peleg 1979), by rates that are
    distributed as gamma has it.
    Kind 1: a spring that pulls with the square of its strain, on a dashpot (Vangheluwe, Text. Res. J. 62 (1992) 586).
    Kind 2: a dashpot that the pace of late has made thin (Haupt & Sedlan, Arch. Appl. Mech. 71 (2001) 89).
    Kind 3: a stress by the pace of the moment and the stretch (Pioletti et al. 1998), thinner if quick (Carreau).
    """
    if d is None:
        return np.zeros_like(own)
    strains, waits, found = np.diff(np.log(own)), np.diff(t), [0.0]
    if d["kind"] < 1:
        rates = np.geomspace(3e-3, 8.0, 14)
        weights, beats = rates * np.exp(-rates), np.outer(waits, rates) / 10.0 ** (0.5 + 1.3 * d["u"])
        fades, state = np.exp(-beats), np.zeros(14)
        for fade, gain, step in zip(fades, (1.0 - fades) / beats, np.diff(p), strict=True):
            state = state * fade + gain * step
            found.append(float(weights @ state))
        return 1.5 * d["amount"] * np.array(found) / float(np.sum(weights))
    x, lately, slow = 0.0, 0.0, 10.0 ** (1.1 + 1.2 * d["u"])
    if d["kind"] > 2:
        paces = np.concatenate([[0.0], strains / waits])
        grows = paces / (0.02 * (1.0 + (np.abs(paces) / 10.0 ** (-3.5 + d["u"])) ** (0.55 + 0.2 * d["v"])))
        return 2.0 * d["amount"] * top * (own**2 + 2.0 / own - 3.0) * grows
    for step, dt in zip(strains, waits, strict=True):
        if d["kind"] < 2:
            pace, tried = dt / slow / 0.1, x + step
            x = math.copysign((math.sqrt(1.0 + 4.0 * pace * abs(tried)) - 1.0) / (2.0 * pace), tried)
            found.append(x * abs(x) / 0.1)
        else:
            lately += (abs(step) / dt - lately) * -math.expm1(-dt / (5.0 + 25.0 * d["v"]))
            x = (x + step) / (1.0 + dt / slow * (0.2 + 60.0 * lately))
            found.append(x)
    return 4.0 * d["amount"] * top * np.array(found) / own
