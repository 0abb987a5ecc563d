"""A load cell that does not read zero at rest."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from hyperfab.materials.effects.grip_slack import by_curve, of_each
from hyperfab.materials.effects.path import Acts, Path, State
from hyperfab.materials.effects.smooth import through
from hyperfab.materials.law import Array


def shifted(stress: Array, offset: float | Array, time: Array | None = None, drift: float = 0.0) -> Array:
    """Return ``stress + offset + drift time``: offset in the stress's unit, drift in it per second.

    >>> import numpy as np
    >>> shifted(np.array([0.0, 1.0]), 0.01)
    array([0.01, 1.01])
    """
    return stress + offset if time is None else stress + offset + drift * time


def settling(time: Array, drift: float, tau: float) -> Array:
    """Return what an amplifier that warms up adds: ``drift tau (1 - exp(-time/tau))``, first ``drift`` per second.

    >>> import numpy as np
    >>> float(settling(np.array([0.0]), 0.1, 5.0)[0])
    0.0
    """
    return np.asarray(-drift * tau * np.expm1(-time / tau))


def drifting_each(path: Path, values: Array, tau: float = np.inf) -> Array:
    """Return an offset of each curve that drifts as it goes on: evenly, or less and less by the time ``tau`` [s].

    ``values``: as those of ``of_each``, then by how much each has moved at its end. A curve beyond those told has the
    mean of both.
    """
    start, moved = np.split(values, 2)
    times = np.concatenate([_passed(path.time_s[rows], tau) for rows in path.curves])
    return of_each(path, start) + by_curve(path, moved) * times


def _passed(time: Array, tau: float) -> Array:
    """Return how far what settles by ``tau`` has come of where it is at the end of a test, 0 to 1."""
    since, whole = time - time[0], float(np.ptp(time))
    if whole <= 0.0:
        return np.zeros_like(time)
    return np.asarray(since / whole if np.isinf(tau) else np.expm1(-since / tau) / np.expm1(-whole / tau))


#: Forms that have no prediction where the tests state no times.
IN_TIME = ("drift", "settling", "each-drift", "each-settling", "smooth")


def _as_force(acts: Acts) -> Acts:
    """Return a form of what the cell is off as a force: as stress in the first specimen whose section is stated."""

    def act(at: State, stress: Array, values: Array) -> Array:
        found = acts(at, stress, values)
        return found if at.path.thinner is None else stress + (found - stress) * at.path.thinner

    return act


_FORMS: Mapping[str, Acts] = {
    "constant": lambda at, stress, values: shifted(stress, values[0]),
    "drift": lambda at, stress, values: shifted(stress, values[0], at.path.time_s, values[1]),
    "settling": lambda at, stress, values: shifted(stress, values[0] + settling(at.path.time_s, values[1], values[2])),
    "each": lambda at, stress, values: shifted(stress, of_each(at.path, values)),
    "each-drift": lambda at, stress, values: shifted(stress, drifting_each(at.path, values)),
    "each-settling": lambda at, stress, values: shifted(stress, drifting_each(at.path, values[:-1], values[-1])),
    "smooth": lambda at, stress, values: shifted(stress, values[1] + through(at.path.time_s / values[0], values[2:])),
}
#: What each form makes of the stress.
FORMS: Mapping[str, Acts] = {name: _as_force(acts) for name, acts in _FORMS.items()}


def added(path: Path, form: str, values: Array) -> Array:
    """Return what a form adds to the stress of each row."""
    nothing = np.zeros(len(path.stretch))
    return FORMS[form](State(path, path.stretch, nothing, 0.0, None), nothing, values)
