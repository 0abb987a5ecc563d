"""Cards mean the same law: each is read back by its solver's own convention and gives the same stresses."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest
from laws.constants import CONSTANTS
from scipy.optimize import brentq

from hyperfab.materials import Material, bind, laws
from hyperfab.materials.export import NoCard, Settings, formats
from hyperfab.materials.export.card import field
from hyperfab.materials.hyperfoam import Hyperfoam

L1, L2 = np.array([1.2, 2.0, 3.0]), np.array([1.1, 0.8, 1.5])
CASES = [(one, law) for one in sorted(formats()) for law in formats()[one].writers]


def law_of(name: str) -> Material:
    return bind(name, dict(zip(laws()[name].names, CONSTANTS[name], strict=True)))


def stress_of(energy, l1=L1, l2=L2):
    """dW/dl1 of an energy of three stretches, the thickness stretch from zero stress across the sheet."""

    def at(first):
        low, high = np.full_like(first, 0.02), np.full_like(first, 3.0)
        for _ in range(80):
            middle = 0.5 * (low + high)
            step = 1e-6 * middle
            up = energy(first, l2, middle + step) - energy(first, l2, middle - step) > 0.0
            low, high = np.where(up, low, middle), np.where(up, middle, high)
        return energy(first, l2, 0.5 * (low + high))

    step = 1e-4
    return (at(l1 - 2 * step) - 8 * at(l1 - step) + 8 * at(l1 + step) - at(l1 + 2 * step)) / (12 * step)


def kept_volume(energy):
    """dW/dl1 of an energy of three stretches whose product stays 1."""

    def at(first):
        return energy(first, L2, 1.0 / (first * L2))

    step = 1e-4
    return (at(L1 - 2 * step) - 8 * at(L1 - step) + 8 * at(L1 + step) - at(L1 + 2 * step)) / (12 * step)


def invariants(a, b, c):
    return a**2 + b**2 + c**2, a**2 * b**2 + b**2 * c**2 + a**2 * c**2


def polynomial(terms):
    def energy(a, b, c):
        I1, I2 = invariants(a, b, c)
        return sum(value * (I1 - 3) ** i * (I2 - 3) ** j for (i, j), value in terms.items())

    return energy


def powers(terms):
    return lambda a, b, c: sum(factor * (a**n + b**n + c**n - 3) for factor, n in terms)


def chains(mu, lambda_m):
    """The series as the solvers' manuals print it."""
    C = (1 / 2, 1 / 20, 11 / 1050, 19 / 7000, 519 / 673750)
    return lambda a, b, c: (
        mu * sum(k * (invariants(a, b, c)[0] ** i - 3**i) / lambda_m ** (2 * i - 2) for i, k in enumerate(C, 1))
    )


def gent(mu, limit):
    return lambda a, b, c: -mu * limit / 2 * np.log(1 - (invariants(a, b, c)[0] - 3) / limit)


def foam(terms):
    """Terms of factor (sum l^n - 3 + (J^(-n beta) - 1)/beta), where beta is 0 its limit -n ln J."""

    def of_volume(J, n, beta):
        return (J ** (-n * beta) - 1) / beta if beta else -n * np.log(J)

    return lambda a, b, c: sum(
        factor * (a**n + b**n + c**n - 3 + of_volume(a * b * c, n, beta)) for factor, n, beta in terms
    )


ORDER = ((1, 0), (0, 1), (2, 0), (1, 1), (0, 2), (3, 0), (2, 1), (1, 2), (0, 3))


