"""The sixth set of fabrics is what it says: finite, repeatable, of a size that is seen, and cloth as cloth can be."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from loop.blind import case, problem_of, shown
from loop.generators import sixth_fabric
from loop.generators.fabric import IDS, Reading, Setup
from loop.generators.sixth_energy import LAWS, Cloth, modulus, table

#: Nothing that is tested daily is drawn from it.
pytestmark = pytest.mark.slow

CASES = [
    (effect, kind)
    for effect, count in {**sixth_fabric.KINDS, **dict.fromkeys(sixth_fabric.OUTSIDE, 1)}.items()
    for kind in range(count)
]
MODES = ("uniaxial", "shear", "biaxial")
CLOTHS = [
    Cloth(law, (0.5, u, 1.0 - u), sharp=sharp) for law in LAWS for u in (0.0, 0.5, 1.0) for sharp in (False, True)
]
STRAIN = {"uniaxial": 3.0, "shear": 4.0, "biaxial": 6.0}


def _drawn(effect: str, kind: int, seed: int = 0) -> sixth_fabric.Truth:
    return sixth_fabric.draw(np.random.default_rng([kind, len(effect), seed]), [effect], kind)


def test_every_effect_of_the_other_sets_has_two_ways_or_more() -> None:
    assert set(sixth_fabric.KINDS) == set(IDS)
    assert min(sixth_fabric.KINDS.values()) >= 2
    assert len(sixth_fabric.OUTSIDE) == 2


@pytest.mark.parametrize(("effect", "kind"), CASES)
@pytest.mark.parametrize("seed", range(3))
def test_every_kind_is_finite_repeatable_and_seen(effect: str, kind: int, seed: int) -> None:
    truth, same = (_drawn(effect, kind, seed) for _ in range(2))
    setups = sixth_fabric.protocol(np.random.default_rng([2, seed]))
    # The turns are stored here, so that what is read last of a first loading is its end.
    setups = [replace(one, stores_turns=True) for one in setups if isinstance(one, sixth_fabric.Run)]
    reads, again, plain = (
        sixth_fabric.measure(one, setups, np.random.default_rng(1), 0.0)
        for one in (truth, same, replace(truth, effects=()))
    )
    top = max(read.stress.max() for read in plain)
    gap = np.concatenate([one.stress - other.stress for one, other in zip(reads, plain, strict=True)])
    assert all(np.array_equal(one.stress, two.stress) for one, two in zip(reads, again, strict=True))
    assert np.sqrt(np.mean(gap**2)) / top > 0.005
    if effect != "elastic-law":  # which is another law altogether
        assert np.sqrt(np.mean(gap**2)) / top < 0.4
    for read in reads:
        assert np.isfinite(read.stress).all()
        assert read.stress.min() >= (-0.5 * top if effect == "load-offset" else 0.0)
        assert (np.diff(read.time) > 0.0).all()
        if read.transverse is not None:
            assert 0.5 < read.transverse.min() <= read.transverse.max() < 1.02
        if effect not in sixth_fabric.OUTSIDE:
            first = read.stress[: 1 + int(np.argmax(read.stretch >= read.setup.turns[0] - 1e-9))]
            assert len(first) > 5
            assert (np.diff(first) > -1e-3 * top).all(), "softens while it is first drawn"


@pytest.mark.parametrize("cloth", CLOTHS, ids=lambda one: f"{one.law}-{one.numbers[1]}-{one.sharp}")
@pytest.mark.parametrize("mode", MODES)
def test_a_plain_law_rises_from_rest_with_its_modulus_and_keeps_its_volume(cloth: Cloth, mode: str) -> None:
    found = table(cloth, mode, 0.0, 1.55 if mode == "uniaxial" else 1.4)
    assert found.stress[0] == pytest.approx(0.0, abs=1e-9)
    assert (np.diff(found.stress) > 0.0).all()
    start = found.stress[1] / (found.stretch[1] - 1.0)
    assert start == pytest.approx(STRAIN[mode] * modulus(cloth), rel=0.03)
    assert found.stretch * found.width * found.thickness == pytest.approx(1.0)
    if mode == "uniaxial":
        assert found.width == pytest.approx(found.stretch**-0.5, abs=1e-6)


@pytest.mark.parametrize("kind", range(3))
@pytest.mark.parametrize("u", [0.2, 0.8])
@pytest.mark.parametrize("w", [0.2, 0.8])
def test_a_cloth_of_yarns_is_stiffer_along_the_stronger_ones(kind: int, u: float, w: float) -> None:
    cloth = Cloth("separable", (0.5, 0.5, 0.5), yarns={"kind": float(kind), "u": u, "v": 0.5, "w": w, "amount": 0.05})
    warp, bias, weft = (table(cloth, "uniaxial", angle, 1.5) for angle in (0.0, 45.0, 90.0))
    strong, weak = (warp, weft) if w < 0.67 else (weft, warp)
    assert strong.stress[-1] > 1.03 * weak.stress[-1]
    for one in (warp, bias, weft):
        assert (np.diff(one.stress) > 0.0).all()
        assert one.stretch * one.width * one.thickness == pytest.approx(1.0)


@pytest.mark.parametrize("kind", range(2))
@pytest.mark.parametrize("amount", [0.1, 0.5])
@pytest.mark.parametrize("mode", MODES)
def test_a_cloth_with_pores_swells_as_poissons_ratio_allows(kind: int, amount: float, mode: str) -> None:
    cloth = Cloth("exp-log", (0.5, 0.5, 0.5), pores={"kind": float(kind), "u": 0.5, "amount": amount})
    found = table(cloth, mode, 0.0, 1.5)
    volume = found.stretch * found.width * found.thickness
    assert (np.diff(found.stress) > 0.0).all()
    assert (np.diff(volume) > 0.0).all()
    if mode == "uniaxial":
        ratio = -np.log(found.width[1:]) / np.log(found.stretch[1:])
        assert 0.05 < ratio.min() <= ratio.max() < 0.5
        assert found.width == pytest.approx(found.thickness, abs=1e-6)


CYCLES = sixth_fabric.Run(turns=(1.4, 1.0, 1.4, 1.0), rate=0.01, temperature=20.0, step=0.5)


def _read(truth: sixth_fabric.Truth, setup: Setup = CYCLES) -> Reading:
    [read] = sixth_fabric.measure(truth, [setup], np.random.default_rng(0), 0.0)
    return read


def _work(read: Reading) -> float:
    """Return what a closed way takes [MPa]."""
    return float(np.sum(0.5 * (read.stress[1:] + read.stress[:-1]) * np.diff(read.stretch)))


@pytest.mark.parametrize("kind", range(3))
@pytest.mark.parametrize("seed", range(3))
def test_a_loop_takes_work_and_knows_no_rate(kind: int, seed: int) -> None:
    truth = _drawn("hysteresis", kind, seed)
    slow = _read(truth)
    fast = _read(truth, replace(CYCLES, rate=0.1, step=0.05))
    assert _work(slow) > 0.002 * truth.top
    assert fast.stress == pytest.approx(slow.stress, abs=1e-9)


@pytest.mark.parametrize("kind", range(4))
@pytest.mark.parametrize("seed", range(3))
def test_a_flow_takes_work_and_knows_the_rate(kind: int, seed: int) -> None:
    truth = _drawn("rate", kind, seed)
    slow, fast = _read(truth), _read(truth, replace(CYCLES, rate=0.1, step=0.05))
    assert min(_work(slow), _work(fast)) > 0.0
    assert np.max(fast.stress) > 1.005 * np.max(slow.stress)


@pytest.mark.parametrize("kind", range(3))
@pytest.mark.parametrize("seed", range(3))
def test_a_pull_softens_what_lies_below_it_and_nothing_else(kind: int, seed: int) -> None:
    truth = _drawn("mullins", kind, seed)
    read, plain = _read(truth), _read(replace(truth, effects=()))
    first, again = slice(0, 80), slice(165, 230)
    assert read.stress[first] == pytest.approx(plain.stress[first], abs=1e-9)
    assert (read.stress[again] < 0.995 * plain.stress[again]).all()
    # Below the greatest stretch there is one way only, up and down.
    assert read.stress[161:240] == pytest.approx(read.stress[159:80:-1], rel=1e-6, abs=1e-9)


@pytest.mark.parametrize("kind", range(3))
@pytest.mark.parametrize("seed", range(3))
def test_a_set_leaves_the_cloth_longer(kind: int, seed: int) -> None:
    read = _read(_drawn("permanent-set", kind, seed))
    back = slice(81, 161)
    assert read.stress[80] > 0.0
    assert read.stretch[back][read.stress[back] <= 1e-12].max() > 1.005


@pytest.mark.parametrize("kind", range(3))
@pytest.mark.parametrize("seed", range(3))
def test_warmth_softens_the_more_the_warmer(kind: int, seed: int) -> None:
    truth = _drawn("thermal-softening", kind, seed)
    room, warm, hot = (_read(truth, replace(CYCLES, temperature=at)).stress[5:80] for at in (20.0, 40.0, 60.0))
    assert (hot < warm).all()
    assert (warm < room).all()
    assert hot.min() > 0.0


@pytest.mark.parametrize("kind", range(3))
@pytest.mark.parametrize("seed", range(3))
def test_what_the_jaws_give_is_not_the_cloths(kind: int, seed: int) -> None:
    """The width says how far the cloth is stretched, and the stress is that stretch's."""
    truth = _drawn("grip-slack", kind, seed)
    read, plain = _read(truth), _read(replace(truth, effects=()))
    assert read.transverse is not None
    own = (read.transverse) ** -2.0
    assert own[80] < read.stretch[80] - 0.01
    assert np.std(np.interp(own, plain.stretch[:81], plain.stress[:81]) - read.stress) < 0.03 * truth.top


