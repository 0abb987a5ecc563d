"""What the engine knows of a domain: constants, effects, measured rows, and a prediction."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from itertools import pairwise
from typing import Any, ClassVar, Self

import numpy as np

from hyperfab.arrays import Array, Ints


@dataclass(frozen=True)
class Constant:
    """One number the fit may move.

    ``value`` is where it starts (the document's value; the null value for a constant of an effect), ``scale`` the
    size of a natural step, ``prior_sd`` one standard deviation of what is known of it beforehand (inf: nothing).
    ``places`` name what of the domain's set-up a constant of an effect is added to; ``curve`` is the number of the one
    test that it has a say in, None: all may ask for it.
    """

    name: str
    value: float
    low: float = -np.inf
    high: float = np.inf
    scale: float = 1.0
    prior_sd: float = np.inf
    places: tuple[str, ...] = ()
    curve: int | None = None

    def ends(self, value: float) -> bool:
        """Whether a fit has moved it as far as it may go: others may then make up for the rest of its way.

        >>> [Constant("contact.0.h", 1.0, 0.2, 1.8).ends(value) for value in (0.2, 0.3, 1.8)]
        [True, False, True]
        """
        near = 1e-3 * min(abs(self.value - self.low), self.scale)
        return bool(min(value - self.low, self.high - value) <= near)


@dataclass(frozen=True)
class Form:
    """One law of an effect. At ``constants`` = their values (the null) the model is the one without it.

    ``starts`` are where a joint fit begins; ``probes`` the small departures whose imprint on the prediction is the
    effect's signature. ``refines`` names the simpler form, or forms, that it is tried after (of none: it is not tried).
    ``of_each``: a constant for the first specimen, and for each further one what it has more, before the last ones,
    ``shared`` in number. ``free``: its amount is
    a smooth function of what the effect rides on, by a few values; it is tried for names that stand, or might, where
    no formula leaves noise. ``takes_over``: beside its constants the model's own may be next to nothing; a fit begins
    there too. ``screened``: it is fitted only where its ``probes`` point at what is left, for its fit takes long.
    """

    name: str
    constants: tuple[Constant, ...]
    starts: tuple[tuple[float, ...], ...]
    probes: tuple[tuple[float, ...], ...] = ()
    refines: str | tuple[str, ...] | None = None
    of_each: bool = False
    shared: int = 0
    free: bool = False
    takes_over: bool = False
    screened: bool = False

    @property
    def null(self) -> tuple[float, ...]:
        """The constants at which the effect is absent."""
        return tuple(constant.value for constant in self.constants)

    @property
    def each(self) -> tuple[Constant, ...]:
        """The constants of which each specimen has one."""
        return self.constants[: len(self.constants) - self.shared] if self.of_each else ()

    def named(self, values: Array) -> dict[str, float]:
        """Return ``values`` by the names of the constants."""
        return {one.name: float(value) for one, value in zip(self.constants, values, strict=True)}

    @property
    def simpler(self) -> tuple[str, ...]:
        """The names of the forms that this one refines."""
        return (self.refines,) if isinstance(self.refines, str) else self.refines or ()

    def enriches(self, name: str) -> bool:
        """Whether this form refines the one of that name."""
        return name in self.simpler

    def begin(self, simpler: Form, values: Array) -> Array:
        """Return where a fit begins: what the ``simpler`` form has at its ``values``, the rest at its start."""
        known = simpler.named(values)
        pairs = zip(self.constants, self.starts[0], strict=True)
        return np.array([known.get(one.name, start) for one, start in pairs])


def fixed(name: str, value: float) -> Constant:
    """Return a constant that stays: a length or a time that the others are told by."""
    return Constant(name, value, value, value, abs(value) or 1.0)


def freely(forms: Sequence[Form], name: str, constants: Sequence[Constant], start: Sequence[float]) -> Form:
    """Return the form of that name whose amount is a smooth function, tried where none of ``forms`` leaves noise."""
    simpler = tuple(form.name for form in forms)
    return Form(name, tuple(constants), (tuple(start),), refines=simpler, free=True)


def tried_if(shown: bool, *forms: Form) -> list[Form]:
    """Return the forms, not to be tried unless these data could have ``shown`` them: a model may have them already."""
    return list(forms) if shown else [replace(form, probes=(), refines=()) for form in forms]


#: Why an entry is not sought that the model already has.
HAS_IT = "the model has it"


@dataclass(frozen=True)
class Effect:
    """A catalogue entry: something a model may lack.

    ``shown_by`` is the measurement that would tell it from its look-alikes; ``smooth`` whether a too poor smooth law
    could pass for it (its score is then taken off a space of smooth curves). ``not_sought`` says why an entry is left
    out: the model has it, or the data lack what it shows on. ``of_document``: it says that a document is wrong in what
    it states, not that the model lacks something; so may the model's own constants be, as far off. ``added``: its
    constants come on top of what the model may have of it already.
    """

    id: str
    title: str
    shown_by: str
    source: str
    forms: tuple[Form, ...]
    smooth: bool = False
    not_sought: str = ""
    of_document: bool = False
    added: bool = False

    def form(self, name: str) -> Form:
        """Return the form of that name."""
        return next(form for form in self.forms if form.name == name)


def split(values: Array, forms: Mapping[str, Form]) -> dict[str, tuple[str, Array]]:
    """Cut the constants of the terms apart: effect id -> form and its constants."""
    found, at = {}, 0
    for name, form in forms.items():
        found[name] = (form.name, values[at : at + len(form.constants)])
        at += len(form.constants)
    return found


@dataclass(frozen=True)
class Curve:
    """Rows ``start`` to ``stop`` of the data: one test of one specimen, or one probe.

    ``cuts`` are rows where the curve has a corner (a turn from loading to unloading); ``abscissa`` is what it is smooth
    in, ``place`` what replicates are compared at. Curves of the same ``setup`` are replicates, those of the same
    ``size`` were cut alike; those of the same ``specimen`` share its stiffness. Rows known
    ``beforehand`` are no readings but what is known of constants.
    """

    name: str
    start: int
    stop: int
    abscissa: Array
    cuts: tuple[int, ...] = ()
    setup: str = ""
    specimen: str = ""
    channel: int = 0
    place: Array | None = None
    beforehand: bool = False
    size: str = ""

    @property
    def rows(self) -> slice:
        """The rows of the curve in the data."""
        return slice(self.start, self.stop)

    @property
    def places(self) -> Array:
        """What replicates are compared at."""
        return self.abscissa if self.place is None else self.place

    def pieces(self) -> list[slice]:
        """Return the smooth pieces of the curve, between its corners."""
        edges = [self.start, *self.cuts, self.stop]
        return [slice(a, b) for a, b in pairwise(edges) if b > a]


@dataclass(frozen=True)
class Extra:
    """A test that could be done next: what to tell the engineer, and the problem with its rows added."""

    text: str
    details: Mapping[str, Any]
    problem: Problem


@dataclass
class Problem(ABC):
    """A model, measured rows, and the catalogue of what the model may lack.

    ``measured`` has one value a row; ``states`` the state variables by name, one value a row of the first channel
    (nan where unknown); ``stated_sd`` the standard deviation of each reading where the data state it.
    ``nuisance`` spans smooth departures of a poor base law, (rows, k). ``starts`` are further places where a fit of the
    own constants begins: a law that is not linear in them has several optima, and the given ones may lie in the wrong
    valley or where these data have no prediction at all.
    """

    measured: Array
    curves: tuple[Curve, ...]
    own: tuple[Constant, ...]
    effects: tuple[Effect, ...]
    states: Mapping[str, Array] = field(default_factory=dict)
    stated_sd: Array | None = None
    nuisance: Array | None = None
    units: tuple[str, ...] = ("",)
    #: States that no law knows, on which the stiffness of specimens rides: they scatter by less than they differ.
    ridden: tuple[str, ...] = ()
    #: Fits that were made, see ``fitting.descent`` and ``fitting.fitted_misfit``.
    descents: dict[Any, Any] = field(default_factory=dict, init=False, repr=False)
    misfits: dict[Any, Any] = field(default_factory=dict, init=False, repr=False)
    #: Entries of which the forms that refine them are tried too, for the first term.
    rich: ClassVar[int] = 3
    #: Whether the own constants are known so well that fits start there too, and models that leave it pay for that.
    well_known: ClassVar[bool] = False
    #: Whether two effects may hide each other, so that neither pays until the other is there: where entries are few and
    #: physics. Among many that only describe, some pair would pass for anything.
    hiding: ClassVar[bool] = False
    #: The entry that is the model's own law made richer: it may stand beside any other.
    plain: ClassVar[str] = ""
    starts: tuple[Array, ...] = ()
    #: The own constants with what is known of them beforehand, where rows of their own speak for that.
    priors: tuple[Constant, ...] = field(default=(), kw_only=True)
    #: What the model as it was given predicts, where that is not what it does with its ``own`` constants.
    as_delivered: Array | None = field(default=None, kw_only=True)
    #: What causes known beforehand to about a standard deviation would each do to the readings, (rows, k).
    common: Array = field(default_factory=lambda: np.empty((0, 0)), kw_only=True)
    #: Noise that curves without replicates have at least, as a share of their largest reading: published curves are
    #: drawn smooth, and readings that repeat each other are no more sure than the specimen.
    least_noise: ClassVar[float] = 0.0

    @abstractmethod
    def predict(self, own: Array, terms: Mapping[str, tuple[str, Array]]) -> Array:
        """Return the prediction at every row, for own constants and ``terms``: effect id -> (form, constants)."""

    @property
    def given(self) -> Array:
        """The own constants as the model was given, (p,)."""
        return np.array([constant.value for constant in self.own])

    @property
    def delivered(self) -> Array:
        """What the model predicts as it was given, (rows,)."""
        return self.predict(self.given, {}) if self.as_delivered is None else self.as_delivered

    @property
    def expected(self) -> tuple[Constant, ...]:
        """The own constants with what is known of them beforehand, also where rows of their own speak for that."""
        return self.priors or self.own

    @property
    def describes(self) -> bool:
        """Whether the entries are laws that only describe, so that they are made smooth where none is quite right."""
        return any(form.free for effect in self.effects for form in effect.forms)

    def look_alikes(self, forms: Mapping[str, Form]) -> Sequence[frozenset[str]]:
        """Return sets of effects that measurements of this plan cannot tell apart, whatever fits them best.

        ``forms`` are those that were found.
        """
        return ()

    def strained(self, own: Array, far: float = np.inf) -> list[str]:
        """Return which of the ``own`` constants (p,) are driven to the end of what is known of them, or so ``far``, in
        standard deviations; by name.

        There a model answers only because something makes up for what it lacks.
        """
        return []

    def loosened(self, own: Array) -> Problem | None:
        """Return the problem where those of the ``own`` constants (p,) that are driven to the end of what is known of
        them may be further off; None where none is."""
        return None

    def forbidden(self, own: Array, terms: Mapping[str, tuple[str, Array]]) -> Mapping[str, float]:
        """Return by how much constants, together, are those of no material: what is asked for -> how far off.

        What is met is below 0, by how much there is to spare, so that a fit knows of it before it is beyond.

        Bounds of single constants hold by themselves; ``fit`` keeps these as well.
        """
        return {}

    @property
    def inexact(self) -> frozenset[str]:
        """Entries of which no formula is quite the model's: a law of free shape is no less likely there."""
        return frozenset({self.plain})

    @property
    def has_valleys(self) -> bool:
        """Whether a fit of the own constants ends elsewhere where it begins elsewhere."""
        return len(self.starts) > 0

    def as_stated(self, own: Array) -> dict[str, float]:
        """Return the ``own`` constants (p,) as a document states them, by name."""
        return dict(zip((one.name for one in self.own), map(float, own), strict=True))

    @classmethod
    def of(cls, problem: Problem, more: Sequence[Constant]) -> Self:
        """Return another ``problem`` as one of this kind, which takes the same and has ``more`` own constants."""
        given = {one.name: getattr(problem, one.name) for one in fields(problem) if one.init}
        return cls(**given | {"own": (*problem.own, *more)})

    def scaled(self, own: Array, factor: float) -> Array:
        """Return the model's own constants where its answer is ``factor`` times as large."""
        return factor * own

    def predict_many(self, own: Array, forms: Mapping[str, Form], values: Array) -> Array:
        """Return the predictions (b, rows) for b sets of own constants (b, p) and of the terms' constants (b, q)."""
        return np.stack([self.predict(one, split(rest, forms)) for one, rest in zip(own, values, strict=True)])

    def predict_near(self, x: Array, forms: Mapping[str, Form], moved: Array) -> Array:
        """Return the predictions (b, rows) for b sets of all constants (b, p + q) next to ``x``, to first order in how
        far they are."""
        own = len(self.own)
        return self.predict_many(moved[:, :own], forms, moved[:, own:])

    def extras(self) -> Sequence[Extra]:
        """Return the tests that could be done next."""
        return ()

    @property
    def channel(self) -> Ints:
        """The channel (kind of reading) of each row."""
        found = np.zeros(len(self.measured), dtype=np.int64)
        for curve in self.curves:
            found[curve.rows] = curve.channel
        return found

    def amounts(self, terms: Mapping[str, tuple[str, Array]]) -> dict[str, float]:
        """Return what ``terms`` add, by its place in the set-up: predictions and the extended model take both this."""
        found: dict[str, float] = {}
        for name, (form, values) in terms.items():
            for constant, value in zip(self.effect(name).form(form).constants, values, strict=True):
                for place in constant.places:
                    found[place] = found.get(place, 0.0) + float(value)
        return found

    @property
    def sought(self) -> int:
        """How many entries of the catalogue these data could show."""
        return sum(not effect.not_sought for effect in self.effects)

    def effect(self, name: str) -> Effect:
        """Return the catalogue entry of that id."""
        return next(effect for effect in self.effects if effect.id == name)

    def longer(self, curves: Sequence[Curve], **changes: Any) -> Self:
        """Return the problem with ``changes`` and further ``curves`` at its end, of which nothing is read yet."""
        more = np.zeros(curves[-1].stop - len(self.measured))
        measured = np.concatenate([self.measured, more])
        return replace(self, measured=measured, curves=(*self.curves, *curves), states={}, **changes)
