"""Length that a pulled fabric does not give back."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import NamedTuple

import numpy as np

from hyperfab.materials.effects.path import Path, second_stretch
from hyperfab.materials.effects.recurrence import along, towards
from hyperfab.materials.effects.smooth import through
from hyperfab.materials.effects.ways import amount
from hyperfab.materials.law import Array


def returned(stretch: Array, peak: Array, rest: Array, least: Array | float = 1.0) -> Array:
    """Return the elastic stretch where a set ``rest`` of the largest strain so far stays when the load is gone.

    The first pull is the law's own; coming down, and up again to the old peak, the strain runs from the set to the peak
    on a scale of its own: ``(strain - set) peak / (peak - set)``. At its ``least`` the fabric is slack.

    >>> returned(np.array([1.5, 1.1]), np.array([1.5, 1.5]), np.array([0.1, 0.1]))
    array([1.5, 1. ])
    """
    most = peak - 1.0
    strain = (stretch - 1.0 - rest) * most / np.maximum(most - rest, 1e-12)
    return np.asarray(np.where(stretch >= peak, stretch, np.maximum(1.0 + strain, least)))


def left_of(stretch: Array, rest: Array, added: bool, least: Array | float = 1.0) -> Array:
    """Return the elastic stretch over a set ``rest``: strains are ``added``, or stretches are multiplied.

    With the set of the largest stretch including the present pull this is plastic flow as it happens; with that of the
    earlier pulls it is a set that shows from the second pull on.

    >>> left_of(np.array([1.5, 1.1]), np.array([0.2, 0.2]), added=False)
    array([1.25, 1.  ])
    """
    return np.asarray(np.maximum(stretch - rest if added else stretch / (1.0 + rest), least))


def crept(path: Path, values: Array) -> Array:
    """Return the set where the rest length follows the largest strain pull by pull.

    ``values`` are a share and a strain: with every pull the set comes nearer to that share of the largest strain so
    far, over that strain pulled; it grows with the cycles. Evolution of Armstrong & Frederick (1966), CEGB RD/B/N 731.
    """
    share, strain = values
    first, pulled = _pulled(path)
    keep = np.exp(-pulled / strain)
    keep[first] = 0.0
    return along(keep, (1.0 - np.exp(-pulled / strain)) * share * (path.peak - 1.0))


def _pulled(path: Path) -> tuple[list[int], Array]:
    """Return each pull's first row, and by how much each row is pulled further than the one before."""
    first = list(path.starts[:-1])
    pulled = np.maximum(np.diff(path.stretch, prepend=1.0), 0.0)
    pulled[first] = np.maximum(path.stretch[first] - 1.0, 0.0)
    return first, pulled


def pulls(path: Path, stretch: Array) -> Array:
    """Return the load of a sheet at a stretch, over a third of its Young's modulus: that of neo-Hooke's in each mode.

    >>> from hyperfab.materials.effects.path import uniaxial_pull
    >>> pulls(uniaxial_pull(np.array([1.0, 2.0])), np.array([1.0, 2.0]))
    array([0.  , 1.75])
    """
    side = second_stretch(path.mode, stretch, stretch**-0.5, path.across)
    return np.asarray(stretch - 1.0 / (stretch**3 * side**2))


def crept_smoothly(
    path: Path, values: Array, *, flows: bool = False, by_load: bool = False, times: Array | float = 1.0
) -> Array:
    """Return a set that follows a smooth function of the largest strain, over way and time.

    ``values`` are the reach, the strain pulled and the time [s] over which the set comes nearer to it, and its values
    at even parts of the reach. One that ``flows`` follows that function of the present strain, as long as this asks for
    more: it stops as the load goes. ``by_load`` the load stands for the strain: a sheet pulled both ways bears more at
    the same strain. The set is so many ``times`` that function.
    """
    reach, strain, time = values[:3]
    first, pulled = _pulled(path)
    passed = pulled / strain + (path.waited / time if path.knows_time else 0.0)
    keep = np.exp(-passed)
    keep[first] = 0.0
    stretch = path.stretch if flows else path.peak
    strained = pulls(path, stretch) if by_load else stretch - 1.0
    aim = times * np.maximum(through(strained / reach, values[3:]), 0.0)
    return towards(keep, aim) if flows else along(keep, -np.expm1(-passed) * aim)


