"""Two directions with constants of their own."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from hyperfab.materials.effects.path import UNIAXIAL, Path, second_stretch
from hyperfab.materials.effects.smooth import CLOSER, through
from hyperfab.materials.effects.threads import nearest_ground
from hyperfab.materials.law import Array, Law, scaled

#: Stress [MPa] and energy [MPa] of every row.
Answer = tuple[Array, Array]
#: What a law with these constants answers.
OfLaw = Callable[[Array], Answer]


def fibres(path: Path, stretch: Array, warp: float, weft: float, growth: float) -> tuple[Array, Array]:
    """Return stress [MPa] and energy of fibres along warp and weft: ``sum k/(2 g) (exp(g <I4 - 1>^2) - 1)``.

    ``warp`` and ``weft`` are their stiffness k [MPa], ``growth`` g how they stiffen; they bear tension only. The ground
    contracts as if it were alone. Holzapfel, Gasser & Ogden (2000), doi:10.1023/A:1010835316564; at ``growth`` 0 the
    standard reinforcing model.
    """
    share = path.weft_share
    across = second_stretch(path.mode, stretch, stretch**-0.5, path.across)
    stress, energy = np.zeros_like(stretch), np.zeros_like(stretch)
    for stiffness, along in ((warp, 1.0 - share), (weft, share)):
        strain = np.maximum(stretch**2 * along + across**2 * (1.0 - along) - 1.0, 0.0)
        grown = np.exp(np.minimum(growth * strain**2, 300.0))
        stress = stress + 2.0 * stiffness * along * stretch * strain * grown
        shape = np.expm1(np.minimum(growth * strain**2, 300.0)) / growth if growth else strain**2
        energy = energy + 0.5 * stiffness * shape
    return stress, energy


def between(path: Path, warp: Answer, weft: Answer) -> Answer:
    """Return what lies between the answers of warp and weft, by the direction of each row."""
    share = path.weft_share
    stress, energy = (_mixed(share, *pair) for pair in zip(warp, weft, strict=True))
    return stress, energy


def _mixed(share: Array, warp: Array, weft: Array) -> Array:
    """Return what lies between: along an axis it is the axis's own to the bit, whatever the other one answers.

    A limiting law of the other axis may have no answer so far.
    """
    return np.where(share == 0.0, warp, np.where(share == 1.0, weft, warp + share * (weft - warp)))


class Directions:
    """A form of the effect, for rows and for a document. ``told_by`` is the key of a document that tells it.

    nearly  constants of the law along warp and weft come near to it only
    whole   one law of the whole sheet tells it: it has no constants along warp and weft
    """

    told_by = "directions"
    nearly = whole = False

    def absent(self, values: Array) -> bool:
        """Whether it stands at a null that would leave rounding behind."""
        return False

    def answer(self, of: OfLaw, path: Path, stretch: Array, warp: Array, values: Array) -> Answer:
        """Return what the sheet answers whose warp has the constants ``warp``."""
        raise NotImplementedError

    def weft(self, law: Law, warp: Mapping[str, float], values: Array) -> dict[str, float]:
        """Return the constants along the weft."""
        raise NotImplementedError

    def constants(self, law: Law, ground: Mapping[str, float], values: Array) -> dict[str, float]:
        """Return those of one energy of the whole sheet, whose ground is ``law`` with the constants ``ground``."""
        raise NotImplementedError


class Ratio(Directions):
    """All stresses along the weft are those along the warp times one number."""

    def answer(self, of: OfLaw, path: Path, stretch: Array, warp: Array, values: Array) -> Answer:
        stress, energy = of(warp)
        factor = 1.0 + path.weft_share * (values[0] - 1.0)
        return stress * factor, energy * factor

    def weft(self, law: Law, warp: Mapping[str, float], values: Array) -> dict[str, float]:
        return scaled(warp, float(values[0]))


class Ratios(Ratio):
    """The same, and of a strip between warp and weft stresses are more than their mean by a share of those along the
    warp: it shears, as a sheet that is held on all sides does not."""

    nearly = True

    def answer(self, of: OfLaw, path: Path, stretch: Array, warp: Array, values: Array) -> Answer:
        stress, energy = of(warp)
        bias = path.bias_share * (path.mode == UNIAXIAL)
        factor = 1.0 + path.weft_share * (values[0] - 1.0) + bias * values[1]
        return stress * factor, energy * factor


class Constants(Directions):
    """Each constant along the weft is that along the warp and a number more."""

    def answer(self, of: OfLaw, path: Path, stretch: Array, warp: Array, values: Array) -> Answer:
        return between(path, of(warp), of(np.asarray(warp) + np.asarray(values)))

    def weft(self, law: Law, warp: Mapping[str, float], values: Array) -> dict[str, float]:
        return {name: warp[name] + float(value) for name, value in zip(law.names, values, strict=False)}


@dataclass(frozen=True)
class Fibres(Directions):
    """Fibres in a ground: ``of`` gives their stiffness along warp and weft and their growth, the last of the constants.

    Those before them are the ground's along the weft, as ``beside`` has them.
    """

    of: Callable[..., tuple[float, float, float]]
    count: int
    beside: Directions | None = None
    nearly = True

    def answer(self, of: OfLaw, path: Path, stretch: Array, warp: Array, values: Array) -> Answer:
        """Return what ground and fibres answer together."""
        own, rest = values[-self.count :], values[: -self.count]
        ground = of(warp) if self.beside is None else self.beside.answer(of, path, stretch, warp, rest)
        stress, energy = fibres(path, stretch, *self.of(*map(float, own)))
        return ground[0] + stress, ground[1] + energy


@dataclass(frozen=True)
class Smooth(Directions):
    """The law's stress times ``exp(sum g h)``, over the first ``count`` of four functions h of the angle from the warp,
    ``sin^2 a, sin^2 2a, sin^2 2a cos 2a, sin^2 4a``, each with a smooth function g of the stretch.

    After the strain ``reach`` the constants are, for each g, its value at rest and what it is more at even parts of
    ``ln(1 + CLOSER ln stretch)`` up to there. That is of strips: a sheet held on all sides does not shear, and is
    between warp and weft as it is for other forms.
    """

    count: int
    nearly = True

    def answer(self, of: OfLaw, path: Path, stretch: Array, warp: Array, values: Array) -> Answer:
        """Return what the sheet answers whose warp has the constants ``warp``."""
        stress, energy = of(warp)
        far = np.log1p(CLOSER * np.abs(np.log(stretch))) / np.log1p(CLOSER * np.log1p(values[0]))
        weft, bias = path.weft_share, path.bias_share
        ways = (weft, bias, bias * (1.0 - 2.0 * weft), 4.0 * bias * (1.0 - bias))
        each = [one[0] + through(far, one[1:]) for one in values[1:].reshape(self.count, -1)]
        more = sum(way * one for way, one in zip(ways, each, strict=False))
        # Trials of a fit go anywhere; no factor of a fabric does.
        strip, square = (np.exp(np.clip(one, -20.0, 20.0)) for one in (more, each[0]))
        factor = np.where(path.mode == UNIAXIAL, strip, 1.0 + weft * (square - 1.0))
        return stress * factor, energy * factor


@dataclass(frozen=True)
class WholeSheet(Directions):
    """Threads in a ground, as one energy of the whole sheet, Orthotropic, with these of its constants; ``k2`` is that
    of warp and weft. The ground is the law, or what comes nearest to it up to the strain ``reach``."""

    names: tuple[str, ...]
    told_by = "model"
    nearly = whole = True

    def absent(self, values: Array) -> bool:
        """Whether no thread and no shear stiffness is there."""
        return not any(value for name, value in zip(self.names, values, strict=True) if name.endswith("_MPa"))

    def constants(self, law: Law, ground: Mapping[str, float], values: Array) -> dict[str, float]:
        """Return the constants of the orthotropic energy."""
        own = dict(zip(self.names, map(float, values), strict=True))
        if (reach := own.pop("reach", None)) is not None:
            ground = nearest_ground(law, ground, reach)
        if "k2" in own:
            own["k2_warp"] = own["k2_weft"] = own.pop("k2")
        return {**ground, **own}


_WITH_BIAS = ("k1_warp_MPa", "k1_weft_MPa", "k2_warp", "k2_weft", "k1_bias_MPa", "k2_bias", "bias_deg")
#: All that one energy of the whole sheet has beside its ground.
REST = WholeSheet((*_WITH_BIAS, "G_MPa"))
#: The forms in which warp and weft differ.
FORMS: Mapping[str, Directions] = {
    "ratio": Ratio(),
    "ratios": Ratios(),
    "constants": Constants(),
    "warp-fibres": Fibres(lambda k, growth: (k, 0.0, growth), 2),
    "weft-fibres": Fibres(lambda k, growth: (0.0, k, growth), 2),
    "constants-fibres": Fibres(lambda warp, weft, growth: (warp, weft, growth), 3, Constants()),
    "threads": WholeSheet(("k1_warp_MPa", "k1_weft_MPa", "k2", "G_MPa")),
    "threads-each": WholeSheet(("k1_warp_MPa", "k1_weft_MPa", "k2_warp", "k2_weft", "G_MPa")),
    "bias-threads": WholeSheet(_WITH_BIAS),
    "bias-threads-nearest": WholeSheet((*_WITH_BIAS, "reach")),
    "sheet": REST,
    **{f"smooth-{count}": Smooth(count) for count in range(1, 5)},
}


def form_of(terms: Mapping[str, tuple[str, Array]]) -> Directions | None:
    """Return the form in which warp and weft differ among ``terms``, None where none says so."""
    return FORMS[terms["anisotropy"][0]] if "anisotropy" in terms else None
