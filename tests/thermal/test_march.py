"""The compiled steps of a reduced mold against its differential equation, given to a general solver.

Two parts, three unknowns, a film, a radiator, a bench and two heaters; each thing that a run may be given is turned on
in turn. The equation is that of the page on the laws behind hf close-loop, written here in numpy.
"""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from hyperfab.thermal.reduced_steps import Faces, Numbers, Parts, Trail, march

GAMMA = 1.0 - 0.5 * np.sqrt(2.0)
END = 400.0
SIGMA = 5.670374419e-8

#: Matrices of two parts [J/K, W/K], symmetric; conduction leaves a uniform temperature alone.
MASSES = np.array([np.diag([300.0, 200.0, 0.0]), np.diag([0.0, 100.0, 400.0])])
BAR, PLATE = np.array([1.0, -1.0, 0.0]), np.array([0.0, 1.0, -1.0])
STIFFNESSES = np.array([8.0 * np.outer(BAR, BAR), 5.0 * np.outer(PLATE, PLATE)])
MEANS = np.array([[0.6, 0.4, 0.0], [0.0, 0.2, 0.8]])
MEAN = np.array([0.3, 0.3, 0.4])
#: A joint that opens and closes, and one that conducts well.
JUMP = np.outer([1.0, 0.0, -1.0], [1.0, 0.0, -1.0])
JOINED = 3.0 * JUMP
#: Two points of a film, one of a radiator, two of the bench.
ROWS = np.array([[1.0, 0.0, 0.0], [0.5, 0.5, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.3, 0.7]])
WEIGHTS = np.array([0.02, 0.03, 0.04, 0.05, 0.01])
OWNER = np.array([0, 0, 1, 2, 2])
SOURCES = np.array([[0.7, 0.3, 0.0], [0.0, 0.0, 1.0]])
FILM = (np.array([0.0, 60.0, 120.0]), np.array([10.0, 14.0, 30.0]))


def air(t):
    """Ambient of film, radiator and bench [degC]."""
    return np.array([20.0 + 5.0 * np.sin(t / 90.0), 25.0 + 0.02 * t, 22.0 - 0.01 * t])


def powers(t):
    return np.array([300.0 * (1.0 + 0.3 * np.cos(t / 70.0)), 100.0 * t / END])


def closed(t):
    return np.array([0.5 - 0.5 * np.cos(t / 60.0)])


CASES = {
    "plain": {},
    "film of one value": {"film": (np.zeros(1), np.array([12.0]))},
    "no film": {"scale": 0.0},
    "film twice, and more beside it": {"scale": 2.0, "extra": (3.0, 4.0, 6.0)},
    "radiates": {"grey": (0.0, 0.8, 0.0)},
    "radiates to warmer surroundings": {"grey": (0.6, 0.8, 0.0), "surroundings_K": 30.0},
    "specific heat": {"capacity_per_K": 2e-3, "capacity_per_K2": 1e-5},
    "conductivity": {"conductivity_per_K": 4e-3},
    "tables": {"changes": True},
    "tables and rates": {"changes": True, "capacity_per_K": 1e-3, "conductivity_per_K": 2e-3},
    "power lost": {"lost": 0.1, "lost_per_K": 1e-3, "lost_per_K2": 1e-5},
    "through the back": {"back_W_K": 1.5},
    "wire": {"wire_per_K": 3e-3},
    "joint closes": {"joint_per_K": 5e-3},
    "exponent": {"exponent": 0.25},
    "bench": {"extra": (0.0, 0.0, 20.0)},
    "bench warms up": {"extra": (0.0, 0.0, 20.0), "bench_share": 0.4, "bench_s": 50.0},
}  # fmt: skip


def settings(case):
    numbers = dict.fromkeys(Numbers._fields, 0.0) | {"reference": 21.0}
    numbers |= {name: value for name, value in case.items() if name in Numbers._fields}
    film = case.get("film", FILM)
    changes = np.ones((2, 2, 1, 2))
    if case.get("changes"):
        at = np.array([20.0, 80.0, 140.0])
        changes = np.array(
            [
                [np.column_stack([at, (1.0 + rate * (at - 50.0))]) for rate in rates]
                for rates in ((2e-3, 1e-3), (-1e-3, 3e-3))
            ]
        )
    scale = np.array([case.get("scale", 1.0), 0.0, 0.0])
    return (
        numbers,
        film,
        changes,
        scale,
        np.array(case.get("extra", (0.0, 0.0, 0.0))),
        np.array(case.get("grey", (0.0,) * 3)),
    )


def stepped(case, steps, shares=(1.0,), off=0.0, trail=None):
    """Each point of the faces stands as several, of these shares of its area; all that may be is ``off`` by a share."""
    numbers, film, changes, scale, extra, grey = settings(case)
    numbers = {name: value * (1.0 + 0.7 * off) for name, value in numbers.items()}
    scale, extra, grey = scale * (1.0 + off), extra * (1.0 - off), grey * (1.0 + 2.0 * off)
    # Steps that grow: what is kept from one step to the next must notice.
    grid = END * np.linspace(0.0, 1.0, steps + 1) ** 1.2
    stages = np.stack([grid[:-1] + GAMMA * np.diff(grid), grid[1:]], axis=1)
    at = lambda signal: np.array([[signal(t) for t in pair] for pair in stages])  # noqa: E731
    masses, stiffnesses = MASSES * (1.0 + off), STIFFNESSES * (1.0 - 3.0 * off)
    joined, joint = JOINED * (1.0 + off), np.array([6.0 - off])
    parts = Parts(masses, stiffnesses, MEANS, changes, joined, joint, JUMP[None], at(closed), MEAN)
    first = np.array([0, len(film[0]), len(film[0]) + 1, len(film[0]) + 2])
    knots, values = (np.concatenate([row, [0.0, 0.0]]) for row in film)
    rows, owner = (np.repeat(of, len(shares), axis=0) for of in (ROWS, OWNER))
    faces = Faces(rows, np.outer(WEIGHTS, shares).ravel(), owner, scale, extra, grey, at(air), knots, values, first)
    start = np.array([30.0 + off, 25.0 - 2.0 * off, 40.0])
    room = Trail.room(0, 3) if trail is None else trail
    return march(grid, start, parts, faces, SOURCES, at(powers) * (1.0 + off), Numbers(**numbers), room)