def kept_on(path: Path, values: Array) -> Array:
    """Return the set where each time the specimen is let go adds to its rest length.

    ``values`` are a share and a power: the set is that share of the largest strain so far times the number of returns
    to that power.
    """
    share, power = values
    return np.where(path.returns > 0.0, share * (path.peak - 1.0) * np.maximum(path.returns, 1.0) ** power, 0.0)


def second_network(first: Array, second: Array, peak: Array, share: float, power: float = 1.0) -> Array:
    """Return the stress where a share of the chains took the largest stretch so far for its rest.

    ``first`` is the law at the stretch, ``second`` at the stretch over ``peak``. The share grows with
    the largest strain to a power (``share`` at 1/2); where both together would push, the specimen is slack.
    Andrews, Tobolsky & Hanson (1946), J. Appl. Phys. 17, 352, doi:10.1063/1.1707724.

    >>> second_network(np.array([1.0]), np.array([-0.5]), np.array([1.0]), 0.2)
    array([1.])
    """
    part = np.clip(share * (np.maximum(peak - 1.0, 1e-12) / 0.5) ** power, 0.0, 0.95)
    both = (1.0 - part) * first + part * second / peak
    return np.asarray(np.where(part > 0.0, np.maximum(both, np.minimum(first, 0.0)), first))


def _rest(peak: Array, share: float, power: float = 1.0, bend: float = 0.0) -> Array:
    """Return the set of a largest stretch: ``share`` of the strain, with ``power`` of that power of it (over 1/2), with
    ``bend`` as ``(1 - exp(-bend strain))/bend``."""
    most = peak - 1.0
    if bend:
        return share * -np.expm1(-bend * most) / bend
    return share * most if power == 1.0 else share * most * (np.maximum(most, 1e-12) / 0.5) ** (power - 1.0)


#: The elastic stretch and the set in each form: of the path, the specimen's stretch and its largest so far, and the
#: constants.
Lengthens = Callable[[Path, Array, Array, Array], tuple[Array, Array]]


class Form(NamedTuple):
    """How many constants a form ``takes``, and what it makes of them; one more may follow: the set's contraction.

    ``flows``: what is kept has flowed, and its section with it; else it is length that was folded, or slack.
    """

    takes: int
    lengthens: Lengthens
    flows: bool = True

    def contraction(self, values: Array) -> float:
        """Return the power with which a set contracts the specimen as a pull to its length does; 0: not at all."""
        return float(values[self.takes]) if len(values) > self.takes else 0.0

    def section(self, rest: Array, values: Array) -> Array | float:
        """Return the section that is left over a set ``rest`` to bear the load, as a share of that before the pull.

        Where the volume stays the nominal stress is the derivative of the energy W(l/(1 + s)): ``P/(1 + s)``.
        Lee (1969), J. Appl. Mech. 36, 1, doi:10.1115/1.3564580.

        >>> FORMS["flow"].section(np.array([0.25]), np.array([0.2, 1.0]))
        array([0.8])
        """
        power = self.contraction(values)
        return (1.0 + rest) ** -power if self.flows and power else 1.0


def _returned(bends: bool = False) -> Lengthens:
    def found(path: Path, stretch: Array, peak: Array, values: Array) -> tuple[Array, Array]:
        return _seen(path, stretch, peak, np.minimum(_rest(peak, *_curved(values, bends)), 0.95 * (peak - 1.0)))

    return found


def _returned_smoothly(by_load: bool = False) -> Lengthens:
    """Return the form of a set seen on the way down that is a smooth function of the largest strain, or load.

    Its constants are the reach, and the set at fifths of it; ``by_load`` how much more it is along the weft
    and in other modes as well.
    """

    def found(path: Path, stretch: Array, peak: Array, values: Array) -> tuple[Array, Array]:
        strained = pulls(path, peak) if by_load else peak - 1.0
        rest = through(strained / values[0], values[1:6])
        rest = np.clip(amount(path, *values[6:8]) * rest if by_load else rest, 0.0, 0.95 * (peak - 1.0))
        return _seen(path, stretch, peak, rest)

    return found


