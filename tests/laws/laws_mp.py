"""The strain energies once more, in 50 digits and in all three stretches, as the papers print them."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import mpmath as mp

mp.mp.dps = 50

Constants = Mapping[str, mp.mpf]


def _invariants(a, b, c):
    return a**2 + b**2 + c**2, a**2 * b**2 + b**2 * c**2 + a**2 * c**2


def _polynomial(p: Constants, I1, I2):
    return sum(
        value * (I1 - 3) ** int(name[1]) * (I2 - 3) ** int(name[2])
        for name, value in p.items()
        if name.startswith("C") and name[2].isdigit()
    )


def _gent(p, I1, I2):
    return -p["mu_MPa"] * p["Im"] / 2 * mp.log(1 - (I1 - 3) / p["Im"])


def _inverse_langevin(r):
    # From Cohen's rational approximation, which Newton's method never leaves far.
    return mp.findroot(lambda b: mp.coth(b) - 1 / b - r, r * (3 - r**2) / (1 - r**2))


def _chains(p, I1, I2):
    N = p["lambda_m"] ** 2

    def energy(first):
        r = mp.sqrt(first / (3 * N))
        b = _inverse_langevin(r)
        return p["mu_MPa"] * N * (b * r + mp.log(b / mp.sinh(b)))

    return energy(I1) - energy(mp.mpf(3))


def _arruda(p, I1, I2):
    C = [mp.mpf(1) / 2, mp.mpf(1) / 20, mp.mpf(11) / 1050, mp.mpf(19) / 7000, mp.mpf(519) / 673750]
    return p["mu_MPa"] * sum(c * (I1**i - mp.mpf(3) ** i) / p["lambda_m"] ** (2 * i - 2) for i, c in enumerate(C, 1))


def _log_i2(p, I1, I2):
    return p["C2_MPa"] * mp.log(I2 / 3)


def _carroll(p, I1, I2):
    return p["A_MPa"] * (I1 - 3) + p["B_MPa"] * (I1**4 - 81) + p["C_MPa"] * (mp.sqrt(I2) - mp.sqrt(3))


def _alexander(p, I1, I2):
    k, g = p["k"], p["gamma"]
    growth = mp.sqrt(mp.pi / k) / 2 * mp.erfi(mp.sqrt(k) * (I1 - 3))
    return p["C1_MPa"] * growth + p["C2_MPa"] * mp.log((I2 - 3 + g) / g) + p["C3_MPa"] * (I2 - 3)


def _by_invariants(*parts):
    return lambda p, a, b, c: sum(part(p, *_invariants(a, b, c)) for part in parts)


def _ogden(p, a, b, c):
    order = len(p) // 2
    total = mp.mpf(0)
    for r in range(1, order + 1):
        mu, alpha = p[f"mu{r}_MPa"], p[f"alpha{r}"]
        total += mu / alpha * (a**alpha + b**alpha + c**alpha - 3)
    return total


def _tube(p, a, b, c):
    I1, _ = _invariants(a, b, c)
    d, beta = p["delta"] ** 2, p["beta"]
    links = (1 - d) * (I1 - 3) / (1 - d * (I1 - 3)) + mp.log(1 - d * (I1 - 3))
    return p["Gc_MPa"] / 2 * links + 2 * p["Ge_MPa"] / beta**2 * (a**-beta + b**-beta + c**-beta - 3)


def _blatz_ko(p, a, b, c):
    f, nu, mu = p["f"], p["nu"], p["mu_MPa"]
    I1, I2 = _invariants(a, b, c)
    J, beta = a * b * c, nu / (1 - 2 * nu)
    first = I1 - 3 + (J ** (-2 * beta) - 1) / beta
    return mu * f / 2 * first + mu * (1 - f) / 2 * (I2 / J**2 - 3 + (J ** (2 * beta) - 1) / beta)


_POLY = _by_invariants(_polynomial)
ENERGY: dict[str, Callable] = {
    **dict.fromkeys(("neo-hookean", "yeoh-1", "yeoh-2", "yeoh-3"), _POLY),
    **{f"mooney-rivlin-{n}": _POLY for n in (2, 3, 5, 9)},
    **{f"ogden-{n}": _ogden for n in (1, 2, 3)},
    "gent": _by_invariants(_gent),
    "gent-gent": _by_invariants(_gent, _log_i2),
    "yeoh-3-lni2": _by_invariants(_polynomial, _log_i2),
    "arruda-boyce": _by_invariants(_arruda),
    "arruda-boyce-langevin": _by_invariants(_chains),
    "arruda-boyce-lni2": _by_invariants(_chains, _log_i2),
    "carroll": _by_invariants(_carroll),
    "alexander": _by_invariants(_alexander),
    "extended-tube": _tube,
    "blatz-ko": _blatz_ko,
    "blatz-ko-general": _blatz_ko,
}


def energy(name: str, parameters: Mapping[str, float], l1, l2):
    """W [MPa] of the sheet, the thickness stretch from zero stress across it."""
    p = {key: mp.mpf(value) for key, value in parameters.items()}
    l1, l2 = mp.mpf(l1), mp.mpf(l2)
    l3 = (l1 * l2) ** (-p["nu"] / (1 - p["nu"])) if name.startswith("blatz") else 1 / (l1 * l2)
    return ENERGY[name](p, l1, l2, l3)


def stress(name: str, parameters: Mapping[str, float], mode: str, stretch) -> mp.mpf:
    """Nominal stress along the loading direction, by differentiating the energy along it."""
    lam = mp.mpf(stretch)
    nu = mp.mpf(parameters["nu"]) if name.startswith("blatz") else mp.mpf(1) / 2
    second = {"uniaxial": lam**-nu, "shear": mp.mpf(1), "biaxial": lam}[mode]
    step = mp.mpf(10) ** -20
    rise = energy(name, parameters, lam + step, second) - energy(name, parameters, lam - step, second)
    return rise / (2 * step)
