"""When the straight line is left for samples: figures that bend where the first one does not."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pytest

from hyperfab.chapters.job import Job
from hyperfab.chapters.rerun import Listener, Overlay
from hyperfab.chapters.uncertainty.carry import Answer, Carried, Changes, Slopes
from hyperfab.chapters.uncertainty.sources import Origin, Origins, Setting
from hyperfab.numerics.propagation import Source


@dataclass(frozen=True)
class Case:
    """What a command carries with, of a case: no way was asked for."""

    uncertainty: None = None


@pytest.mark.parametrize(
    ("work", "method", "blur"),
    [
        (lambda x, y: 2.0 * y, "linear", 0.0),
        # The larger of two, at the first of them: seen neither where the force is up nor where the first one is.
        (lambda x, y: max(y, -1.5 * y), "sampled", 0.0),
        (
            lambda x, y: y**3 + y,
            "sampled",
            0.0,
        ),  # as much below as above: the middle of two runs shows nothing
        (lambda x, y: 1.0 + abs(y), "sampled", 0.0),
        (lambda x, y: 1.0 + abs(y), "sampled", 3.9),
        (lambda x, y: 1.0 + abs(y), "linear", 4.0),  # by twice 1.96, less than it errs by itself
    ],
)
def test_a_figure_that_bends_where_the_first_one_does_not_is_sampled(
    work: Callable[[float, float], float], method: str, blur: float
) -> None:
    """The first figure goes straight with x alone, the other is asked along what it goes with itself."""

    class Beside:
        samples, step, undrawn = 400, 1.0, {}  # type: ignore[var-annotated]

        def blur(self, name: str) -> float:
            return blur

        def gradient(self) -> Slopes:
            step = 1e-6
            along = np.array([0.0, (work(0, step) - work(0, 0)) / step])
            return Slopes({"force_N": np.array([1.0, 0.0]), "energy_J": along})

        def at(self, changes: Changes) -> Answer:
            x, y = (float(changes[k][0]) for k in (0, 1))
            return Answer({"force_N": 10.0 + x, "energy_J": work(x, y)})

    known = Origins([Origin(Source(name, np.eye(1)), (Setting(name),), (name,)) for name in "xy"])
    value = {"force_N": 10.0, "energy_J": work(0.0, 0.0)}
    found = (
        Carried(Job("fabric-contact", (), Listener(), Overlay({})), Case(), "contact", known, value, Beside())
        .run()
        .uncertainty
    )  # type: ignore[arg-type]
    assert found is not None
    assert found.method == method