def _seen(path: Path, stretch: Array, peak: Array, rest: Array) -> tuple[Array, Array]:
    """Return the elastic stretch over a set that is seen on the way down, the more the further down, and so much."""
    elastic = returned(stretch, peak, rest, path.least)
    with np.errstate(divide="ignore"):  # where it is none the set is what is left
        return elastic, np.where(elastic > path.least, stretch / elastic - 1.0, rest)


def _flow(bends: bool = False, added: bool = False, earlier: bool = False) -> Lengthens:
    """Return the form of plastic flow as it happens, or of a set of the ``earlier`` pulls."""

    def found(path: Path, stretch: Array, peak: Array, values: Array) -> tuple[Array, Array]:
        rest = _rest(path.earlier_peak if earlier else path.peak, *_curved(values, bends))
        return left_of(stretch, rest, added, path.least), rest

    return found


def _over(rest_of: Callable[[Path, Array], Array], added: bool = False) -> Lengthens:
    """Return the form of a set that hangs on the path alone."""

    def found(path: Path, stretch: Array, peak: Array, values: Array) -> tuple[Array, Array]:
        rest = rest_of(path, values)
        return np.minimum(stretch, left_of(path.stretch, rest, added, path.least)), rest

    return found


def _by_load_each_way(path: Path, values: Array, flows: bool) -> Array:
    return crept_smoothly(path, values[:-2], flows=flows, by_load=True, times=amount(path, *values[-2:]))


def _curved(values: Array, bends: bool) -> tuple[float, ...]:
    """Return the share of a set, its power and its bend, as far as they are not 1 and 0."""
    return (values[0], 1.0, values[1]) if bends else tuple(values)


FORMS: Mapping[str, Form] = {
    "returned": Form(1, _returned(), flows=False),
    "returned-power": Form(2, _returned(), flows=False),
    "returned-bent": Form(2, _returned(bends=True), flows=False),
    "flow": Form(1, _flow()),
    "flow-power": Form(2, _flow()),
    "flow-bent": Form(2, _flow(bends=True)),
    "flow-added": Form(1, _flow(added=True), flows=False),
    "flow-power-added": Form(2, _flow(added=True), flows=False),
    "flow-bent-added": Form(2, _flow(bends=True, added=True), flows=False),
    "next-pull": Form(1, _flow(earlier=True)),
    "next-pull-power": Form(2, _flow(earlier=True)),
    "next-pull-added": Form(1, _flow(added=True, earlier=True), flows=False),
    "crept": Form(2, _over(crept)),
    "crept-added": Form(2, _over(crept, added=True), flows=False),
    "smooth": Form(6, _over(crept_smoothly)),
    "smooth-flow": Form(6, _over(partial(crept_smoothly, flows=True))),
    "smooth-load-each-way": Form(8, _over(partial(_by_load_each_way, flows=False))),
    "smooth-flow-load-each-way": Form(8, _over(partial(_by_load_each_way, flows=True))),
    "smooth-close": Form(8, _over(crept_smoothly)),
    "smooth-flow-close": Form(8, _over(partial(crept_smoothly, flows=True))),
    "smooth-returned": Form(6, _returned_smoothly(), flows=False),
    "smooth-returned-load-each-way": Form(8, _returned_smoothly(by_load=True), flows=False),
    "cycles": Form(2, _over(kept_on)),
    "cycles-added": Form(2, _over(kept_on, added=True), flows=False),
}
#: Forms in which a second network stands beside the law: it moves no stretch.
NETWORKS = ("network", "network-power")
#: Forms that leave a first pull as the law has it.
SPARES_FIRST_PULL = (
    "returned", "returned-power", "returned-bent", "smooth-returned", "smooth-returned-load-each-way",
    "next-pull", "next-pull-power", "next-pull-added",
)  # fmt: skip