@cache
def solved(name):
    """The state at the end and its slope, of the equation as the page has it; last the bench's own warmth."""
    n, film, changes, scale, extra, grey = settings(CASES[name])

    def heat(t, a):
        mass, flow, ref = np.zeros((3, 3)), np.zeros(3), n["reference"]
        for part in range(2):
            at = MEANS[part] @ a[:3]
            warm = at - ref
            heavier = 1 + n["capacity_per_K"] * warm + n["capacity_per_K2"] * warm**2
            capacity = np.interp(at, *changes[0, part].T) * heavier
            conduct = np.interp(at, *changes[1, part].T) * (1 + n["conductivity_per_K"] * warm)
            mass += capacity * MASSES[part]
            flow -= conduct * STIFFNESSES[part] @ a[:3]
        flow -= (1 + n["joint_per_K"] * (MEAN @ a[:3] - ref)) * JOINED @ a[:3] + 6.0 * closed(t)[0] * JUMP @ a[:3]
        bench = WEIGHTS[3:] @ ROWS[3:] / WEIGHTS[3:].sum()
        for row, area, face in zip(ROWS, WEIGHTS, OWNER, strict=True):
            at, around = row @ a[:3], air(t)[face] + (a[3] if face == 2 else 0.0)
            h = extra[face]
            if scale[face]:
                h += scale[face] * np.interp(at, *film) * (abs(at - around) / 30.0) ** n["exponent"]
            loss = h * (at - around) + grey[face] * SIGMA * (
                (at + 273.15) ** 4 - (around + n["surroundings_K"] + 273.15) ** 4
            )
            flow -= area * loss * row
        for shape, power in zip(SOURCES, powers(t), strict=True):
            hot = shape @ a[:3] - ref
            share = (1 - n["lost"] - n["lost_per_K"] * hot - n["lost_per_K2"] * hot**2) / (1 + n["wire_per_K"] * hot)
            flow += (share * power - (n["back_W_K"] * hot if power else 0.0)) * shape
        follows = n["bench_share"] * (bench @ a[:3] - air(t)[2])
        return np.append(np.linalg.solve(mass, flow), (follows - a[3]) / n["bench_s"] if n["bench_s"] else 0.0)

    found = solve_ivp(heat, (0.0, END), [30.0, 25.0, 40.0, 0.0], method="Radau", rtol=1e-9, atol=1e-8)
    return found.y[:3, -1], heat(END, found.y[:, -1])[:3]


@pytest.mark.parametrize("name", CASES)
def test_steps_follow_the_equation(name):
    exact, slope = solved(name)
    rise = float((exact - 30.0).max())
    assert np.all(exact > 60.0)  # a case that stays cold would show nothing
    states, slopes = stepped(CASES[name], 100)
    np.testing.assert_allclose(states[-1], exact, atol=5e-5 * rise)
    np.testing.assert_allclose(slopes[-1], slope, atol=2e-3 * np.abs(slope).max())


@pytest.mark.parametrize("count", [2, 3, 5])
def test_points_may_stand_as_several(count):
    """More of them than go into the tangent at once, and some that are left."""
    shares = np.arange(1.0, count + 1.0) / np.arange(1.0, count + 1.0).sum()
    case = CASES["radiates to warmer surroundings"]
    for one, several in zip(stepped(case, 20), stepped(case, 20, shares), strict=True):
        np.testing.assert_allclose(several, one, rtol=1e-11)


@pytest.mark.parametrize("name", CASES)
def test_runs_beside_another_leave_out_the_square_of_what_they_are_off_by(name):
    """Each constant, the start and the power are off together; the matrices are those of the run that is none."""
    trail = Trail.room(40, 3)
    nominal, _ = stepped(CASES[name], 40, trail=trail)
    missed, moved = [], []
    for off in (1e-3, 1e-4):
        whole, beside = (stepped(CASES[name], 40, off=off, trail=one)[0] for one in (None, trail._replace(known=True)))
        missed.append(np.abs(beside - whole).max())
        moved.append(np.abs(whole - nominal).max())
    assert moved[0] > 0.005
    assert missed[0] < 0.01 * moved[0]
    assert missed[1] < 0.015 * missed[0] + 1e-10
    again, _ = stepped(CASES[name], 40, trail=trail._replace(known=True))
    np.testing.assert_allclose(again, nominal, rtol=1e-12)


def test_steps_close_in_with_their_square():
    """Where nothing has a kink: a film of one value."""
    exact, _ = solved("film of one value")
    errors = [np.abs(stepped(CASES["film of one value"], n)[0][-1] - exact).max() for n in (40, 80, 160)]
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2.0, abs=0.25)
    assert np.log2(errors[1] / errors[2]) == pytest.approx(2.0, abs=0.15)


def test_what_is_turned_on_matters():
    """Each case differs from the plain one by far more than the steps' error."""
    for name in CASES:
        if name != "plain":
            assert np.abs(solved(name)[0] - solved("plain")[0]).max() > 0.3, name
