"""Which constants are stresses is one truth: whatever scales a sheet's stiffness scales its stress, for every law."""

from __future__ import annotations

import numpy as np
import pytest
from laws.constants import CONSTANTS

from hyperfab.chapters.close_loop.contact import _known
from hyperfab.chapters.close_loop.softening import linear_of, scaled_material, soften, widths
from hyperfab.documents.material import AtTemperature, Direction, MaterialDocument
from hyperfab.materials import bind, laws
from hyperfab.materials.effects.anisotropy import FORMS
from hyperfab.materials.effects.fabric import Fabric
from hyperfab.materials.effects.path import uniaxial_pull
from hyperfab.materials.law import scaled
from hyperfab.materials.orthotropic import Orthotropic
from hyperfab.materials.orthotropic.specimen import Along

FIBRES = {"fabric-fibres": (0.1, 0.05, 0.02, 0.4, 0.3)}
NAMES = sorted(laws())
ISOTROPIC = sorted(name for name, law in laws().items() if law.isotropic)
L1, L2 = np.array([1.3, 0.8, 1.6]), np.array([1.1, 1.5, 0.7])


def constants(name: str) -> dict[str, float]:
    return dict(zip(laws()[name].names, {**CONSTANTS, **FIBRES}[name], strict=True))


def stresses(name: str, parameters: dict[str, float]) -> np.ndarray:
    found = bind(name, parameters, anisotropic=True).membrane(L1, L2)
    return np.array([found.P1, found.P2, found.A11, found.A12, found.A22, found.W])


@pytest.mark.parametrize("name", NAMES)
def test_scaled_constants_scale_energy_stress_and_tangent(name: str) -> None:
    plain = constants(name)
    np.testing.assert_allclose(stresses(name, scaled(plain, 0.37)), 0.37 * stresses(name, plain), rtol=1e-13)


@pytest.mark.parametrize("name", ISOTROPIC)
def test_a_scaled_document_scales_each_direction_at_each_temperature(name: str) -> None:
    plain = constants(name)
    row = AtTemperature(temperature_degC=80.0, parameters=plain)
    way = Direction(parameters=plain, temperatures=[row])
    document = MaterialDocument(
        model=name, parameters=plain, temperatures=[row], directions={"warp": way, "weft": way.model_copy(deep=True)}
    )  # fmt: skip
    scaled = scaled_material(document, {"warp": 0.5, "weft": 0.8})
    assert scaled.directions is not None
    for direction, factor in (("warp", 0.5), ("weft", 0.8)):
        for degrees in (None, 80.0):
            found = scaled.constants(direction, degrees)
            np.testing.assert_allclose(stresses(name, found), factor * stresses(name, plain), rtol=1e-13)


def test_a_scaled_sheet_is_one_law_seen_along_both_ways() -> None:
    """Of a whole sheet's law the ground and the threads are scaled, and its directions are that law again."""
    plain = {"C10_MPa": 0.05, "C30_MPa": 0.01, "k1_warp_MPa": 0.02, "k2_warp": 0.2, "G_MPa": 0.03, "nu": 0.4}
    law = Orthotropic.of(plain)
    ways = {"warp": law, "weft": law.turned()}
    document = MaterialDocument(
        model="orthotropic",
        parameters=dict(law.parameters),
        directions={way: Direction(parameters=dict(seen.parameters)) for way, seen in ways.items()},
    )
    names, scales = linear_of(document)
    assert (names, scales) == (("ground", "k1_warp_MPa", "G_MPa"), (True, True, True))
    found = scaled_material(document, {"ground": 0.8, "k1_warp_MPa": 2.5})
    wanted = Orthotropic.of(plain | {"C10_MPa": 0.04, "C30_MPa": 0.008, "k1_warp_MPa": 0.05})
    assert found.directions is not None
    assert found.parameters == pytest.approx(wanted.parameters)
    assert found.directions["warp"].parameters == pytest.approx(wanted.parameters)
    assert found.directions["weft"].parameters == pytest.approx(wanted.turned().parameters)
    # As far off as a tenth of what bears along the warp: threads bear a part of it.
    wide = widths("orthotropic", plain, names)
    stiffer = Orthotropic.of(plain | {"k1_warp_MPa": 0.02 * (1.0 + 0.1 * wide[1])})
    slopes = [float(Along(one, 0.0).uniaxial([1.1]).A[0]) for one in (law, stiffer)]
    assert wide[0] == 1.0
    assert slopes[1] == pytest.approx(1.1 * slopes[0], rel=0.02)


@pytest.mark.parametrize("name", ISOTROPIC)
def test_softening_is_written_as_the_stress_it_was_found_in(name: str) -> None:
    """What the loop predicts with the effect, and what the constants it writes say at each temperature, agree."""
    plain, values = constants(name), [0.004, 1e-5]
    document = MaterialDocument(model=name, parameters=plain)
    soften(document, values, 20.0, [60.0, 100.0], "curved")
    lam = np.linspace(1.05, 1.6, 5)
    for degrees in (20.0, 60.0, 100.0):
        path = uniaxial_pull(lam)
        path.temperature_degC[:] = degrees
        own = np.array([plain[key] for key in laws()[name].names])
        predicted = Fabric(laws()[name], path, 20.0).stress(
            own, None, {"thermal-softening": ("curved", np.array(values))}
        )
        written = bind(name, document.constants(temperature_degC=degrees)).uniaxial(lam).P
        np.testing.assert_allclose(written, predicted, rtol=1e-12)


@pytest.mark.parametrize("name", ISOTROPIC)
def test_a_ratio_of_directions_is_written_as_the_stress_it_was_found_in(name: str) -> None:
    plain = constants(name)
    weft = FORMS["ratio"].weft(laws()[name], plain, np.array([0.6]))
    np.testing.assert_allclose(stresses(name, weft), 0.6 * stresses(name, plain), rtol=1e-13)


@pytest.mark.parametrize("name", ISOTROPIC)
def test_softening_a_document_knows_is_read_off_its_stiffness(name: str) -> None:
    plain = constants(name)
    document = MaterialDocument(model=name, parameters=plain)
    soften(document, [0.01], 20.0, [20.0, 60.0], "exponential")
    np.testing.assert_allclose(_known(document, np.array([20.0, 60.0]), 20.0), [1.0, np.exp(-0.4)], rtol=1e-12)


def test_a_softening_smooth_in_heat_is_written_at_each_temperature_met() -> None:
    """From 20 to 80 degC by exp(-0.6); at 50 degC, half way, by what it is told there."""
    document = MaterialDocument(model="yeoh-3", parameters=constants("yeoh-3"))
    soften(document, [0.8, 20.0, 80.0, 0.0, 0.0, 0.4, 0.6], 20.0, [50.0, 80.0], "smooth-heat")
    assert document.temperatures is not None
    first = document.temperatures[0].parameters
    for row, factor in zip(document.temperatures, (1.0, np.exp(-0.4), np.exp(-0.6)), strict=True):
        for name, value in first.items():
            assert row.parameters[name] == pytest.approx(factor * value, rel=1e-6)
