"""How sure constants are by how specimens scatter: readings of one specimen err together, specimens do not.

The variance of a least-squares estimate is that of what each specimen contributes to it, taken among specimens of one
kind (one test, direction and temperature): the linearised variance of a stratified sample of clusters. What the law
itself misses is the same for all of a kind, and does not count as scatter. Binder (1983), Int. Stat. Rev. 51, 279,
doi:10.2307/1402588; degrees of freedom by Satterthwaite (1946), Biometrics Bull. 2, 110, doi:10.2307/3002019.
"""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import ndtri, stdtr, stdtrit

from hyperfab.arrays import Flags, Ints
from hyperfab.materials.identification.linear import lengths
from hyperfab.materials.law import Array

#: Where intervals are to cover: both tails of 95 %.
_LEVEL = 0.975
#: The largest correlation of neighbouring readings, and how many up to there are tried. So many independent readings at
#: least tell a variance: Student's t of fewer would make of any smooth misfit of a law that it tells nothing.
_MOST_ALIKE, _TRIED, _FEWEST = 0.98, 20, 4.0
#: Halvings in which an interval is found.
_HALVINGS = 60
#: Influence this small beside the largest is rounding.
_NO_SAY = 1e-12


@dataclass(frozen=True)
class Scatter:
    """Covariance (p, p) of the published constants from ``specimens``, to be used with Student's t of ``freedom``.

    ``parts`` are what kinds of specimens add to it, each with its own degrees of freedom: what hangs on several
    constants may hang on other kinds than each of them, and has degrees of freedom of its own.
    """

    covariance: Array
    freedom: int
    specimens: int
    parts: tuple[tuple[Array, int], ...]

    def reordered(self, order: Sequence[int]) -> Scatter:
        """Return the scatter of the constants in another order."""
        square = np.ix_(order, order)
        parts = tuple((one[square], freedom) for one, freedom in self.parts)
        return replace(self, covariance=self.covariance[square], parts=parts)


@dataclass(frozen=True)
class Weighed:
    """A least-squares optimum: ``jacobian`` (rows, q) and ``residual`` (rows,) of the weighted equations.

    ``model`` (rows,) is the weighted stress the law gives, zero in rows that are none; ``curve`` each row's curve.
    ``deviation`` (rows,) is the weighted standard deviation where it is stated of all stresses, no number in rows that
    are none.
    """

    jacobian: Array
    residual: Array
    model: Array
    curve: Ints
    deviation: Array | None = None


def by_readings(fit: Weighed, basis: Array, spread: Array) -> Array:
    """Return the covariance (p, p) of constants that move by ``spread`` (p, q) with what readings err along an
    orthonormal ``basis`` (rows, q) of the Jacobian: without replicates, and without stated deviations.

    What a load cell or a law errs by goes on from reading to reading, correlated ``rho^k`` over k of them in a curve.
    How much is hardly sure. For each rho that may be, what is left tells the variance, less what the fit takes of it;
    how likely it is, the correlation of neighbours in what is left, which scatters by ``(1 - rho^2)/n`` (Bartlett 1946,
    Suppl. J. R. Stat. Soc. 8, 27, doi:10.2307/2983611). Each constant's interval of 1.96 standard deviations covers
    95 % of what all of them leave open. Not a number where there are no more readings than constants. Widths that were
    read beside the stresses err by a share of their own.
    """
    rows, count = basis.shape
    together = np.diff(fit.curve) == 0
    pairs, squares = np.count_nonzero(together), float(fit.residual @ fit.residual)
    if rows <= count:
        return np.full((len(spread), len(spread)), np.nan)
    share = _shares(fit, basis)
    basis, left = basis * share[:, None], fit.residual / share
    beside = _neighbours(np.column_stack([basis, left]), together)
    seen = float(left @ beside[:, count]) / max(float(left @ left), 1e-300)
    likely, freedom = np.zeros(_TRIED), np.empty(_TRIED)
    found = np.empty((_TRIED, len(spread), len(spread)))
    for k, rho in enumerate(np.tanh(np.linspace(0.0, np.arctanh(_MOST_ALIKE), _TRIED))):
        moved = _correlated(basis, together, rho)
        along = basis.T @ moved
        kept = rows - float(np.trace(along))
        taken = 2.0 * float(np.sum(beside[:, :count] * moved)) - float(np.sum((basis.T @ beside[:, :count]) * along))
        scatter = (1.0 - rho * rho) / max(pairs, 1)
        if pairs:
            likely[k] = -0.5 * ((seen - (rho * pairs - taken) / kept) ** 2 / scatter + np.log(scatter))
        freedom[k] = max((rows - count) * (1.0 - rho * rho) / (1.0 + rho * rho), _FEWEST)
        found[k] = spread @ along @ spread.T * (squares / kept)
    best = int(np.argmax(likely))
    weight = np.exp(likely - likely[best])
    sd = np.sqrt(np.maximum(np.einsum("kii->ki", found), 1e-300))
    low, high = np.zeros(len(spread)), 1e3 * sd.max(axis=0)
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        beyond = weight @ stdtr(freedom[:, None], -middle / sd) / weight.sum() > 1.0 - _LEVEL
        low, high = np.where(beyond, middle, low), np.where(beyond, high, middle)
    wider = high / ndtri(_LEVEL) / sd[best]
    return np.asarray(found[best] * np.outer(wider, wider))


