"""The account of the heat: what came, went, was stored, and what is missing, in size."""

from __future__ import annotations

import numpy as np
import pytest

from hyperfab.thermal.history import Ledger


@pytest.mark.parametrize("joule", [1e-6, 1.0, 1e6])
def test_what_is_missing_is_told_over_the_heat_turned_over_in_any_unit(joule):
    """10 J in, 4 J out, 5 J stored: 1 J is missing after the second step, of 14 J that passed."""
    ledger = Ledger(["heater", "film"], np.array([True, False]), np.zeros(2, bool), 100.0 * joule)
    ledger.add(joule * np.array([6.0, -1.0]), joule * np.array([105.0]), 0.0)
    ledger.add(joule * np.array([4.0, -3.0]), joule * np.array([105.0]), 0.0)
    assert ledger.supplied() == pytest.approx(10.0 * joule)
    assert ledger.supplied(1) == pytest.approx(6.0 * joule)
    assert ledger.lost() == pytest.approx(4.0 * joule)
    assert ledger.imbalance() == pytest.approx(1.0 / 14.0)


def test_a_held_face_supplies_while_it_gives_heat_and_loses_while_it_takes_it():
    ledger = Ledger(["face", "film"], np.zeros(2, bool), np.array([True, False]), 0.0)
    ledger.add(np.array([9.0, -1.0]), 8.0, 0.0)
    ledger.add(np.array([-3.0, -2.0]), 3.0, 0.0)
    assert (ledger.supplied(), ledger.lost()) == (9.0, 6.0)
    assert (ledger.supplied(1), ledger.lost(1)) == (9.0, 1.0)
    assert ledger.imbalance() == 0.0


@pytest.mark.parametrize("steps", [0, 3])
def test_a_body_that_nothing_is_done_to_has_an_account_too(steps):
    """No heater, film or held face: heat moves between its parts alone."""
    ledger = Ledger([], np.zeros(0, bool), np.zeros(0, bool), 0.0)
    for _ in range(steps):
        ledger.add(np.zeros(0), 0.0, 7.0)
    assert (ledger.supplied(), ledger.lost(), ledger.by_condition, ledger.imbalance()) == (0.0, 0.0, {}, 0.0)
    assert ledger.supplied(1) == ledger.lost(1) == 0.0
