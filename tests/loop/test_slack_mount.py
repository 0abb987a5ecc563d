"""A sheet mounted slack is found from a model that is not, and what is predicted of it is what the sheet does."""

from __future__ import annotations

import numpy as np
import pytest
from loop import blind_contact

from hyperfab.chapters.close_loop.contact import pose
from hyperfab.chapters.close_loop.extended_sheet import contact_applied
from hyperfab.chapters.close_loop.finalise import close_rounds
from hyperfab.chapters.close_loop.readings import Files
from hyperfab.chapters.fabric_contact.setup import setup_of
from hyperfab.loop.catalogue.contact import DataContext, pretension
from hyperfab.loop.contact import ADDED, ForceDepth
from hyperfab.loop.slack import Slack
from hyperfab.membrane.sphere_contact import rough_path


def forces(depths: np.ndarray, settings: dict[str, float], mesh: float) -> np.ndarray:
    """Return the force [N] of the sheet itself at depths, on elements of ``mesh`` [mm]."""
    _, _, forward = blind_contact.model()
    test = setup_of(contact_applied(forward.case, settings), forward.geometry, forward.fabric).test(forward.fabric)
    _, path = rough_path(test.__class__(**{**vars(test), "mesh_size": mesh}), [float(v) for v in depths])
    return np.array([state.force for state in path.states])


def test_slack_is_sought_where_a_model_bears_at_once() -> None:
    form = pretension(DataContext((20.0,), 20.0, (0.05, 0.1), 0.5, 10.0, 2.0, 1.5)).forms[0]
    assert form.constants[0].low == -0.05
    for values in (form.starts, form.probes):
        assert -0.05 < min(values)[0] < 0.0
    form = pretension(DataContext((20.0,), 20.0, (0.0, 0.1), 0.5, 10.0, 2.0, 1.5)).forms[0]
    assert all(values[0] > 0.0 for values in (*form.starts, *form.probes))


@pytest.mark.parametrize("added", [-0.001, -0.02, -0.05])
def test_depths_and_knots_of_a_slack_sheet_are_each_others_inverse(added: float) -> None:
    slack, knots = Slack(30.0, 90.0, 60.0), np.linspace(5.0, 60.0, 12)
    depths = slack.depths(knots, added)
    assert depths[-1] == pytest.approx(60.0, rel=1e-6)
    assert (np.diff(depths) > 0.0).all()
    np.testing.assert_allclose(slack.knots(depths, added), knots, rtol=1e-3)
    # Where it begins to bear, and not before.
    begin = float(slack.depths(np.array([1e-9]), added)[0])
    assert (slack.taut(begin * np.array([0.5, 0.99, 1.01]), added) > 0.0).tolist() == [False, False, True]


@pytest.mark.slow
@pytest.mark.parametrize(
    "settings",
    [
        {"prestretch": -0.004},
        {"prestretch": -0.017},
        {"prestretch": -0.041},
        {"prestretch": -0.026, "friction": 0.2, "slip": 12.0},
    ],
    ids=lambda settings: f"{settings['prestretch']} of {len(settings)}",
)
def test_the_emulated_slack_sheet_is_the_sheet(settings: dict[str, float]) -> None:
    _, sheet, forward = blind_contact.model()
    assert sheet.slack is not None
    depths, added = np.linspace(4.0, 60.0, 25), settings["prestretch"]
    effects = np.array([settings.get(name, 0.0) for name in ADDED])
    found = sheet.force(np.ones(len(sheet.names)), effects, depths)
    _, states = forward.states(forward.test(settings), depths)
    true = np.array([state.force for state in states])
    true *= np.interp(sheet.slack.knots(depths, added), sheet.knots, sheet.correction)
    assert np.count_nonzero(true < 1e-6) >= 2
    assert found == pytest.approx(true, abs=2.5e-3 * true.max())


@pytest.mark.slow
@pytest.mark.parametrize(("slack", "mu"), [(0.012, 0.0), (0.025, 0.0), (0.045, 0.0), (0.03, 0.25)])
def test_a_sheet_mounted_slack_is_named_with_its_slack(slack: float, mu: float) -> None:
    material, sheet, forward = blind_contact.model()
    depth = np.linspace(2.0, 58.0, 60)
    settings = {"prestretch": -slack, "friction": mu}
    true, random = forces(depth, settings, 6.0), np.random.default_rng(3)
    files = [ForceDepth("t.csv", depth, true + 0.003 * true.max() * random.standard_normal(60))]
    if mu:
        oiled = forces(depth, {"prestretch": -slack}, 6.0)
        files.append(ForceDepth("o.csv", depth, oiled + 0.003 * true.max() * random.standard_normal(60), friction=0.0))
    problem = pose(sheet, files, material, 0.1, [])
    found = close_rounds(problem, Files(list(files)).noise, forward.corrected, design=False)[1]
    assert (found.verdict, {*found.after.ids}) == ("effect", {"pretension", "friction"} if mu else {"pretension"})
    assert found.after.fit.terms["pretension"][1][0] == pytest.approx(-slack, abs=0.002)
