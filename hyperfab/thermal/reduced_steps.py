"""The time steps of a reduced mold, compiled: small dense matrices, one run at a time."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hyperfab.arrays import Array, Ints
from hyperfab.numerics.kernels import inlined, kernel, part, summed


class Numbers(NamedTuple):
    """What a run may be given beside its matrices; absent at 0, ``reference`` [degC] apart."""

    reference: float
    capacity_per_K: float
    capacity_per_K2: float
    conductivity_per_K: float
    exponent: float
    lost: float
    lost_per_K: float
    lost_per_K2: float
    back_W_K: float
    joint_per_K: float
    surroundings_K: float
    bench_share: float
    bench_s: float
    wire_per_K: float


class Parts(NamedTuple):
    """Matrices of p parts and j joints in r coordinates.

    ``mass``, ``stiffness`` (p, r, r); ``means`` (p, r) give a part's mean temperature, ``mean`` (r,) that of all;
    ``changes`` (2, p, k, 2) temperatures and factors of its specific heat and conductivity there. ``joined`` (r, r):
    the joints that conduct well; ``joint`` (j,) conductances of the others, ``jumps`` (j, r, r) their jumps, ``closed``
    (steps, 2, j) how far each is closed in the stages of a step.
    """

    mass: Array
    stiffness: Array
    means: Array
    changes: Array
    joined: Array
    joint: Array
    jumps: Array
    closed: Array
    mean: Array


class Faces(NamedTuple):
    """Points of quadrature (q) of f faces, of which the last is on what the mold stands on.

    ``rows`` (q, r) give the temperature there, ``weights`` (q,) the area, ``owner`` (q,) the face. Of a face:
    ``scale`` of its film coefficient, ``extra`` of it [W/m^2/K], ``grey`` emissivity, ``air`` (steps, 2, f) [degC],
    ``knots``, ``values`` of the film's table, which begin at ``first`` (f + 1,).
    """

    rows: Array
    weights: Array
    owner: Ints
    scale: Array
    extra: Array
    grey: Array
    air: Array
    knots: Array
    values: Array
    first: Ints


class Trail(NamedTuple):
    """What a run leaves for others so near it that its matrices serve them, to first order in how far they are off.

    ``factors`` (k, r, r) of the matrices that were factored, which of them (steps, 2) each stage took, and what each
    stage solved for, ``answers`` (steps, 2, r). Not ``known``: the run leaves its own, unless there is no room.
    """

    known: bool
    factors: Array
    which: Ints
    answers: Array

    @staticmethod
    def room(steps: int, size: int) -> Trail:
        """Return the trail that a run of so many steps in so many coordinates may leave."""
        whole = np.empty((2 * steps, size, size))
        return Trail(False, whole, np.zeros((steps, 2), dtype=np.int64), np.empty((steps, 2, size)))


@kernel
def march(  # noqa: C901
    grid: Array,
    start: Array,
    parts: Parts,
    faces: Faces,
    sources: Array,
    powers: Array,
    numbers: Numbers,
    trail: Trail,
) -> tuple[Array, Array]:
    """Step through ``grid``; one Newton step a stage from a guess of first order, exact for linear films.

    ``sources`` (h, r) are the heaters, ``powers`` (steps, 2, h) what they give. What does not depend on temperature
    goes into one matrix, and where that is all, a matrix is factored anew only where the step or a joint changes.
    All matrices are symmetric and are gone through by rows, which processors take several numbers of at once.

    Beside a run whose ``trail`` is known no matrix is factored: what that run solved for, x, and one step of refining
    it, x + A^-1 (b - B x), with its factors of A and the own B and b, leave out the square of what the runs differ by.
    """
    n, r = len(grid), len(start)
    masses, stiffnesses, means, changes, joined, joint, jumps, closed, mean = parts
    rows, weights, owner, scale, extra, grey, air, knots, values, first = faces
    reference, capacity_rate, capacity_bend, conduction_rate, exponent = numbers[:5]
    lost, lost_rate, lost_bend, back, joint_rate, surroundings = numbers[5:11]
    bench_share, bench_time, wire_rate = numbers[11:]
    known, factors, which, answers = trail
    factored = -1
    states, slopes = np.zeros((n, r)), np.zeros((n, r))
    states[0] = start
    slope = np.zeros(r)
    count_of_parts, bench = len(masses), len(scale) - 1
    mass, steady = np.zeros((r, r)), joined.copy()
    for p in range(count_of_parts):
        mass += masses[p]
        steady += stiffnesses[p]
    # What a kelvin of air gives through each face.
    inflow = np.zeros((len(scale), r))
    bent = np.zeros(len(owner), dtype=np.int64)
    count = 0
    under, area = np.zeros(r), 0.0
    for q in range(len(owner)):
        face = owner[q]
        if face == bench:
            area += weights[q]
            _add(under, weights[q], rows[q])
        plain = first[face + 1] - first[face] == 1 and exponent == 0.0
        h = extra[face]
        if plain:
            h += values[first[face]] * scale[face]
        if grey[face] != 0.0 or (not plain and scale[face] != 0.0):
            bent[count] = q
            count += 1
            continue
        if h == 0.0:
            continue
        for i in range(r):
            part = h * weights[q] * rows[q, i]
            inflow[face, i] += part
            for j in range(r):
                steady[i, j] += part * rows[q, j]
    if area > 0.0:
        under /= area
    heavier = capacity_rate != 0.0 or capacity_bend != 0.0 or changes.shape[2] > 1
    better = conduction_rate != 0.0 or changes.shape[2] > 1
    alike = count == 0 and not heavier and not better and joint_rate == 0.0
    tangent, matrix = np.empty((r, r)), np.empty((r, r))
    # The same in one row each: long rows are added faster.
    whole_mass, whole_tangent = mass.reshape(r * r), tangent.reshape(r * r)
    whole_masses, whole_stiffnesses = (masses.reshape(len(masses), r * r), stiffnesses.reshape(len(masses), r * r))
    flow, right, other, ahead = np.empty(r), np.empty(r), np.zeros(r), np.empty(r)
    bent_rows = rows[bent[:count]]
    across = bent_rows.T.copy()
    steeper, warmth, onto = np.empty(count), np.empty(count), np.zeros(count)
    scaled = np.empty((r, count))
    known_step, known_closed = -1.0, np.zeros(len(joint))
    warmed = 0.0
    for number in range(n - 1):
        step = grid[number + 1] - grid[number]
        g = 0.2928932188134524 * step
        a = states[number]
        base = a.copy()
        guess = a + g * slope
        if heavier:
            mass[:] = 0.0
            for p in range(count_of_parts):
                at = _dot(means[p], a) + 0.5 * step * _dot(means[p], slope)
                warm = at - reference
                factor = _between(at, changes[0, p, :, 0], changes[0, p, :, 1], 0, changes.shape[2])
                factor *= max(1.0 + (capacity_rate + capacity_bend * warm) * warm, 0.05)
                _add(whole_mass, factor, whole_masses[p])
        for stage in range(2):
            same = alike and abs(step - known_step) <= 1e-9 * step
            for j in range(len(joint)):
                same = same and closed[number, stage, j] == known_closed[j]
            if not same:
                tangent[:] = steady
                for k in range(len(joint)):
                    for i in range(r):
                        _add(tangent[i], joint[k] * closed[number, stage, k], jumps[k, i])
                if better:
                    for p in range(count_of_parts):
                        at = _dot(means[p], guess)
                        factor = _between(at, changes[1, p, :, 0], changes[1, p, :, 1], 0, changes.shape[2])
                        factor *= max(1.0 + conduction_rate * (at - reference), 0.05)
                        _add(whole_tangent, factor - 1.0, whole_stiffnesses[p])
                if joint_rate != 0.0:
                    tangent += max(joint_rate * (_dot(mean, guess) - reference), -0.95) * joined
            if known:
                other[:] = answers[number, stage]
                _mix(onto, other, across)
            ahead[:] = guess + other
            flow[:] = 0.0
            for i in range(r):
                _add(flow, -ahead[i], tangent[i])
            for face in range(len(scale)):
                _add(flow, air[number, stage, face], inflow[face])
            if bench_share != 0.0:
                # A bench that follows the face on it.
                follows = bench_share * (_dot(under, guess) - air[number, stage, bench])
                passed = step if stage else g
                _add(
                    flow,
                    follows + (warmed - follows) * np.exp(-passed / max(bench_time, 1e-9)),
                    inflow[bench],
                )
            _mix(warmth, guess, across)
            for k in range(count):
                q = bent[k]
                face = owner[q]
                at = warmth[k]
                away = at - air[number, stage, face]
                h = extra[face]
                if scale[face] != 0.0:
                    film = scale[face] * _between(at, knots, values, first[face], first[face + 1])
                    if exponent != 0.0:
                        film = film * (max(abs(away), 0.5) / 30.0) ** exponent
                    h += film
                loss = h * away
                rate = h * (1.0 + max(exponent, 0.0))
                if grey[face] != 0.0:
                    hot, cold = at + 273.15, air[number, stage, face] + surroundings + 273.15
                    loss += grey[face] * 5.670374419e-8 * (hot**4 - cold**4)
                    rate += 4.0 * grey[face] * 5.670374419e-8 * hot**3
                _add(flow, -(loss + rate * onto[k]) * weights[q], bent_rows[k])
                steeper[k] = rate * weights[q]
            for j in range(sources.shape[0]):
                power = powers[number, stage, j]
                if power != 0.0:
                    hot = _dot(sources[j], guess) - reference
                    share = max(1.0 - lost - (lost_rate + lost_bend * hot) * hot, 0.0)
                    share /= max(1.0 + wire_rate * hot, 0.05)
                    _add(flow, share * power - back * hot, sources[j])
            for i in range(r):
                right[i] = g * flow[i]
            for i in range(r):
                _add(right, base[i] - ahead[i], mass[i])
            if not same:
                known_step = step
                for j in range(len(joint)):
                    known_closed[j] = closed[number, stage, j]
            if known:
                _solve(factors[which[number, stage]], right)
                right += other
            else:
                if not same:
                    _add_squares(tangent, steeper, across, scaled)
                    for i in range(r):
                        for j in range(i, r):
                            matrix[i, j] = mass[i, j] + g * tangent[i, j]
                    _factor(matrix)
                    factored += 1
                _solve(matrix, right)
                if len(factors) > 0:
                    if not same:
                        factors[factored] = matrix
                    which[number, stage] = factored
                    answers[number, stage] = right
            end = guess + right
            if stage == 0:
                rise = (end - base) / g
                base = a + (step - g) * rise
                guess = base + g * rise
            else:
                slope = (end - base) / g
        if bench_share != 0.0:
            follows = bench_share * (_dot(under, 0.5 * (a + end)) - air[number, 1, bench])
            warmed = follows + (warmed - follows) * np.exp(-step / max(bench_time, 1e-9))
        states[number + 1] = end
        slopes[number + 1] = slope
    return states, slopes


@summed
def _dot(a, b):  # type: ignore[no-untyped-def]
    total = 0.0
    for i in range(len(a)):
        total += a[i] * b[i]
    return total


@inlined
def _add(to, times, row):  # type: ignore[no-untyped-def]
    for i in range(len(to)):
        to[i] += times * row[i]


@part
def _mix(to, shares, rows):  # type: ignore[no-untyped-def]
    """Put the sum of ``rows``, each in its share, into ``to``."""
    to[:] = 0.0
    for i in range(len(rows)):
        _add(to, shares[i], rows[i])


@summed
def _add_squares(to, times, across, scaled):  # type: ignore[no-untyped-def]
    """Add columns of ``across`` (r, count) by themselves, each ``times`` so much, to the upper half of ``to``.

    By two rows and two columns of that at once, which are fetched half as often; some of the other half is touched.
    """
    r, count = across.shape
    for i in range(r):
        for k in range(count):
            scaled[i, k] = times[k] * across[i, k]
    even = r - r % 2
    for i in range(0, even, 2):
        a, b = scaled[i], scaled[i + 1]
        for j in range(i, even, 2):
            c, d = across[j], across[j + 1]
            ac, ad, bc, bd = 0.0, 0.0, 0.0, 0.0
            for k in range(count):
                ac += a[k] * c[k]
                ad += a[k] * d[k]
                bc += b[k] * c[k]
                bd += b[k] * d[k]
            to[i, j] += ac
            to[i, j + 1] += ad
            to[i + 1, j] += bc
            to[i + 1, j + 1] += bd
    for i in range(r if even < r else 0):
        to[i, r - 1] += _dot(scaled[i], across[r - 1])


@part
def _between(at, knots, values, low, high):  # type: ignore[no-untyped-def]
    """Return the value at ``at`` between the knots ``low`` to ``high``, that of the end beyond them."""
    if at <= knots[low]:
        return values[low]
    for k in range(low + 1, high):
        if at <= knots[k]:
            share = (at - knots[k - 1]) / (knots[k] - knots[k - 1])
            return values[k - 1] + share * (values[k] - values[k - 1])
    return values[high - 1]


@part
def _factor(matrix):  # type: ignore[no-untyped-def]
    """Put D and the rows of L^T in the upper half of a symmetric matrix L D L^T, of which that half is read.

    Two rows are taken off those below at once.
    """
    r = len(matrix)
    for k in range(0, r - 1, 2):
        one, two = matrix[k], matrix[k + 1]
        _add(two[k + 1 :], -one[k + 1] / one[k], one[k + 1 :])
        for i in range(k + 2, r):
            first, second = one[i] / one[k], two[i] / two[k + 1]
            row, above, below = matrix[i, i:], one[i:], two[i:]
            for j in range(len(row)):
                row[j] -= first * above[j] + second * below[j]
    for k in range(r):
        for i in range(k + 1, r):
            matrix[k, i] /= matrix[k, k]


@part
def _solve(matrix, right):  # type: ignore[no-untyped-def]
    """Put the solution in the place of the right side."""
    r = len(right)
    for k in range(r):
        _add(right[k + 1 :], -right[k], matrix[k, k + 1 :])
    for i in range(r):
        right[i] /= matrix[i, i]
    for i in range(r - 1, -1, -1):
        right[i] -= _dot(matrix[i, i + 1 :], right[i + 1 :])
