"""What an effect on the stress may ride on."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from hyperfab.materials.effects.path import Path
from hyperfab.materials.kinematics import Array


@dataclass(frozen=True)
class State:
    """The rows of all tests once the law has answered.

    path            how specimens were led
    stretch         (n,) of the specimen itself: play is taken up, a set has lengthened it
    energy          (n,) of the law there [MPa], 0 where no effect asks for it
    reference_degC  the temperature that the law's constants are of
    rate            (n,) strain rate of each test [1/s], nan where unknown
    quick           how many times as fast the material's own clock runs up to each row: (n,), or 1
    """

    path: Path
    stretch: Array
    energy: Array
    reference_degC: float
    rate: Array | None
    quick: Array | float = 1.0

    @cached_property
    def greatest(self) -> Array:
        """The largest energy so far (n,)."""
        found = np.empty_like(self.energy)
        for rows in self.path.curves:
            found[rows] = np.maximum.accumulate(self.energy[rows])
        return found

    @cached_property
    def pace(self) -> float:
        """The usual strain rate of the tests [1/s]."""
        speed = np.abs(self.path.speed)
        return float(np.exp(np.mean(np.log(speed[speed > 0.0])))) if np.any(speed > 0.0) else 1.0

    @cached_property
    def usual_rate(self) -> float:
        """The mean of the stated strain rates [1/s], geometric."""
        assert self.rate is not None
        known = self.rate[np.isfinite(self.rate)]
        return float(np.exp(np.mean(np.log(known))))


#: A form of an effect on the stress: of the state, the stress (n,) [MPa] before it and the form's constants.
Acts = Callable[[State, Array, Array], Array]
