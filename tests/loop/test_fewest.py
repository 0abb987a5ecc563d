"""Which model is given where none leaves noise."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from hyperfab.loop import fewest


def model(name: str, surprise: float, left: float, of_each: bool = False) -> Any:
    fit = SimpleNamespace(left=left, forms={name: SimpleNamespace(of_each=of_each)})
    return SimpleNamespace(ids=(name,), fit=fit, surprise=surprise)


@pytest.mark.parametrize(
    ("left", "of_each", "given"),
    [
        # A slack of each specimen takes up how stiff these are, which counts for much, and no curve.
        (12.8, True, "rate"),
        (3.5, True, "grip-slack"),
        (12.8, False, "grip-slack"),
    ],
)
def test_what_each_specimen_has_of_its_own_comes_no_nearer_where_it_leaves_more_of_the_curves(
    monkeypatch: pytest.MonkeyPatch, left: float, of_each: bool, given: str
) -> None:
    monkeypatch.setattr(fewest, "surprise", lambda one: one.surprise)
    monkeypatch.setattr(fewest, "structured", lambda fit, problem, noise: fit.left)
    monkeypatch.setattr(fewest, "_pays", lambda search, one: True)
    whole = model("anisotropy", 48.9, 4.0)
    alone = [model("grip-slack", 36.3, left, of_each), model("rate", 40.0, 3.0), model("mullins", 48.5, 3.9)]
    search: Any = SimpleNamespace(problem=None, noise=None)
    found = fewest._nearer(search, whole, whole, alone, lambda one: True)
    assert found is not None
    assert found.ids == (given,)
    assert fewest._nearer(search, whole, whole, alone[2:], lambda one: True) is None
