"""The laws by name. A law is one module in ``hyperfab.materials.laws`` that lists its instances as ``LAWS``."""

from __future__ import annotations

import importlib
import math
import pkgutil
from collections.abc import Mapping, Sequence
from functools import cache

from hyperfab.errors import InputError, UsageError, near
from hyperfab.materials import laws as _folder
from hyperfab.materials.hyperfoam import ORDERS, Hyperfoam, HyperfoamLaw
from hyperfab.materials.hyperfoam import TESTS as FOAM_TESTS
from hyperfab.materials.law import Law
from hyperfab.materials.material import Material
from hyperfab.materials.modes import OF_A_SHEET, SIMPLE_SHEAR


@cache
def laws() -> dict[str, Law]:
    """Return every law by its name, in the order of their files.

    >>> "neo-hookean" in laws()
    True
    """
    found: dict[str, Law] = {}
    for module in pkgutil.iter_modules(_folder.__path__):
        for law in importlib.import_module(f"{_folder.__name__}.{module.name}").LAWS:
            found[law.name] = law
    return found


def law(name: str) -> Law:
    """Return the law called ``name``; UsageError with the known names where there is none.

    >>> law("yeoh-2").names
    ('C10_MPa', 'C20_MPa')
    """
    if name not in laws():
        known = [*laws(), "orthotropic", *ORDERS]
        hint = near(name, known)
        said = f"no model {name!r}; {hint} the models are {', '.join(known)}"
        raise UsageError(said.replace(";  ", "; "))
    return laws()[name]


def carried_by(name: str) -> Sequence[str]:
    """Return the kinds of tests that the law called ``name`` carries, or some law of ``all``.

    >>> "simple-shear" in carried_by("ogden-1"), "simple-shear" in carried_by("blatz-ko")
    (True, False)
    """
    if name in ORDERS:
        return FOAM_TESTS
    sheared = name == "all" or (name != "orthotropic" and law(name).carries_simple_shear)
    return (*OF_A_SHEET, SIMPLE_SHEAR) if sheared else OF_A_SHEET


def bind(name: str, parameters: Mapping[str, float], anisotropic: bool = False) -> Material:
    """Return the material: the law called ``name`` with its constants, keyed as in a material document.

    Raises InputError naming the law that is unknown, the constant that is missing, unknown, not a finite number or
    without meaning, and where the constants have no stiffness at rest. A law with directions of its own is refused
    unless the caller, with ``anisotropic``, says that it lays the material's first axis along the fabric's.

    >>> bind("mooney-rivlin-2", {"C10_MPa": 0.16, "C01_MPa": 0.01}).c
    (0.16, 0.01)
    """
    found = law_of(name, parameters, anisotropic)
    c, theta = found.split(parameters)
    material = Material(found, tuple(c), tuple(theta))
    modulus = stiffness_at_rest(found, parameters)
    if not 0.0 < modulus < math.inf:
        raise InputError(
            f"these constants of {name} have no stiffness at rest (Young's modulus {modulus:.3g} MPa)",
            key="parameters",
            remedy="fit the fabric again with --stable, or correct the constants",
        )
    return material


def law_of(name: str, parameters: Mapping[str, float], anisotropic: bool = False, foam: bool = False) -> Law:
    """Return the law called ``name`` whose constants these are; for those who fit them again, whatever their stiffness.

    Raises InputError as ``bind`` does, save for the stiffness at rest; for the law of a ``foam`` where that is taken.

    >>> law_of("yeoh-2", {"C10_MPa": -0.1, "C20_MPa": 0.3}).names
    ('C10_MPa', 'C20_MPa')
    """
    if name == "orthotropic":
        raise InputError(
            "orthotropic is a law of the whole sheet, one of a single direction is needed here",
            key="model",
            remedy="fit warp and weft with a law as yeoh-3",
        )
    if name in ORDERS and not foam:
        raise InputError(
            f"{name} is the law of a foam, a fabric's is needed here",
            key="model",
            remedy="hf press-contact takes it as foam; fit the fabric's own tests",
        )
    if name not in laws() and name not in ORDERS:
        hint = near(name, laws())
        raise InputError(
            f"there is no law {name!r}",
            key="model",
            remedy=f"{hint} the laws are {', '.join(laws())}".strip(),
        )
    found = HyperfoamLaw(ORDERS[name]) if name in ORDERS else law(name)
    if not found.isotropic and not anisotropic:
        raise InputError(
            f"{name} is a law with directions, an isotropic one is needed here",
            key="model",
            remedy="fit warp and weft with a law as yeoh-3",
        )
    for key in parameters:
        if key not in found.names:
            raise InputError(f"is no constant of {name}", key=key, remedy=f"it has {', '.join(found.names)}")
    for key in found.names:
        value = parameters.get(key)
        if value is None:
            raise InputError(f"is missing: {name} has {', '.join(found.names)}", key=key)
        if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
            raise InputError(f"is not a finite number: {value!r}", key=key)
    complaint = found.refusal(parameters)
    if complaint is not None:
        raise InputError(f"these constants have no meaning in {name}: {complaint}", key="parameters")
    return found


def stiffness_at_rest(found: Law, parameters: Mapping[str, float]) -> float:
    """Return Young's modulus [MPa] of a law with these constants, negative where it would give way by itself.

    >>> round(stiffness_at_rest(law("yeoh-1"), {"C10_MPa": -0.1}), 2)
    -0.6
    """
    if isinstance(found, HyperfoamLaw):
        return Hyperfoam.of(parameters).youngs_modulus
    c, theta = found.split(parameters)
    # A hair beyond rest, where fibres that bear tension only have begun to.
    return float(Material(found, tuple(c), tuple(theta)).uniaxial(1.0 + 1e-4).A)
