"""Cards of an orthotropic sheet: their own energy, read back by the solver's manual, gives the sheet's stresses."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ElementTree
from collections.abc import Callable

import numpy as np
import pytest
from scipy.optimize import minimize

from hyperfab.materials.export import NoCard, Settings, formats
from hyperfab.materials.orthotropic import Orthotropic
from hyperfab.materials.orthotropic.specimen import held, strip

GROUND = {"C10_MPa": 0.05, "C20_MPa": 0.01, "C30_MPa": 0.002}
SHEET = {**GROUND, "k1_warp_MPa": 0.2, "k2_warp": 0.3, "k1_weft_MPa": 0.07, "k2_weft": 0.0, "k1_bias_MPa": 0.1,
         "k2_bias": 0.5, "bias_deg": 35.0}  # fmt: skip
ALIKE = {"C10_MPa": 0.05, "k1_bias_MPa": 0.1, "k2_bias": 0.5, "bias_deg": 35.0}
Energy = Callable[[np.ndarray], float]


def febio(text: str) -> Energy:
    """The mixture as FEBio's manual prints it, volume kept: Yeoh, and exp-pow fibres at theta from the first axis."""
    material = ElementTree.fromstring(re.sub(r"<!--.*?-->", "", text))
    assert material.get("type") == "uncoupled solid mixture"
    assert float(material.findtext("k", "0")) > 0.0

    def energy(C: np.ndarray) -> float:
        total = 0.0
        for part in material.findall("solid"):

            def value(tag: str, part: ElementTree.Element = part) -> float:
                return float(part.findtext(tag, "nan"))

            if part.get("type") == "Yeoh":
                total += sum(value(f"c{k}") * (np.trace(C) - 3.0) ** k for k in (1, 2, 3))
                continue
            assert part.get("type") == "fiber-exp-pow-uncoupled"
            theta, phi = (np.deg2rad(value(f"mat_axis/{one}")) for one in ("theta", "phi"))
            n = np.array([np.cos(theta) * np.sin(phi), np.sin(theta) * np.sin(phi), np.cos(phi)])
            over, ksi, alpha, beta = max(n @ C @ n - 1.0, 0.0), value("ksi"), value("alpha"), value("beta")
            total += ksi / beta * (np.expm1(alpha * over**beta) / alpha if alpha > 0.0 else over**beta)
        return total

    return energy


def abaqus(text: str) -> Energy:
    """Holzapfel, Gasser and Ogden as Abaqus's manual prints it: C10 (I1 - 3) + k1/(2 k2) sum (exp(k2 <E>^2) - 1)."""
    lines = [line for line in text.splitlines() if not line.startswith("**")]
    heads = {re.match(r"\*[A-Z ]+", line)[0].strip(): k for k, line in enumerate(lines) if line[0] == "*"}
    count = int(lines[heads["*ANISOTROPIC HYPERELASTIC"]].split("DIRECTIONS=")[1])
    start = heads["*ORIENTATION"] + 3
    ways = np.array([[float(v) for v in line.split(",")] for line in lines[start : start + count]])
    values = [float(v) for v in lines[heads["*ANISOTROPIC HYPERELASTIC"] + 1].split(",")]
    C10, D, k1, k2, kappa = values
    assert (D, kappa) == (0.0, 0.0)

    def energy(C: np.ndarray) -> float:
        over = np.maximum(np.einsum("fi,ij,fj->f", ways, C, ways) - 1.0, 0.0)
        return float(C10 * (np.trace(C) - 3.0) + k1 / (2.0 * k2) * np.expm1(k2 * over**2).sum())

    return energy


READ = {"febio": febio, "abaqus": abaqus}


def tensor(angle: float, first: float, second: float, shear: float) -> np.ndarray:
    """C of a specimen at an angle from the warp; the thickness keeps the volume."""
    a = np.deg2rad(angle)
    R = np.array([[np.cos(a), -np.sin(a)], [np.sin(a), np.cos(a)]])
    C = np.zeros((3, 3))
    C[:2, :2] = R @ np.array([[first**2, shear], [shear, second**2]]) @ R.T
    C[2, 2] = 1.0 / np.linalg.det(C[:2, :2])
    return C


def pulled(energy: Energy, angle: float, stretch: float) -> float:
    """Nominal stress of a strip: by the least energy over its width and shear at stretches beside this one."""

    def least(stretch: float) -> float:
        # Free unknowns: the logarithm of the width, and the tangent of the shear, so that every state is one.
        def at(y: np.ndarray) -> float:
            width = np.exp(y[0])
            return energy(tensor(angle, stretch, np.hypot(width, width * y[1]), stretch * width * y[1]))

        found = minimize(at, (-0.5 * np.log(stretch), 0.0), method="BFGS", options={"gtol": 1e-9})
        return float(found.fun)

    return (least(stretch + 1e-3) - least(stretch - 1e-3)) / 2e-3


@pytest.mark.parametrize(("name", "constants"), [("febio", SHEET), ("febio", ALIKE), ("abaqus", ALIKE)])
def test_a_card_carries_what_the_sheet_carries(name: str, constants: dict[str, float]) -> None:
    law = Orthotropic.of(constants)
    energy = READ[name](formats()[name].card(law, Settings()))
    for angle in (0.0, 90.0, 45.0, 20.0):
        for stretch in (1.1, 1.4):
            expected = strip(law, angle, [stretch]).stress[0]
            assert pulled(energy, angle, stretch) == pytest.approx(expected, rel=2e-5)
    for first, second in ((1.3, 1.3), (1.4, 1.1), (1.2, 1.02)):
        one, two, _ = held(law, 0.0, np.array([first]), np.array([second]))
        for k, expected in enumerate((one[0], two[0])):
            step = 1e-5 * np.eye(2)[k]
            ends = [energy(tensor(0.0, *(np.array([first, second]) + sign * step), 0.0)) for sign in (1.0, -1.0)]
            assert (ends[0] - ends[1]) / 2e-5 == pytest.approx(expected, rel=1e-7)


@pytest.mark.parametrize("name", sorted(formats()))
def test_a_sheet_without_threads_is_the_isotropic_card(name: str) -> None:
    from hyperfab.materials import bind

    one = formats()[name]
    assert one.card(Orthotropic.of(GROUND), Settings()) == one.card(bind("yeoh-3", GROUND), Settings())


@pytest.mark.parametrize(
    ("name", "constants", "words"),
    [
        ("ansys", ALIKE, ["tension alone"]),
        ("ls-dyna", ALIKE, ["tension alone"]),
        ("abaqus", SHEET, ["C20_MPa", "C30_MPa"]),
        ("abaqus", {**SHEET, "C20_MPa": 0.0, "C30_MPa": 0.0}, ["one k1"]),
        ("febio", {**SHEET, "G_MPa": 0.1, "nu": 0.3, "C2_MPa": 0.02}, ["G_MPa 0.1", "nu 0.3", "C2_MPa 0.02"]),
    ],
)
def test_what_a_card_cannot_hold_is_said(name: str, constants: dict[str, float], words: list[str]) -> None:
    with pytest.raises(NoCard) as refused:
        formats()[name].card(Orthotropic.of(constants), Settings())
    for word in words:
        assert word in str(refused.value)


def test_names_in_an_abaqus_card_have_80_characters_at_most() -> None:
    text = formats()["abaqus"].card(Orthotropic.of(ALIKE), Settings(name="x" * 80))
    names = re.findall(r"NAME=([^,\n]+)", text)
    assert len(names) == 2
    assert max(map(len, names)) == 80
    assert f"ORIENTATION={names[0]};" in text