def _shares(fit: Weighed, basis: Array) -> Array:
    """Return how far each row (rows,) errs beside the rms of all: those that are stresses, and those that are none,
    each by what it leaves, where it leaves enough to tell."""
    squares = float(fit.residual @ fit.residual)
    if squares == 0.0:
        return np.ones(len(basis))
    found = np.full(len(basis), np.sqrt(squares / (len(basis) - basis.shape[1])))
    for own in (fit.model != 0.0, fit.model == 0.0):
        kept = np.count_nonzero(own) - float(np.sum(basis[own] ** 2))
        if kept >= _FEWEST:
            found[own] = np.sqrt(float(fit.residual[own] @ fit.residual[own]) / kept)
    found = np.maximum(found, _NO_SAY * found.max())
    return np.asarray(found / np.sqrt(np.mean(found**2)))


def _neighbours(values: Array, together: Flags) -> Array:
    """Return of columns (rows, q) half of what stands before and behind each row in its curve."""
    found = np.zeros_like(values)
    found[1:][together] += 0.5 * values[:-1][together]
    found[:-1][together] += 0.5 * values[1:][together]
    return found


def _correlated(values: Array, together: Flags, rho: float) -> Array:
    """Return columns (rows, q) times the correlations ``rho^|i - j|`` of rows along each curve, whose inverse has three
    diagonals; ``together`` (rows - 1,) says which rows are neighbours."""
    from scipy.linalg import solveh_banded  # replicates tell more, and do without what it takes to load

    behind, before = np.append(together, False), np.append(False, together)
    inverse = np.stack([np.where(before, -rho, 0.0), 1.0 + rho * rho * (before & behind)])
    inverse[1] -= rho * rho * ~(before | behind)
    return np.asarray(solveh_banded(inverse / (1.0 - rho * rho), values))


def by_specimen(
    fit: Weighed, change: Array, specimens: Sequence[Hashable], kinds: Sequence[Hashable]
) -> Scatter | None:
    """Return the scatter of constants that move by ``change`` (p, columns of the Jacobian); None without replicates.

    ``specimens`` and ``kinds`` say of each curve which specimen it was read on, and which specimens are replicates. A
    kind with one specimen scatters in stiffness as those of the other kinds do. Where kinds weigh differently in the
    constants, the covariance is widened so that each constant's interval has its own degrees of freedom.
    """
    J, curve = fit.jacobian, fit.curve
    length = lengths(J)
    U, s, Vt = np.linalg.svd(J / length, full_matrices=False)
    kept = s > 1e-14 * s[0]
    # What a residual of one in a row does to each constant.
    influence = (change / length) @ (Vt.T[:, kept] / s[kept]) @ U[:, kept].T
    model = fit.model
    every = [(name, np.isin(curve, [k for k, one in enumerate(specimens) if one == name]))
             for name in dict.fromkeys(specimens)]  # fmt: skip
    # Specimens of another temperature may have no say in these constants.
    heard = [(name, own) for name, own in every if np.abs(influence[:, own]).max() > _NO_SAY * np.abs(influence).max()]
    names, rows = [name for name, _ in heard], [own for _, own in heard]
    strata: dict[Hashable, list[int]] = {}
    for number, name in enumerate(names):
        own = frozenset(kind for kind, one in zip(kinds, specimens, strict=True) if one == name)
        strata.setdefault(own, []).append(number)
    groups = [group for group in strata.values() if len(group) > 1]
    if not groups:
        return None
    freedom = sum(len(group) - 1 for group in groups)
    moved = np.array([influence[:, own] @ fit.residual[own] for own in rows])
    parts, own_freedom = [], []
    for group in groups:
        away = moved[group] - moved[group].mean(axis=0)
        parts.append(away.T @ away * len(group) / (len(group) - 1))
        own_freedom.append(len(group) - 1)
    alone = [group[0] for group in strata.values() if len(group) == 1]
    if alone:
        stiffer = np.array([fit.residual[own] @ model[own] / (model[own] @ model[own]) for own in rows])
        spread = sum(float(np.sum((stiffer[g] - stiffer[g].mean()) ** 2)) for g in groups) / freedom
        for number in alone:
            whole = influence[:, rows[number]] @ model[rows[number]]
            parts.append(spread * np.outer(whole, whole))
            own_freedom.append(freedom)
    covariance = np.sum(parts, axis=0)
    diagonal = np.array([np.diag(part) for part in parts])
    total = diagonal.sum(axis=0)
    with np.errstate(all="ignore"):
        each = total**2 / (diagonal**2 / np.array(own_freedom)[:, None]).sum(axis=0)
    each = np.clip(np.where(total > 0.0, each, freedom), 1.0, freedom)
    wider = stdtrit(each, _LEVEL) / stdtrit(freedom, _LEVEL)  # quantiles of Student's t
    apart = tuple(zip(parts, own_freedom, strict=True))
    return Scatter(covariance * np.outer(wider, wider), freedom, len(names), apart)
