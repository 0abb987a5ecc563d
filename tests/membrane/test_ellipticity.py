"""Loss of ellipticity: closed forms, and paths that end where one-dimensional solutions say so."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from hyperfab.materials import bind
from hyperfab.membrane import outline
from hyperfab.membrane.ellipticity import acoustic
from hyperfab.membrane.equilibrium import NoEquilibriumError, Press
from hyperfab.membrane.path import Footing, cold_start
from hyperfab.membrane.sphere_contact import SphereTest, rough_path
from hyperfab.membrane.tension_field import IsotropicSheet

#: Fitted to Treloar's uniaxial test alone: stiff where it is stretched both ways, until it gives way to shear.
STIFF = {
    "C10_MPa": -0.8991704211792658,
    "C01_MPa": 1.273431698279646,
    "C11_MPa": -0.08984471474793986,
    "C20_MPa": 0.01273247299197521,
    "C02_MPa": 0.45207092830631856,
}


def _strain(one, two, angle=0.0):
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c * c * one**2 + s * s * two**2, s * s * one**2 + c * c * two**2, c * s * (one**2 - two**2)]])


@pytest.mark.parametrize(("one", "two"), [(1.0001, 1.0001), (1.3, 0.95), (2.0, 1.5)])
def test_a_neo_hookean_sheet_is_elliptic_by_its_modulus(one, two):
    law, strain = IsotropicSheet(bind("neo-hookean", {"C10_MPa": 0.2})), _strain(one, two, 0.4)
    assert acoustic(law(strain), strain)[0] == pytest.approx(0.4, rel=1e-9)


@pytest.mark.parametrize("stretch", [1.05, 1.1, 1.12])
def test_equal_stretches_give_way_in_shear(stretch):
    """The Baker-Ericksen condition in the limit of equal stretches: A11 - A12 + P / stretch."""
    material = bind("mooney-rivlin-5", STIFF)
    law, strain = IsotropicSheet(material), _strain(stretch, stretch)
    found = material.membrane(np.array([stretch]), np.array([stretch]))
    expected = 0.5 * (found.A11[0] - found.A12[0] + found.P1[0] / stretch)
    assert acoustic(law(strain), strain)[0] == pytest.approx(expected, rel=1e-6)


def test_turned_axes_change_nothing():
    law = IsotropicSheet(bind("mooney-rivlin-5", STIFF))
    least = [acoustic(law(strain), strain)[0] for strain in (_strain(1.16, 0.98), _strain(1.16, 0.98, 0.7))]
    assert least[1] == pytest.approx(least[0], rel=1e-3)


@pytest.mark.slow
def test_a_path_ends_where_the_stretch_gathers_in_bands():
    """By shooting, the pole reaches the stretch 1.1134 at 72.47 mm, 166.8 N; the round shape goes on smoothly."""
    law = IsotropicSheet(bind("mooney-rivlin-5", STIFF))
    _, path = rough_path(SphereTest(outline.Disc(100.0, quarter=True), law, 1.0, 40.0), [35.0, 70.0, 80.0])
    assert path.limit is not None
    assert path.limit.bands is not None
    assert path.limit.depth == pytest.approx(72.47, abs=0.5)
    assert np.hypot(*path.limit.bands.at) < 10.0
    assert np.mean(path.limit.bands.stretches) == pytest.approx(1.1134, abs=2e-3)
    assert path.limit.turning_point is None
    assert not path.jumps
    assert "bands" in path.limit.reason


def test_constants_that_gather_stretch_almost_from_rest_are_told_before_a_careful_start(monkeypatch):
    """Hundreds of careful steps a depth found nothing either: the film over the sphere is beyond ellipticity."""
    careful, plain = [], Press.equilibrium

    def watched(self, depth, *given, **how):
        careful.append(how.get("careful", False))
        return plain(self, depth, *given, **how)

    monkeypatch.setattr(Press, "equilibrium", watched)
    law = IsotropicSheet(bind("mooney-rivlin-2", {"C10_MPa": -0.195, "C01_MPa": 0.1951}))
    _, path = rough_path(SphereTest(outline.Disc(100.0, quarter=True), law, 1.0, 40.0), [7.5, 60.0])
    assert not any(careful)
    assert path.limit is not None
    assert path.limit.bands is not None
    assert 1.0 < path.limit.bands.stretches[0] < 1.01
    assert "bands" in path.limit.reason
    assert not path.states


def test_a_path_that_only_halves_its_steps_is_given_up(monkeypatch):
    """Each equilibrium is found from a tenth of a millimetre away alone: no end would come in sight."""
    law = IsotropicSheet(bind("neo-hookean", {"C10_MPa": 0.2}))
    tried = []

    def shy(press, below, depth):
        tried.append(depth)
        if below is not None and depth - below.state.depth > 0.1:
            raise NoEquilibriumError("too far")
        return Footing(replace(below.state, depth=depth) if below else cold_start(press, depth), 1.0)

    monkeypatch.setattr("hyperfab.membrane.path.next_footing", shy)
    _, path = rough_path(SphereTest(outline.Disc(100.0, quarter=True), law, 1.0, 40.0), [10.0, 60.0])
    assert len(tried) < 120
    # What lies at the depth asked for is then found from nothing, and the gap is named.
    assert path.limit is None
    ((start, end),) = path.jumps
    assert 10.0 < start < 20.0
    assert end == 60.0
