"""The constants in which the law of a whole sheet is linear: its ground, and its threads one by one."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from hyperfab.arrays import Array
from hyperfab.materials.orthotropic.energy import LINEAR, Orthotropic
from hyperfab.materials.orthotropic.specimen import Along

#: The constants of the ground, which are one, and the others, with the angle [deg] of the strip that shows each most
#: (of an inclined pair its own); the stretch at which it does.
GROUND, _OF_GROUND = "ground", LINEAR[:4]
THREADS = dict(zip(LINEAR[4:], (0.0, 90.0, 45.0, 45.0), strict=True))
_PULLED = 1.1


def shares_of_threads(parameters: Mapping[str, float], names: Sequence[str]) -> Array:
    """Return by how much of itself each constant (n,) changes where what a strip along it bears changes by one share.

    It is 1 but of threads in a ground, which bear a part of that: slopes of the stress at a stretch of 1.1.

    >>> found = shares_of_threads({"C10_MPa": 0.05, "k1_warp_MPa": 0.02}, ["ground", "k1_warp_MPa"])
    >>> [bool(one > 3.0) for one in found], float(found[0])
    ([False, True], 1.0)
    """
    found = np.ones(len(names))
    law = Orthotropic.of(parameters)
    ways = {**THREADS, "k1_bias_MPa": law.parameters["bias_deg"]}
    for index, name in enumerate(names):
        if name in ways:
            bare = Orthotropic({**law.parameters, name: 0.0})
            all_of_it, rest = (float(Along(one, ways[name]).uniaxial([_PULLED]).A[0]) for one in (law, bare))
            found[index] = all_of_it / (all_of_it - rest)
    return found


def sheet_times(parameters: Mapping[str, float], factors: Mapping[str, float], *, turned: bool) -> dict[str, float]:
    """Return the constants of a whole sheet's law times ``factors``, keyed by a constant or ``ground``; of one
    ``turned`` by a quarter, as it is seen along the weft.

    >>> sheet_times({"C10_MPa": 0.05, "k1_warp_MPa": 0.02}, {"ground": 2.0}, turned=False)["C10_MPa"]
    0.1
    """
    law = Orthotropic.of(parameters)
    plain = (law.turned() if turned else law).parameters
    ground = factors.get(GROUND, 1.0)
    changed = Orthotropic(
        {key: value * factors.get(key, ground if key in _OF_GROUND else 1.0) for key, value in plain.items()}
    )
    return dict((changed.turned() if turned else changed).parameters)