def test_rows_stand_at_one_time_step_and_differ_from_specimen_to_specimen() -> None:
    for seed in range(8):
        setups = sixth_fabric.protocol(np.random.default_rng(seed))
        reads = sixth_fabric.measure(
            sixth_fabric.draw(np.random.default_rng(1), []), setups, np.random.default_rng(0), 0.0
        )
        assert len({len(one.time) for one in reads}) >= 4
        assert sum(len(one.time) for one in reads) < 6000
        for setup, read in zip(setups, reads, strict=True):
            assert isinstance(setup, sixth_fabric.Run)
            if not setup.stores_turns:
                beats = read.time / setup.step
                assert beats == pytest.approx(np.round(beats), abs=1e-6)
    counts = {len(sixth_fabric.protocol(np.random.default_rng(seed))) for seed in range(30)}
    assert any(count > 12 for count in counts)
    assert any(count < 11 for count in counts)


def test_a_set_up_of_another_set_is_carried_out_too() -> None:
    truth = _drawn("mullins", 0)
    [read] = sixth_fabric.measure(truth, [Setup(turns=(1.4, 1.0), hold=50.0, points=40)], np.random.default_rng(0), 0.0)
    assert 100 < len(read.time) < 125
    assert read.stretch.max() == 1.4


def test_noise_is_of_the_sd_asked_for() -> None:
    truth = sixth_fabric.draw(np.random.default_rng(3), [])
    setups = sixth_fabric.protocol(np.random.default_rng(4))
    reads, clean = (sixth_fabric.measure(truth, setups, np.random.default_rng(5), sd) for sd in (0.01, 0.0))
    slack = np.concatenate(
        [one.stress[other.stress < 0.05 * truth.top] for one, other in zip(reads, clean, strict=True)]
    )
    assert np.std(slack) == pytest.approx(0.01, rel=0.15)
    steps = np.unique(np.round(np.concatenate([one.stress for one in reads]), 12))
    assert len(steps) < 0.5 * sum(len(one.stress) for one in reads)


def test_no_other_mode_is_tested() -> None:
    with pytest.raises(ValueError, match="tested in torsion"):
        table(CLOTHS[0], "torsion", 0.0, 1.5)


@pytest.mark.parametrize(("effect", "kind"), CASES)
def test_a_trial_shows_its_effect_by_half_the_noise_or_more(effect: str, kind: int) -> None:
    _, noise, truth, setups = case(kind, (effect,), poor=False, which="sixth")
    assert truth.draws[effect]["kind"] == kind
    clean = problem_of(
        sixth_fabric.measure(truth, setups, np.random.default_rng(0), 0.0),
        "neo-hookean" if effect == "elastic-law" else "yeoh-3",
    )
    assert shown(clean, noise) >= 1.5