def read_abaqus(card: str):
    lines = [line for line in card.splitlines() if not line.startswith("**")]
    at = next(k for k, line in enumerate(lines) if line.startswith("*HYPER"))
    keyword, values = (
        lines[at],
        [float(v) for line in lines[at + 1 :] if line[0] != "*" for v in line.split(",")],
    )
    order = int(match[1]) if (match := re.search(r"N=(\d)", keyword)) else 1
    if "NEO HOOKE" in keyword:
        return polynomial({(1, 0): values[0]})
    if "REDUCED" in keyword:
        assert len(values) == 2 * order
        return polynomial({(i + 1, 0): values[i] for i in range(order)})
    if "POLYNOMIAL" in keyword:
        count = {1: 2, 2: 5, 3: 9}[order]
        assert len(values) == count + order
        return polynomial(dict(zip(ORDER[:count], values, strict=False)))
    if "OGDEN" in keyword:
        assert len(values) == 3 * order
        return powers(
            [(2 * mu / n**2, n) for mu, n in zip(values[: 2 * order : 2], values[1 : 2 * order : 2], strict=True)]
        )
    if "ARRUDA" in keyword:
        return chains(*values[:2])
    assert "HYPERFOAM" in keyword
    nus = values[2 * order :]
    return foam(
        [
            (2 * values[2 * k] / values[2 * k + 1] ** 2, values[2 * k + 1], nus[k] / (1 - 2 * nus[k]))
            for k in range(order)
        ]
    )


def read_ansys(card: str):
    head = next(line for line in card.splitlines() if line.startswith("TB,")).split(",")
    values = [float(v) for line in card.splitlines() if line.startswith("TBDATA") for v in line.split(",")[2:]]
    kind, order = head[5], int(head[4] or 1)
    if kind == "NEO":
        return polynomial({(1, 0): values[0] / 2})
    if kind == "MOONEY":
        places = {2: ORDER[:2], 3: ((1, 0), (0, 1), (1, 1)), 5: ORDER[:5], 9: ORDER}[order]
        assert len(values) == order + 1
        return polynomial(dict(zip(places, values, strict=False)))
    if kind == "YEOH":
        return polynomial({(i + 1, 0): values[i] for i in range(order)})
    if kind == "OGDEN":
        return powers([(values[2 * k] / values[2 * k + 1], values[2 * k + 1]) for k in range(order)])
    if kind == "BOYCE":
        return chains(*values[:2])
    if kind == "GENT":
        return gent(*values[:2])
    if kind == "BLATZ":

        def energy(a, b, c):
            J2 = (a * b * c) ** 2
            return values[0] / 2 * (invariants(a, b, c)[1] / J2 + 2 * np.sqrt(J2) - 5)

        return energy
    assert kind == "FOAM"
    return foam([(values[2 * k] / values[2 * k + 1], values[2 * k + 1], values[2 * order + k]) for k in range(order)])


def read_ls_dyna(card: str):
    lines = [line for line in card.splitlines() if not line.startswith("$")]
    assert lines[0].endswith("_TITLE +")
    rows = [[float(line[k : k + 20]) for k in range(0, len(line), 20)] for line in lines[2:]]
    if "HYPERELASTIC" in lines[0]:
        return polynomial(dict(zip(((1, 0), (0, 1), (1, 1), (2, 0), (0, 2), (3, 0)), rows[1], strict=True)))
    if "OGDEN" in lines[0]:
        return powers([(mu / n, n) for mu, n in zip(rows[1], rows[2], strict=True) if mu])
    if "ARRUDA" in lines[0]:
        return chains(rows[0][3], rows[0][4] ** 0.5)
    assert "HILL" in lines[0]
    # The bulk modulus at rest goes with the others: 2 G (1 + nu)/(3 (1 - 2 nu)), where n = nu/(1 - 2 nu) and
    # 2 G is the sum of c b.
    nu = rows[0][3] / (1.0 + 2.0 * rows[0][3])
    two_G = sum(c * b for c, b in zip(rows[1], rows[2], strict=True))
    assert rows[0][2] == pytest.approx(two_G * (1.0 + nu) / (3.0 * (1.0 - 2.0 * nu)), rel=1e-9)
    return foam([(c / b, b, rows[0][3]) for c, b in zip(rows[1], rows[2], strict=True) if c])


