"""Which of the documents behind a model is off: each chapter's constants together, by their marginal likelihood.

A chapter is what one document upstream says: the foam, the fabric's constants, the molds' temperature, how the press is
mounted. Its constants have a covariance beforehand, and a chapter at fault may be off by a few times that (``SCALES``,
alike beforehand), in all of them or, as likely, in one and those that err with it. Against each stand that all is as
stated, and that it is something else: a smooth field over the places, or readings noisier than they were told to be;
and, where a chapter put right leaves more than noise, such a field beside it.
Laplace's approximation at each chapter's own best constants (MacKay, Information Theory, Inference, and Learning
Algorithms, 2003, chapter 27).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from scipy.sparse.csgraph import connected_components
from scipy.special import expit, logsumexp

from hyperfab.arrays import Array, Flags
from hyperfab.loop.belief import allowed
from hyperfab.loop.known import SCALES
from hyperfab.loop.thresholds import MARGIN, ODDS, SHARE
from hyperfab.numerics.propagation import Source

#: Beside the chapters: nothing is off, or something that no chapter has.
STATED, ELSE = "as stated", "something else"
#: Lengths over which something else is alike, as shares of what the readings span, and its sizes, in standard
#: deviations of the noise.
_LENGTHS, _SIZES = (0.1, 0.25, 0.5), (1.0, 3.0, 10.0, 30.0)
#: Degrees of freedom beyond which no noise is known, however it was stated: to a tenth.
_SURE_NOISE = 50.0
#: Steps of Gauss and Newton, and their differences in standard deviations.
_STEPS, _DIFFERENCE = 6, 0.05
#: What is predicted counts as what is shown where they differ by less (rms, standard deviations of the noise).
_NEAR = 0.2
#: Runs of a chain are taken for the same place where they tell apart by less than this share.
_ALIKE = 1e-6


@dataclass(frozen=True)
class Chapter:
    """The constants of one document: their ``covariance`` (k, k) beforehand, and what the model predicts at readings
    (n,) where they change by (k,)."""

    name: str
    covariance: Array
    predict: Callable[[Array], Array]


@dataclass(frozen=True)
class Readings:
    """What was ``measured`` (n,), its noise ``sd`` (n,), where (n, d), and of which ``kind`` (n,) each is; the size of
    the noise is known with ``freedom`` degrees of freedom."""

    measured: Array
    sd: Array
    places: Array
    kind: Array
    freedom: float = np.inf

    def likely(self, misfit: float, volume: float) -> float:
        """Return the logarithm of a marginal likelihood: Student's, as the size of the noise is not known for sure.

        ``misfit`` is the square of the residual in its covariance, ``volume`` the logarithm of that one's determinant.
        """
        known = min(self.freedom, _SURE_NOISE)
        return -0.5 * (volume + (len(self.measured) + known) * float(np.log1p(misfit / known)))


@dataclass(frozen=True)
class Blamed:
    """A chapter at its best: what its constants change by (k,) with their sd (k,), what is predicted then (n,), the
    logarithm of its marginal likelihood, and ``runs`` of the whole chain: changes (k,) and what is shown there (n,).

    ``beside`` (f,) is how much likelier (logarithms) they are with a field beside it, of each size and length; none
    while no run tells."""

    chapter: Chapter
    change: Array
    sd: Array
    predicted: Array
    evidence: float
    runs: tuple[tuple[Array, Array], ...] = ()
    beside: Array = field(default_factory=lambda: np.empty(0))

    @property
    def off(self) -> float:
        """How many standard deviations of what was known the constants are off, together."""
        root = Source("", self.chapter.covariance).root
        return float(np.linalg.norm(np.linalg.pinv(root) @ self.change))


@dataclass(frozen=True)
class Trace:
    """The ``probability`` of each chapter, of STATED and of ELSE, the chapters at their best, what the model predicts
    as its documents are, ``stated`` (n,), and the ``suspects`` of which one is at fault, the likeliest first."""

    probability: Mapping[str, float]
    blamed: Mapping[str, Blamed]
    stated: Array
    suspects: tuple[str, ...]
    readings: Readings
    something: float

    @property
    def verdict(self) -> str:
        """``as stated``: that is not ruled out; ``chapter``, ``something else``; ``ambiguous``: one of several."""
        if not self.suspects:
            return STATED
        return "ambiguous" if len(self.suspects) > 1 else ELSE if self.suspects[0] == ELSE else "chapter"


def trace(readings: Readings, stated: Array, chapters: Sequence[Chapter]) -> Trace:
    """Return which chapter is at fault; ``stated`` (n,) is what the model predicts as its documents are.

    >>> rng = np.random.default_rng(1)
    >>> x = np.linspace(0.0, 1.0, 40)
    >>> made = [Chapter(n, np.eye(1), lambda c, p=p: c[0] * x**p) for n, p in (("flat", 0), ("slope", 1))]
    >>> read = Readings(0.5 * x + 0.01 * rng.standard_normal(40), np.full(40, 0.01), x[:, None], np.zeros(40))
    >>> found = trace(read, np.zeros(40), made)
    >>> found.verdict, found.suspects, round(float(found.blamed["slope"].change[0]), 2)
    ('chapter', ('slope',), 0.5)
    """
    sd = _inexact(readings, stated)
    blamed = {one.name: _blamed(one, readings, stated, sd) for one in chapters}
    each = np.concatenate(_something((readings.measured - stated) / sd, readings))
    return _weighed(readings, stated, blamed, _mean(each))


def run_anew(found: Trace, name: str, shown: Array, last: bool) -> tuple[Trace, bool]:
    """Return what is found where the chain, run anew with a chapter at its best, shows (n,), and whether the chapter
    is settled there: whether what it would show at a better place is near that. There it stays where it is, or where
    this run is the ``last``.

    Its derivatives are those of the chain where all is as stated: the prediction is off by a square in the constants,
    the least one that agrees with all runs.
    """
    blamed, readings = found.blamed[name], found.readings
    chapter, runs = blamed.chapter, (*blamed.runs, (blamed.change, shown))
    inverse = np.linalg.pinv(Source("", chapter.covariance).root)
    places = np.stack([inverse @ change for change, _ in runs])
    off = np.stack([there - chapter.predict(change) for change, there in runs])
    square = np.linalg.pinv((places @ places.T) ** 2, _ALIKE) @ off

    def nearer(change: Array) -> Array:
        return chapter.predict(change) + (places @ (inverse @ change)) ** 2 @ square

    sd = _inexact(readings, found.stated)
    again = _blamed(replace(chapter, predict=nearer), readings, found.stated, sd)
    again = replace(again, chapter=chapter, runs=runs)
    settled = float(np.sqrt(np.mean(((again.predicted - shown) / readings.sd) ** 2))) < _NEAR
    if settled or last:
        beside = _beside(readings, found.stated, shown)
        again = replace(again, change=blamed.change, predicted=shown, beside=beside)
    return _weighed(readings, found.stated, {**found.blamed, name: again}, found.something), settled


def _inexact(readings: Readings, stated: Array) -> Array:
    """Return the noise (n,) beside a right chapter, whose model is itself inexact: by as much as the loop lets pass as
    explained."""
    left = (readings.measured - stated) / readings.sd
    beyond = max(float(np.mean(left**2)) - 1.0, 0.0)
    return np.asarray(readings.sd * np.sqrt(1.0 + SHARE * beyond))


def _beside(readings: Readings, stated: Array, shown: Array) -> Array:
    """Return how much likelier (f,), logarithms, the readings are with a field beside a chapter that shows (n,) than
    with noise of any size, of each size and length: not at all where that leaves no more than a right name may."""
    before, left = ((readings.measured - one) / readings.sd for one in (stated, shown))
    beyond, beside = (float(np.sqrt(max(float(np.mean(one**2)) - 1.0, 0.0))) for one in (before, left))
    noisier, fields = _something(left, readings)
    if beside <= allowed(beyond):
        return np.full(len(fields), -np.inf)
    return np.asarray(fields - max(_mean(noisier), readings.likely(float(left @ left), 0.0)))


def _mean(logarithms: Array) -> float:
    return float(logsumexp(logarithms) - np.log(len(logarithms)))


def _weighed(readings: Readings, stated: Array, blamed: Mapping[str, Blamed], something: float) -> Trace:
    sd = _inexact(readings, stated)
    left = (readings.measured - stated) / sd
    evidence = {STATED: readings.likely(float(left @ left), 0.0), ELSE: something}
    evidence |= {name: one.evidence for name, one in blamed.items()}
    # Beforehand it is as likely as not that nothing is off; all that may be are alike.
    prior = {name: 0.5 if name == STATED else 0.5 / (len(blamed) + 1) for name in evidence}
    weights = np.array([evidence[name] + np.log(prior[name]) for name in evidence])
    shares = np.exp(weights - logsumexp(weights))
    probability = dict(zip(evidence, map(float, shares), strict=True))
    # That a chapter is off, and something else beside it, is no less likely than that it is by itself.
    for name, one in blamed.items():
        if len(one.beside):
            beside = probability[name] * float(expit(_mean(one.beside)))
            probability[name] -= beside
            probability[ELSE] += beside
    fits = {name: float(np.sum(((readings.measured - one.predicted) / sd) ** 2)) for name, one in blamed.items()}
    likely = {name: readings.likely(misfit, 0.0) for name, misfit in fits.items()}
    suspects = _suspects(probability)
    if suspects and suspects[0] in blamed:
        likely[ELSE] = likely[suspects[0]] + float(np.max(blamed[suspects[0]].beside, initial=-np.inf))
    suspects = _with_alike(suspects, probability, likely)
    return Trace(probability, blamed, stated, suspects, readings, something)


def _suspects(probability: Mapping[str, float]) -> tuple[str, ...]:
    """Return what is at fault, the likeliest first: as few as have those odds together, against all else; none where
    it is not ruled out that all is as stated."""
    found: list[str] = []
    for name in sorted(set(probability) - {STATED}, key=lambda name: -probability[name]):
        found.append(name)
        if sum(probability[one] for one in found) >= ODDS / (1.0 + ODDS):
            return tuple(found)
    return ()


def _with_alike(
    found: tuple[str, ...], probability: Mapping[str, float], likely: Mapping[str, float]
) -> tuple[str, ...]:
    """Return the suspects and what else explains the readings about as well as the likeliest, by what is ``likely`` (a
    logarithm) with each at its best.

    Of these only what was taken to be known of their constants tells which it is, and that has to be clear.

    >>> _with_alike(("foam",), {"foam": 0.9, "sheet": 0.1}, {"foam": -20.0, "sheet": -20.5})
    ('foam', 'sheet')
    >>> _with_alike(("foam",), {"foam": 0.9, "sheet": 0.1}, {"foam": -20.0, "sheet": -22.5})
    ('foam',)
    """
    if not found or found[0] not in likely:
        return found
    best, least = found[0], probability[found[0]] * float(np.exp(-0.5 * MARGIN))
    alike = [one for one in likely if likely[one] > likely[best] - np.log(ODDS) and probability[one] > least]
    return tuple(dict.fromkeys([*found, *sorted(alike, key=lambda one: -probability[one])]))


def _blamed(chapter: Chapter, readings: Readings, stated: Array, sd: Array) -> Blamed:
    """Return a chapter at its best: as likely as that all of its constants are off, one of them is, whichever, with
    those that err with it."""
    blocks = _blocks(chapter.covariance)
    free = [np.ones(len(chapter.covariance), dtype=bool), *(blocks if len(blocks) > 1 else ())]
    share = np.log([1.0] if len(free) == 1 else [0.5, *[0.5 / len(blocks)] * len(blocks)])
    tried = [_freed(chapter, one, readings, stated, sd) for one in free]
    weights = np.array([one.evidence for one in tried]) + share
    return replace(tried[int(np.argmax(weights))], evidence=float(logsumexp(weights)))


def _blocks(covariance: Array) -> list[Flags]:
    """Return which constants err together, block by block, each as a mask (k,).

    >>> [list(map(int, one)) for one in _blocks(np.array([[1.0, 0.0, 0.5], [0.0, 1.0, 0.0], [0.5, 0.0, 1.0]]))]
    [[1, 0, 1], [0, 1, 0]]
    """
    count, block = connected_components(covariance != 0.0, directed=False)
    return [block == one for one in range(count)]


def _freed(chapter: Chapter, free: Flags, readings: Readings, stated: Array, sd: Array) -> Blamed:
    """Return a chapter at its best with the constants that are ``free`` (k,) off, the others as stated; in independent
    directions of one standard deviation each."""
    root, measured = Source("", np.where(np.outer(free, free), chapter.covariance, 0.0)).root, readings.measured
    place, value = np.zeros(root.shape[1]), stated
    found: list[tuple[float, Array, Array, Array]] = []
    for scale in SCALES:
        place, value, slope = _best(chapter, root, measured, sd, scale, place, value)
        left = (measured - value) / sd
        # In units of the scale: the more constants the readings tell, the more the chapter had to choose from.
        grown = np.linalg.slogdet(np.eye(len(place)) + scale**2 * slope.T @ slope)[1]
        known = float(place @ place) / scale**2
        found.append((readings.likely(float(left @ left) + known, float(grown)), place, value, slope))
    weights = np.array([one[0] for one in found])
    best = int(np.argmax(weights))
    _, place, value, slope = found[best]
    precision = slope.T @ slope + np.eye(len(place)) / SCALES[best] ** 2
    spread = root @ np.linalg.inv(precision) @ root.T
    evidence = float(logsumexp(weights) - np.log(len(weights)))
    variance = np.where(free, spread.diagonal(), chapter.covariance.diagonal())
    return Blamed(chapter, root @ place, np.sqrt(variance), value, evidence)


def _best(
    chapter: Chapter, root: Array, measured: Array, sd: Array, scale: float, place: Array, value: Array
) -> tuple[Array, Array, Array]:
    """Return the likeliest place (r,) of a chapter's constants, the prediction there, and its whitened slope (n, r)."""

    def misfit(at: Array, predicted: Array) -> float:
        left = (measured - predicted) / sd
        return float(left @ left) + float(at @ at) / scale**2

    slope = _slope(chapter, root, sd, place, value)
    for _ in range(_STEPS):
        normal = slope.T @ slope + np.eye(len(place)) / scale**2
        step = np.linalg.solve(normal, slope.T @ ((measured - value) / sd) - place / scale**2)
        before, share = misfit(place, value), 1.0
        while share > 0.05:
            there = chapter.predict(root @ (place + share * step))
            if np.isfinite(there).all() and misfit(place + share * step, there) < before:
                break
            share *= 0.5
        else:
            break
        place, value = place + share * step, there
        slope = _slope(chapter, root, sd, place, value)
        if before - misfit(place, value) < 1e-3 * max(before, 1.0):
            break
    return place, value, slope


