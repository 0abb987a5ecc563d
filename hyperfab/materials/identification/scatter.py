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
from scipy.special import stdtrit

from hyperfab.arrays import Ints
from hyperfab.materials.law import Array

#: Where intervals are to cover: both tails of 95 %.
_LEVEL = 0.975
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
    parts: tuple[tuple[Array, int], ...] = ()

    def reordered(self, order: Sequence[int]) -> Scatter:
        """Return the scatter of the constants in another order."""
        square = np.ix_(order, order)
        parts = tuple((one[square], freedom) for one, freedom in self.parts)
        return replace(self, covariance=self.covariance[square], parts=parts)


@dataclass(frozen=True)
class Weighed:
    """A least-squares optimum: ``jacobian`` (rows, q) and ``residual`` (rows,) of the weighted equations.

    ``model`` (rows,) is the weighted stress the law gives, zero in rows that are none; ``curve`` each row's curve.
    """

    jacobian: Array
    residual: Array
    model: Array
    curve: Ints


def by_specimen(
    fit: Weighed, change: Array, specimens: Sequence[Hashable], kinds: Sequence[Hashable]
) -> Scatter | None:
    """Return the scatter of constants that move by ``change`` (p, columns of the Jacobian); None without replicates.

    ``specimens`` and ``kinds`` say of each curve which specimen it was read on, and which specimens are replicates. A
    kind with one specimen scatters in stiffness as those of the other kinds do. Where kinds weigh differently in the
    constants, the covariance is widened so that each constant's interval has its own degrees of freedom.
    """
    J, curve = fit.jacobian, fit.curve
    length = np.sqrt((J * J).sum(axis=0))
    length = np.where(length > 0.0, length, 1.0)
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
