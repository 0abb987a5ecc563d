"""An entry that says that a document is wrong, beside a constant of the model that may be wrong as well."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
import pytest

from hyperfab.arrays import Array, Ints
from hyperfab.loop.engine import close
from hyperfab.loop.known import FilesProblem
from hyperfab.loop.noise import Noise
from hyperfab.loop.problem import Constant, Curve, Effect, Form
from hyperfab.loop.scatter import Guess

SD = 0.02
X = np.linspace(0.0, 1.0, 60)
#: Of the readings, and of what is known of the depth.
NOISE = Noise(np.append(np.full(len(X), SD), 1.0), 100.0, "stated")


@dataclass(frozen=True)
class Part:
    """Readings at places."""

    name: str
    at: Array
    values: Array
    index: Ints | None = None
    kind: str = "place"

    def guess(self, predicted: Array) -> Guess:
        return Guess(SD, 100.0, "")


def depth(x: Array) -> Array:
    return x


def size(x: Array) -> Array:
    return x + 0.2 * x**2


def other(x: Array) -> Array:
    return np.sin(7.0 * x)


@dataclass
class Lines(FilesProblem[Part]):
    """A depth that is known to 0.1, and a size that is drawn."""

    shapes: dict[str, object] = field(default_factory=dict, kw_only=True)

    def shown(self, own: Array, terms: Mapping[str, tuple[str, Array]]) -> list[Array]:
        amount = sum(float(values[0]) for _, values in terms.values())
        return [own[0] * depth(one.at) + amount * self.shapes["size"](one.at) for one in self.every]  # type: ignore[operator]


def posed(truth: Array, shape: object = size, of_document: bool = True) -> Lines:
    """Return the problem of readings of a truth in four files."""
    values = truth + SD * np.random.default_rng(3).standard_normal(len(X))
    rows = [np.arange(k, len(X), 4) for k in range(4)]
    parts = [Part(f"{k}.csv", X[one], values[one]) for k, one in enumerate(rows)]
    ends = np.cumsum([0, *map(len, rows)])
    curves = [Curve(part.name, a, b, part.at) for part, a, b in zip(parts, ends[:-1], ends[1:], strict=True)]
    drawn = Constant("larger", 0.0, -2.0, 2.0, 0.01)
    entry = Effect("size", "", "", "", (Form("all ways", (drawn,), ((0.1,), (-0.1,)), ((0.01,),)),))
    known = [Constant("depth", 0.0, -5.0, 5.0, 0.1, 0.1)]
    effects = (replace(entry, of_document=of_document),)
    return Lines.posed(parts, curves, known, (), effects=effects, shapes={"size": shape})


@pytest.mark.parametrize("of_document", [True, False])
def test_a_depth_that_is_further_off_than_is_known_is_not_a_size_for_sure(of_document: bool) -> None:
    """The depth is four of its sd off; held at three it leaves what a size does about as well. Physics
    that the model lacks cannot hide in a number that nobody would believe."""
    found = close(posed(0.4 * depth(X), of_document=of_document), noise=NOISE)
    assert found.after.ids == ("size",)
    assert (found.verdict, found.indistinguishable) == (
        ("ambiguous", [["size", "depth"]]) if of_document else ("effect", [])
    )


def test_a_size_that_no_depth_explains_is_sure() -> None:
    """The depth is driven to its end here too, and further off it explains no more."""
    found = close(posed(0.15 * depth(X) - 0.6 * other(X), other), noise=NOISE)
    assert (found.verdict, found.after.ids, found.indistinguishable) == ("effect", ("size",), [])


def test_a_constant_may_be_three_times_as_far_off_as_it_is_held() -> None:
    problem = posed(X)
    assert problem.loosened(np.array([0.2])) is None
    loose = problem.loosened(np.array([0.3]))
    assert loose is not None
    assert (loose.own[0].low, loose.own[0].high) == pytest.approx((-0.9, 0.9))
    assert loose.predict(np.array([0.6]), {})[-1] == pytest.approx(2.0)
