"""The fifth set of fabrics is what it says: finite, repeatable, of a size that is seen, and cloth as cloth can be."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from loop.blind import case, problem_of, shown
from loop.generators import fifth_fabric
from loop.generators.fabric import IDS
from loop.generators.fifth_energy import LAWS, Cloth, table

#: Nothing that is tested daily is drawn from it.
pytestmark = pytest.mark.slow

CASES = [
    (effect, kind)
    for effect, count in {**fifth_fabric.KINDS, **dict.fromkeys(fifth_fabric.OUTSIDE, 1)}.items()
    for kind in range(count)
]
MODES = ("uniaxial", "shear", "biaxial")
CLOTHS = [
    Cloth(law, (0.5, u, 1.0 - u), sharp=sharp) for law in LAWS for u in (0.0, 0.5, 1.0) for sharp in (False, True)
]


def test_every_effect_of_the_other_sets_has_two_ways_or_more() -> None:
    assert set(fifth_fabric.KINDS) == set(IDS)
    assert min(fifth_fabric.KINDS.values()) >= 2


@pytest.mark.parametrize(("effect", "kind"), CASES)
def test_every_kind_is_finite_repeatable_and_seen(effect: str, kind: int) -> None:
    truth, same = (fifth_fabric.draw(np.random.default_rng([kind, len(effect)]), [effect], kind) for _ in range(2))
    setups = [replace(one, points=20) for one in fifth_fabric.protocol(np.random.default_rng(2))]
    reads, again, plain = (
        fifth_fabric.measure(one, setups, np.random.default_rng(1), 0.0)
        for one in (truth, same, replace(truth, effects=()))
    )
    top = max(read.stress.max() for read in plain)
    gap = np.concatenate([one.stress - other.stress for one, other in zip(reads, plain, strict=True)])
    assert all(np.array_equal(one.stress, two.stress) for one, two in zip(reads, again, strict=True))
    assert 0.01 < np.sqrt(np.mean(gap**2)) / top < 0.6
    for read in reads:
        assert np.isfinite(read.stress).all()
        assert read.stress.min() >= 0.0
        assert (np.diff(read.time) > 0.0).all()
        if read.transverse is not None:
            assert 0.0 < read.transverse.min() <= read.transverse.max() < 1.05
        if effect != "stitch-run":
            assert (np.diff(read.stress[:21]) > -1e-9 * top).all(), "softens while it is first drawn"


@pytest.mark.parametrize("cloth", CLOTHS, ids=lambda one: f"{one.law}-{one.numbers[1]}-{one.sharp}")
@pytest.mark.parametrize("mode", MODES)
def test_a_plain_law_stiffens_from_rest_and_keeps_its_volume(cloth: Cloth, mode: str) -> None:
    found = table(cloth, mode, 0.0, 1.65)
    assert found.stress[0] == pytest.approx(0.0, abs=1e-9)
    assert (np.diff(found.stress) > 0.0).all()
    assert found.stretch * found.width * found.thickness == pytest.approx(1.0)
    if mode == "uniaxial":
        assert found.width == pytest.approx(found.stretch**-0.5, abs=1e-6)


@pytest.mark.parametrize("kind", range(2))
@pytest.mark.parametrize("u", [0.2, 0.8])
def test_a_cloth_of_yarns_is_stiffer_along_the_warp(kind: int, u: float) -> None:
    cloth = Cloth("tube", (0.5, 0.5, 0.5), yarns={"kind": float(kind), "u": u, "amount": 0.05})
    warp, bias, weft = (table(cloth, "uniaxial", angle, 1.6) for angle in (0.0, 45.0, 90.0))
    assert warp.stress[-1] > 1.03 * weft.stress[-1]
    for one in (warp, bias, weft):
        assert (np.diff(one.stress) > 0.0).all()
        assert one.stretch * one.width * one.thickness == pytest.approx(1.0)


@pytest.mark.parametrize("kind", range(2))
@pytest.mark.parametrize("u", [0.2, 0.8])
@pytest.mark.parametrize("mode", MODES)
def test_a_cloth_with_pores_swells_as_poissons_ratio_allows(kind: int, u: float, mode: str) -> None:
    cloth = Cloth("recruitment", (0.5, 0.5, 0.5), pores={"kind": float(kind), "u": u, "amount": 0.3})
    found = table(cloth, mode, 0.0, 1.6)
    volume = found.stretch * found.width * found.thickness
    assert (np.diff(found.stress) > 0.0).all()
    assert (np.diff(volume) > 0.0).all()
    if mode == "uniaxial":
        ratio = -np.log(found.width[1:]) / np.log(found.stretch[1:])
        assert 0.05 < ratio.min() <= ratio.max() < 0.5
        assert found.width == pytest.approx(found.thickness, abs=1e-6)


def test_noise_is_of_the_sd_asked_for_and_grows_with_the_load() -> None:
    truth = fifth_fabric.draw(np.random.default_rng(3), [])
    setups = fifth_fabric.protocol(np.random.default_rng(4))
    reads, clean = (fifth_fabric.measure(truth, setups, np.random.default_rng(5), sd) for sd in (0.003, 0.0))
    gap = np.concatenate([one.stress - other.stress for one, other in zip(reads, clean, strict=True)])
    load = np.concatenate([one.stress for one in clean])
    assert np.std(gap) == pytest.approx(0.003, rel=0.05)
    assert np.std(gap[load > np.quantile(load, 0.9)]) > 1.3 * np.std(gap[load < np.median(load)])


def test_no_other_mode_is_tested() -> None:
    with pytest.raises(ValueError, match="tested in torsion"):
        table(CLOTHS[0], "torsion", 0.0, 1.5)


@pytest.mark.parametrize(("effect", "kind"), CASES)
def test_a_trial_shows_its_effect_by_half_the_noise_or_more(effect: str, kind: int) -> None:
    _, noise, truth, setups = case(kind, (effect,), poor=False, which="fifth")
    assert truth.draws[effect]["kind"] == kind
    clean = problem_of(
        fifth_fabric.measure(truth, setups, np.random.default_rng(0), 0.0),
        "neo-hookean" if effect == "elastic-law" else "yeoh-3",
    )
    assert shown(clean, noise) >= 1.5