def read_febio(card: str):
    found = ElementTree.fromstring(re.sub(r"<!--.*?-->", "", card))
    values = {child.tag: float(child.text or "nan") for child in found}
    kind = found.get("type")
    if kind == "Ogden unconstrained":
        assert values["cp"] == 0.0
        return foam(
            [(values[f"c{k}"] / values[f"m{k}"] ** 2, values[f"m{k}"], 0.0) for k in range(1, 7) if f"c{k}" in values]
        )
    assert values["k"] > 0.0
    if kind == "Mooney-Rivlin":
        return polynomial({(1, 0): values["c1"], (0, 1): values["c2"]})
    if kind == "Yeoh":
        return polynomial({(k, 0): values[f"c{k}"] for k in range(1, 7) if f"c{k}" in values})
    if kind == "Ogden":
        return powers(
            [(values[f"c{k}"] / values[f"m{k}"] ** 2, values[f"m{k}"]) for k in range(1, 7) if f"c{k}" in values]
        )
    assert kind == "Gent"
    return gent(values["G"], values["Jm"])


READERS = {"abaqus": read_abaqus, "ansys": read_ansys, "ls-dyna": read_ls_dyna, "febio": read_febio}


@pytest.mark.parametrize(("solver", "name"), CASES)
def test_card_read_by_the_solver_s_convention_gives_the_same_stress(solver: str, name: str) -> None:
    material = law_of(name)
    card = formats()[solver].card(material, Settings(comments=("of -- a --- test",)))
    expected = material.membrane(L1, L2).P1
    if "MARLOW" in card:
        rows = np.array([[float(v) for v in line.split(",")] for line in card.split("TEST DATA\n")[1].splitlines()])
        # Marlow's law knows one curve: the uniaxial one, which fixes a law of I1.
        np.testing.assert_allclose(material.uniaxial(1 + rows[:, 1]).P, rows[:, 0], rtol=1e-14, atol=1e-16)
        assert (np.diff(rows[:, 1]) > 0).all()
        return
    energy = READERS[solver](card)
    found = stress_of(energy) if name.startswith("blatz") else kept_volume(energy)
    # Differences of the energy, fourth order.
    np.testing.assert_allclose(found, expected, rtol=2e-6 if name.startswith("blatz") else 1e-8)


def slope(energy, at: float) -> float:
    """Derivative by a step into the complex plane, to all digits."""
    return float(np.imag(energy(at + 1e-30j)) / 1e-30)


def foam_tests(energy, x: float) -> dict[str, float]:
    """What an energy of three stretches reads at a stretch, shear strain or volume ratio ``x``."""

    def free(of) -> float:
        return brentq(lambda side: slope(of, side), 0.1, 8.0, xtol=1e-15, rtol=1e-15)

    side = free(lambda t: energy(x, t, t))
    thin, thinner = free(lambda t: energy(x, 1.0, t)), free(lambda t: energy(x, x, t))

    def sheared(gamma):
        first = np.exp(np.arcsinh(0.5 * gamma))
        return energy(first, 1.0 / first, 1.0)

    return {
        "uniaxial": slope(lambda l1: energy(l1, side, side), x),
        "lateral": side,
        "confined-compression": slope(lambda l1: energy(l1, 1.0, 1.0), x),
        "shear": slope(lambda l1: energy(l1, 1.0, thin), x),
        "biaxial": slope(lambda l1: energy(l1, x, thinner), x),
        "simple-shear": slope(sheared, x),
        "volumetric": slope(lambda J: energy(*[J ** (1 / 3)] * 3), x),
    }


FOAMS = {
    "one": Hyperfoam((0.1,), (8.0,), (0.1,)),
    "auxetic": Hyperfoam((0.1,), (-3.0,), (-0.25,)),
    "alike": Hyperfoam((0.1, 0.05), (8.0, -2.0), (0.23, 0.23)),
    "signed": Hyperfoam((0.1, 0.05, -0.01), (8.0, -2.0, 3.0), (0.1, 0.3, -0.2)),
    "of no contraction": Hyperfoam((0.1, 0.0, 0.05), (8.0, 3.0, -2.0), (0.0, 0.3, 0.0)),
}