def _slope(chapter: Chapter, root: Array, sd: Array, place: Array, value: Array) -> Array:
    ways = place + _DIFFERENCE * np.eye(len(place))
    columns = [(chapter.predict(root @ there) - value) / (_DIFFERENCE * sd) for there in ways]
    return np.array(columns).T.reshape(len(value), len(place))


def _something(left: Array, readings: Readings) -> tuple[Array, Array]:
    """Return the logarithms of the marginal likelihoods of whitened readings (n,) that are off by no chapter's doing:
    by more noise, of each size (s,); by a Gaussian field over the places, another for each kind of reading, of each
    length and size (f,).
    """
    span = float(np.ptp(readings.places, axis=0).max()) or 1.0
    apart = np.linalg.norm(readings.places[:, None, :] - readings.places[None, :, :], axis=2) / span
    alike = readings.kind[:, None] == readings.kind[None, :]

    def likely(mode: Array) -> list[float]:
        values, vectors = np.linalg.eigh(mode)
        along = (vectors.T @ left) ** 2
        variances = [1.0 + size**2 * np.maximum(values, 0.0) for size in _SIZES]
        return [readings.likely(float(np.sum(along / one)), float(np.sum(np.log(one)))) for one in variances]

    fields = [likely(np.where(alike, np.exp(-0.5 * (apart / one) ** 2), 0.0)) for one in _LENGTHS]
    return np.array(likely(np.eye(len(left)))), np.concatenate(fields)
