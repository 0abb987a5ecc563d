"""The third set of fabrics is what it says: finite, repeatable, of practical size, and plain where nothing acts."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from loop.generators import third_fabric as fabrics
from loop.generators.fabric import Setup
from loop.generators.third_energy import BASES, Truth

CASES = [(effect, kind) for effect, count in fabrics.KINDS.items() for kind in range(count)]
CASES += [(effect, 0) for effect in fabrics.OUTSIDE]
PEAKS = (1.25, 1.0, 1.25, 1.0, 1.5, 1.0)
BRIEF = [
    Setup("uniaxial", 0.0, 0.003, 23.0, PEAKS, points=16),
    Setup("uniaxial", 90.0, 0.003, 23.0, PEAKS, points=16),
    Setup("uniaxial", 0.0, 0.06, 23.0, PEAKS, points=16),
    Setup("uniaxial", 0.0, 0.003, 60.0, PEAKS, points=16),
    Setup("shear", 0.0, 0.003, 23.0, (1.4, 1.0), points=16),
]


def _drawn(effect: str, kind: int) -> Truth:
    return fabrics.draw(np.random.default_rng([kind, len(effect)]), [effect], kind)


@pytest.mark.parametrize(("effect", "kind"), CASES)
def test_every_kind_is_finite_repeatable_of_practical_size_and_gone_at_no_amount(effect: str, kind: int) -> None:
    truth = _drawn(effect, kind)
    assert 0.01 < fabrics.departure(truth, BRIEF, fine=2) < 0.12
    reads = fabrics.measure(truth, BRIEF[:2], np.random.default_rng(1), 0.002)
    again = fabrics.measure(replace(truth, laws={}), BRIEF[:2], np.random.default_rng(1), 0.002)
    for one, two in zip(reads, again, strict=True):
        assert np.isfinite(one.stress).all()
        assert np.array_equal(one.stress, two.stress)
        assert one.transverse is not None
        assert two.transverse is not None
        assert np.isfinite(one.transverse).all()
        assert np.array_equal(one.transverse, two.transverse)
    for share, most in ((0.0, 1e-12), (1e-3, 1e-3)):
        faint = {effect: truth.draws[effect] | {"amount": share * truth.draws[effect]["amount"]}}
        if share == 0.0 or effect not in {"compressibility", "permanent-set"}:
            assert fabrics.departure(replace(truth, draws=truth.draws | faint, laws={}), BRIEF[:2], fine=1) <= most


@pytest.mark.parametrize("effect", ["hysteresis", "rate", "mullins", "permanent-set"])
@pytest.mark.parametrize("kind", range(4))
def test_a_cycle_takes_work_and_starts_without_stress(effect: str, kind: int) -> None:
    for read in fabrics.measure(_drawn(effect, kind), BRIEF[:1] + BRIEF[4:], np.random.default_rng(2), 0.0):
        work = np.sum(0.5 * (read.stress[1:] + read.stress[:-1]) * np.diff(read.stretch))
        assert work > 1e-3 * read.stress.max()
        assert read.stress[0] == 0.0


@pytest.mark.parametrize("base", BASES)
def test_the_plain_law_contracts_without_change_of_volume_and_is_stiffer_when_held_in_width(
    base: str,
) -> None:
    truth = replace(fabrics.draw(np.random.default_rng(3), []), elastic=base)
    x = np.linspace(1.01, 1.6, 30)
    one, width = truth.law("uniaxial", 0.0)
    assert np.allclose(width(x), x**-0.5, atol=1e-6)
    assert (np.diff(one(x)) > 0.0).all()
    assert (truth.law("shear", 0.0)[0](x) > one(x)).all()
    assert np.allclose(one(x), truth.law("uniaxial", 90.0)[0](x))


@pytest.mark.parametrize("kind", range(4))
def test_warmth_softens_the_more_the_warmer(kind: int) -> None:
    truth = _drawn("thermal-softening", kind)
    tests = [Setup("uniaxial", 0.0, 0.003, warm, (1.5,), points=8) for warm in (23.0, 33.0, 43.0, 53.0, 68.0)]
    peaks = [r.stress.max() for r in fabrics.measure(replace(truth, seed=0), tests, np.random.default_rng(4), 0.0)]
    assert all(b < a * 1.012 for a, b in pairwise(peaks))
    assert peaks[-1] < 0.97 * peaks[0]


@pytest.mark.parametrize("kind", range(4))
def test_directions_differ_and_a_strip_between_them_lies_between_or_shears(kind: int) -> None:
    truth = _drawn("anisotropy", kind)
    warp, weft, slant = (float(truth.law("uniaxial", a)[0](np.array([1.4]))[0]) for a in (0.0, 90.0, 45.0))
    assert abs(warp - weft) > 0.01 * warp
    assert 0.0 < slant < 1.02 * max(warp, weft)


def test_a_programme_holds_what_tells_the_effects_apart() -> None:
    for seed in range(8):
        tests = fabrics.protocol(np.random.default_rng(seed))
        assert {0.0, 90.0} <= {s.angle for s in tests}
        assert max(s.rate for s in tests) >= 10.0 * min(s.rate for s in tests)
        assert max(s.temperature for s in tests) >= 53.0
        assert len({s.mode for s in tests}) == 2
        assert all(45 <= s.points <= 80 for s in tests)
        assert tests[0] == tests[1]
        assert tests == fabrics.protocol(np.random.default_rng(seed))


def test_two_effects_stand_together() -> None:
    truth = fabrics.draw(np.random.default_rng(6), ["hysteresis", "thermal-softening", "permanent-set"])
    assert 0.01 < fabrics.departure(truth, BRIEF, fine=2) < 0.2
