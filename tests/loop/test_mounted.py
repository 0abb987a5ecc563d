"""How a sheet was mounted, and what a constant at the end of what is known says: truths by the generator's own net."""

from __future__ import annotations

import numpy as np
import pytest
from loop import blind_drape
from loop.generators import drape as nets

from hyperfab.chapters.close_loop.finalise import close_rounds
from hyperfab.chapters.close_loop.readings import Files
from hyperfab.loop.drape import Markers, drape_problem
from hyperfab.loop.engine import Finding

pytestmark = pytest.mark.slow


def seen(stretch: tuple[float, float], noise: float, seed: int) -> Finding:
    """Return what 120 markers tell of a sheet mounted with a stretch along warp and weft, read with a noise [mm]."""
    net, (warp, weft) = nets.Net(nets.Truth(())), stretch
    half, n = len(net.rest) // 2, nets.NODES
    # Threads are shorter than between the nodes, and those across them lie closer.
    net.rest[:half] /= warp
    net.rest[half:] /= weft
    net.area[:half] /= weft
    net.area[half:] /= warp
    nodes, random = net.drape(), np.random.default_rng(seed)
    line = np.linspace(-0.5 * nets.SIDE, 0.5 * nets.SIDE, n)
    inner = np.array([(i, j) for i in range(1, n - 1) for j in range(1, n - 1)])
    i, j = inner[random.choice(len(inner), 120, replace=False)].T
    found = nodes[i, j] + noise * random.standard_normal((120, 3))
    draped, forward = blind_drape.model()
    markers = Markers("markers.csv", np.stack([line[i], line[j]], axis=1), found)
    problem = drape_problem(draped, [markers])
    return close_rounds(problem, Files([markers]).noise, forward.corrected, design=False)[1]


def test_a_slack_sheet_is_told_from_a_heavy_one() -> None:
    """Slack threads of this net hang as they like: something is left of their places, and not of the stretch."""
    found = seen((0.98, 0.98), 0.1, 0)
    assert found.after.ids == ("pretension",)
    [(form, values)] = found.after.fit.terms.values()
    assert form == "even"
    assert values[0] == pytest.approx(-0.02, abs=0.003)


@pytest.mark.parametrize(("noise", "seed"), [(0.1, 0), (0.1, 1), (0.2, 1)])
def test_a_stretch_along_one_way_is_not_an_even_one_of_threads_that_nobody_knows(noise: float, seed: int) -> None:
    found = seen((1.0, 1.03), noise, seed)
    assert (found.verdict, found.after.ids) == ("effect", ("pretension",))
    [(form, values)] = found.after.fit.terms.values()
    assert form == "each way"
    assert values == pytest.approx([0.0, 0.03], abs=0.003)


def test_an_effect_beside_a_constant_at_the_end_of_what_is_known_is_not_sure(monkeypatch: pytest.MonkeyPatch) -> None:
    """A mold pushed up by 1 mm more than its document says: what is nearest takes the depth to its end."""
    blind_drape.model()  # of the document, whose mold is as it was drawn
    monkeypatch.setattr(nets, "DEPTH", nets.DEPTH + 1.0)
    found = seen((1.0, 1.0), 0.2, 0)
    fit = found.after.fit
    assert found.verdict == "unexplained"
    assert found.after.problem.strained(fit.x[: fit.own]) == ["depth"]


def test_a_depth_that_is_off_by_more_than_is_known_is_not_a_size_of_the_mold_for_sure(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    blind_drape.model()  # of the document, whose mold is as it was drawn
    monkeypatch.setattr(nets, "DEPTH", nets.DEPTH + 0.5)
    found = seen((1.0, 1.0), 0.1, 0)
    assert found.verdict != "effect"
    assert found.indistinguishable == [["mold-size", "depth"]]


@pytest.mark.parametrize("larger", [0.05, -0.04])
def test_a_mold_of_another_size_is_found(monkeypatch: pytest.MonkeyPatch, larger: float) -> None:
    blind_drape.model()  # of the document, whose mold is as it was drawn
    monkeypatch.setattr(nets, "BALL", (1.0 + larger) * nets.BALL)
    found = seen((1.0, 1.0), 0.05, 0)
    assert (found.verdict, found.after.ids) == ("effect", ("mold-size",))
    [(form, values)] = found.after.fit.terms.values()
    # Near its top a ball is as flat where it is wider by half as much.
    assert values == pytest.approx([larger * {"all ways": 1.0, "across": 0.5}[form]], abs=0.006)


def test_a_mold_off_the_middle_of_the_sheet_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    blind_drape.model()  # of the document, whose mold is in the middle
    monkeypatch.setattr(nets, "ASIDE", (3.0, -1.5))
    found = seen((1.0, 1.0), 0.05, 0)
    assert (found.verdict, found.after.ids) == ("effect", ("lateral-shift",))
    [(form, values)] = found.after.fit.terms.values()
    assert form == "displacement"
    assert values == pytest.approx([3.0, -1.5], abs=0.15)