@pytest.mark.parametrize("name", FOAMS)
@pytest.mark.parametrize("solver", sorted(formats()))
def test_a_foam_s_card_answers_every_test_as_the_law(solver: str, name: str) -> None:
    law = FOAMS[name]
    held = {"febio": name == "of no contraction", "ls-dyna": name != "signed"}
    if not held.get(solver, True):
        with pytest.raises(NoCard, match=r"0\.1, 0\.3, -0\.2|not "):
            formats()[solver].card(law, Settings())
        return
    energy = READERS[solver](formats()[solver].card(law, Settings(comments=("of -- a --- test",))))
    for x in (0.5, 0.9, 1.3, 1.7):
        for test, found in foam_tests(energy, x).items():
            expected = law.lateral("uniaxial", [x]) if test == "lateral" else law.stress(test, [x])
            assert found == pytest.approx(float(expected[0]), rel=1e-9), (test, x)


def test_a_law_the_solver_lacks_is_refused_with_those_it_has() -> None:
    with pytest.raises(NoCard, match="yeoh-3"):
        formats()["febio"].card(law_of("mooney-rivlin-9"), Settings())


@pytest.mark.parametrize("value", [0.0, -1.0 / 3.0, 1e-300, -2.5e17, 123456789.123456789])
def test_fields_keep_their_width_and_as_many_digits_as_fit(value: float) -> None:
    for width in (10, 20):
        text = field(value, width)
        assert len(text) == width
        assert float(text) == pytest.approx(value, rel=10.0 ** (8 - width))


def test_bulk_modulus_becomes_the_solver_s_constant() -> None:
    settings = Settings(bulk_modulus=500.0)
    assert "0.2, 0.004" in formats()["abaqus"].card(law_of("neo-hookean"), settings)
    assert "TBDATA,1,0.4,0.004" in formats()["ansys"].card(law_of("neo-hookean"), settings)
    assert "<k>500.0</k>" in formats()["febio"].card(law_of("neo-hookean"), settings)


@pytest.mark.parametrize("K", [500.0, 1e20])
def test_poisson_s_ratio_is_that_of_the_bulk_modulus_and_below_a_half(K: float) -> None:
    """At 1/2 a solver divides by zero."""
    settings = Settings(bulk_modulus=K)
    rubber = formats()["ls-dyna"].card(law_of("neo-hookean"), settings).splitlines()[3]
    curve = re.search(r"POISSON=(\S+)", formats()["abaqus"].card(law_of("gent"), settings))
    assert curve is not None
    for nu, mu in ((float(rubber[40:60]), 0.4), (float(curve[1]), 0.27)):
        assert nu < 0.5
        assert nu == pytest.approx((3.0 * K - 2.0 * mu) / (6.0 * K + 2.0 * mu), rel=1e-14)


@pytest.mark.parametrize("name", ["gent", "arruda-boyce-langevin"])
@pytest.mark.parametrize("share", [3.0, 0.5, 0.03, 1e-5])
def test_a_curve_stays_within_the_law_s_limit_and_follows_it(name: str, share: float) -> None:
    """A chain that locks early locks in compression too; between two points Abaqus draws a straight line."""
    limit = share if name == "gent" else (1.0 + share / 3.0) ** 0.5
    material = bind(name, dict(zip(laws()[name].names, (0.3, limit), strict=True)))
    card = formats()["abaqus"].card(material, Settings())
    rows = np.array([[float(v) for v in line.split(",")] for line in card.split("TEST DATA\n")[1].splitlines()])
    assert np.isfinite(rows).all()
    assert (np.diff(rows, axis=0) > 0.0).all()
    strain = 0.5 * (rows[1:, 1] + rows[:-1, 1])
    between = 0.5 * (rows[1:, 0] + rows[:-1, 0])
    np.testing.assert_allclose(between, material.uniaxial(1.0 + strain).P, rtol=0.005)
    # The stiffness at rest: a thousandth of the way.
    small = 1e-3 * np.array([strain.min(), strain.max()])
    found = np.interp(small, rows[:, 1], rows[:, 0])
    np.testing.assert_allclose(found, material.uniaxial(1.0 + small).P, rtol=3e-3)
    # Most of the way to where the law ends.
    lam = 1.0 + rows[-1, 1]
    assert not np.isfinite(material.uniaxial(1.0 + 1.03 * (lam - 1.0)).P)
