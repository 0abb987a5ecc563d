"""A sphere on a round neo-Hookean membrane by shooting: a second way to the numbers, with a clamp that gives, mounted
slack, with friction.

On the sphere the meridian is known and the tension follows from the balance along it; beyond the edge of contact the
balance along r and z is integrated to the rim. The stretch at the pole and the edge of contact are sought so that the
rim lies where it is held. The sheet carries no compression, and slips towards the rim all over the sphere; MPa, mm, N.
"""

from __future__ import annotations

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq, fsolve

_START = 1e-4


def pressed_disc(
    depth: float,
    *,
    c10: float = 0.2,
    radius: float = 40.0,
    rim: float = 100.0,
    thickness: float = 1.0,
    rim_slip: float = 0.0,
    prestretch: float = 1.0,
    friction: float = 0.0,
    guess: tuple[float, float] = (1.2, 25.0),
) -> tuple[float, float, float]:
    """Return the force [N], the radius [mm] to which the rim has crept, and the energy [N mm] of sheet and clamp."""
    scale = 2.0 * c10 * thickness

    def width(one: float, two: float) -> float:
        return max(two, one**-0.5)

    def along(one: float, two: float) -> float:
        two = width(one, two)
        return scale * (one - one**-3 * two**-2)

    def across(one: float, two: float) -> float:
        two = width(one, two)
        return scale * (two - two**-3 * one**-2)

    def stretch(force: float, two: float) -> float:
        return brentq(lambda one: along(one, two) - force, 0.2, 20.0, xtol=1e-14, rtol=1e-14)

    def energy(one: float, two: float) -> float:
        two = width(one, two)
        return 0.5 * scale * (one**2 + two**2 + (one * two) ** -2 - 3.0)

    def on_sphere(place: float, state: np.ndarray) -> list[float]:
        angle, force, _ = state
        two = radius * np.sin(angle) / place
        one = stretch(force / place, two)
        pressed = force * one / radius + across(one, two) * np.sin(angle)
        return [one / radius, across(one, two) * np.cos(angle) + friction * pressed, energy(one, two) * place]

    def free(place: float, state: np.ndarray, push: float) -> list[float]:
        r, _, flat, _ = state
        two = r / place
        force = np.hypot(flat, push)
        one = stretch(force / place, two)
        return [one * flat / force, -one * push / force, across(one, two), energy(one, two) * place]

    def shot(unknown: np.ndarray) -> tuple[float, float, float, float, float]:
        pole, edge = unknown
        start = [pole * _START / radius, along(pole, pole) * _START, 0.0]
        inner = solve_ivp(on_sphere, (_START, edge), start, method="DOP853", rtol=1e-11, atol=1e-13).y[:, -1]
        angle, force, stored = inner
        push = force * np.sin(angle)
        begin = [radius * np.sin(angle), radius * np.cos(angle) - radius, force * np.cos(angle), stored]
        outer = solve_ivp(free, (edge, rim), begin, args=(push,), method="DOP853", rtol=1e-11, atol=1e-13).y[:, -1]
        r, z, flat, stored = outer
        return r, z, flat / rim, 2 * np.pi * push, 2 * np.pi * stored

    def misfit(unknown: np.ndarray) -> list[float]:
        r, z, pull, _, _ = shot(unknown)
        return [r - (prestretch * rim - rim_slip * pull), z + depth]

    found, _, worked, words = fsolve(misfit, guess, xtol=1e-12, full_output=True)
    assert worked == 1, words
    r, _, pull, force, stored = shot(found)
    return force, r, stored + np.pi * rim * rim_slip * pull**2
