"""The one way by which every command carries uncertainty: linear where that holds, sampled where it does not."""

from __future__ import annotations

import contextlib
import dataclasses
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from typing import Any, ClassVar

import numpy as np

from hyperfab.arrays import Array
from hyperfab.cases.place import put
from hyperfab.chapters.field import HANDED
from hyperfab.chapters.job import Job
from hyperfab.chapters.rerun import rerun
from hyperfab.chapters.uncertainty.handed import described, identified
from hyperfab.chapters.uncertainty.sources import Origins, of_case
from hyperfab.console import Advance
from hyperfab.documents.uncertainty import Band, Computed, Share, Uncertainty, figures_of
from hyperfab.errors import HyperfabError
from hyperfab.numerics import propagation
from hyperfab.numerics.propagation import LEVEL, Spread
from hyperfab.report.bands import figure, interval, shares

Figures = dict[str, float]
#: What numbers of sources change by, by the number of the source.
Changes = Mapping[int, Sequence[float] | Array]

#: Fields that are handed on and not shown.
_UNSEEN = ("thickness_ratio", "place_mm")
#: Figures with less than this of themselves as standard deviation do not hang on the inputs.
_NOTHING = 1e-7
#: Figures that leave the straight line by less than this of themselves do not bend: runs are no sharper than that.
_SLIGHT = 1e-5
#: Runs drawn where each is a run of its own.
_WHOLE = 64
#: Samples of which more than this part fails say nothing of the rest.
_FAILED = 0.1


@dataclasses.dataclass(frozen=True)
class Answer:
    """Figures by key, and fields (n,) by name."""

    figures: Figures
    fields: Mapping[str, Array] = dataclasses.field(default_factory=dict)


@dataclasses.dataclass(frozen=True)
class Sure:
    """How sure a document is, None where nothing says so, the standard deviations of its fields (n,) by name, and by
    ``NAME_by_1`` and on what those that are handed on change by with each number."""

    uncertainty: Uncertainty | None = None
    fields: Mapping[str, Array] = dataclasses.field(default_factory=dict)
    handed: Mapping[str, Array] = dataclasses.field(default_factory=dict)

    def interval(self, name: str) -> tuple[float, float] | None:
        """Return where a figure is to be expected, None where nothing says so."""
        band = None if self.uncertainty is None else self.uncertainty.quantities.get(name)
        return None if band is None else (band.low, band.high)

    @property
    def twins(self) -> dict[str, Array]:
        """The standard deviations under the names they have beside their fields."""
        return {f"{name}_sd": sd for name, sd in self.fields.items()}


@dataclasses.dataclass(frozen=True)
class Slopes:
    """What figures by key (numbers,) and fields by name (numbers, n) change by with each number, source by source."""

    figures: Mapping[str, Array]
    fields: Mapping[str, Array] = dataclasses.field(default_factory=dict)

    @staticmethod
    def of(each: Sequence[Answer]) -> Slopes:
        """Return the slopes by all numbers, of what each changes the figures and fields by."""
        return Slopes(
            {name: np.array([one.figures[name] for one in each]) for name in each[0].figures},
            {name: np.array([one.fields[name] for one in each]) for name in each[0].fields},
        )


class Nearby(ABC):
    """A result whose neighbours are known without another run.

    samples  how many of them are drawn
    step     of differences, over a standard deviation: as small as what jumps in the figures lets it be
    undrawn  figures that ``at`` does not tell, and why
    """

    samples: int
    step: float = 1.0
    undrawn: ClassVar[Mapping[str, str]] = {}

    def blur(self, name: str) -> float:
        """Return below which difference two values of a figure are one, as its own error is larger; 0 where all are of
        one discretisation, which errs alike."""
        return 0.0

    def gradient(self) -> Slopes | None:
        """Return what each figure changes by with each number, source by source; figures it cannot say are absent.
        None where differences are to tell it: figures that bend, extremes that jump from place to place."""
        return None

    @abstractmethod
    def at(self, changes: Changes) -> Answer:
        """Return figures and fields with the numbers of sources changed; NotConverged where there are none."""


def carry(
    job: Job,
    case: Any,
    document: Computed,
    origins: Callable[[], Origins],
    nearby: Callable[[Origins], Nearby | None],
) -> Sure:
    """Return how sure the figures of a document are, where its inputs say how sure they are; it tells them from now on.

    ``origins`` finds what the inputs say, and ``nearby`` a quicker way than to run the command again.
    """
    if case.uncertainty == "none":
        return Sure()
    known, value = origins(), Figures()
    if known.found:
        value = dict(figures_of(document.to_json(), document.KIND))
        identified(known, case, job)
        found = Carried(job, case, document.KIND, known, value, nearby(known)).run()
    elif next(of_case(case), None) is not None:
        method = case.uncertainty or "linear"
        found = Sure(Uncertainty(level=LEVEL, method=method, quantities={}, left_out=known.left_out))
    else:
        if case.uncertainty is not None:
            job.console.note("the inputs say nothing of how sure they are: there is no uncertainty to carry")
        return Sure()
    document.uncertainty = found.uncertainty
    if found.uncertainty is not None:
        _tell(job, found.uncertainty, value)
    return found


@dataclasses.dataclass
class Carried:
    """One result and the inputs it hangs on."""

    job: Job
    case: Any
    kind: str
    origins: Origins
    value: Figures
    near: Nearby | None

    def run(self) -> Sure:
        """Return the bands: as asked for, else linear where that holds."""
        self.sources = self.origins.sources
        #: What each field changes by along each direction (r, n), and its standard deviation.
        self.along: dict[str, Array] = {}
        self.fields: dict[str, Array] = {}
        left_out = list(self.origins.left_out)
        reason = None
        if self.case.uncertainty != "sampled":
            try:
                effects, bends, slopes = self._effects()
                off, ends = self._off(effects, bends)
            except HyperfabError as error:
                reason = f"a run within the interval fails ({error})"
            else:
                bands = {
                    name: propagation.linear(self.value[name], along, self.sources)
                    for name, along in effects.items()
                    if np.isfinite(along).all()
                }
                lost = [name for name in self.value if name not in bands]
                left_out += [f"{name}: not told by the runs one standard deviation away" for name in lost]
                curved = [
                    name
                    for name, band in bands.items()
                    if propagation.bent(max(band.sd, self._least(name) / propagation.NUMERICAL), off[name])
                ]
                for name, way in ends.items():
                    if name in bands and name not in curved:
                        bands[name] = propagation.curved(self.value[name], bands[name], *way)
                if self.near is None:
                    for name, band in bands.items():
                        bands[name] = propagation.bowed(self.value[name], band, effects[name], bends[name])
                if not curved or self.near is None or self.case.uncertainty == "linear":
                    left_out += [f"{name}: bends within its interval; --uncertainty sampled" for name in curved]
                    if curved and self.case.uncertainty is None:
                        self.job.console.warn(
                            f"the {LEVEL:.0%} intervals of {', '.join(curved)} are rough: within them these do not go "
                            f"straight with what is unsure; --uncertainty sampled runs {_WHOLE} cases drawn from it"
                        )
                    return self._told("linear", bands, left_out, slopes=slopes)
                one = len(curved) == 1
                reason = f"{', '.join(curved)} bend{'s' if one else ''} within {'its' if one else 'their'} interval"
        return self._sampled(reason, left_out)

    def _effects(self) -> tuple[dict[str, Array], dict[str, Array], Mapping[str, Array]]:
        """Return what each figure changes by along each direction, what it bends by, and its slopes where known."""
        slopes = self.near.gradient() if self.near is not None else None
        if self.near is None or slopes is None:
            runs: list[Answer] = []

            step = 1.0 if self.near is None else self.near.step
            total = 2 * len(propagation.directions(self.sources))
            with self._progress(total) as advance:

                def one(number: int, change: Array) -> Figures:
                    runs.append(self._answer({number: change}))
                    advance(len(runs) / total)
                    return runs[-1].figures

                effects, bends = propagation.differences(one, self.value, self.sources, step)
            pairs = list(zip(runs[::2], runs[1::2], strict=True))
            self._straight(
                {
                    name: np.array([0.5 / step * (up.fields[name] - down.fields[name]) for up, down in pairs])
                    for name in runs[0].fields
                }
            )
            return effects, bends, {}
        ends = np.cumsum([len(one.numbers) for one in self.origins.found])
        starts = [0, *ends[:-1]]
        blocks = propagation.directions(self.sources)

        def along_each(slope: Array) -> Array:
            """Return what goes with numbers as what goes along directions."""
            return np.array([column @ slope[starts[number] : ends[number]] for number, column in blocks])

        effects = {name: along_each(slope) for name, slope in slopes.figures.items()}
        self._straight({name: along_each(slope) for name, slope in slopes.fields.items()})
        return effects, {}, slopes.figures

    def _straight(self, along: dict[str, Array]) -> None:
        """Take fields as straight: what they change by along each direction says how sure they are."""
        self.along = along
        self.fields = {name: np.sqrt((each**2).sum(axis=0)) for name, each in along.items()}

    def _off(
        self, effects: Mapping[str, Array], bends: Mapping[str, Array]
    ) -> tuple[dict[str, Array], dict[str, tuple[float, float]]]:
        """Return by how much each figure leaves the straight line where an interval ends, its own and the others'; and
        with their signs, at the lower and the upper end of its own."""
        off: dict[str, list[float]] = {name: [] for name in effects}
        for name, one in bends.items():
            off[name].append(propagation.off_by_bends(effects[name], one))
        own: dict[str, list[tuple[float, float]]] = {}
        if self.near is not None:
            blocks = propagation.directions(self.sources)
            for place in propagation.ends({name: one for name, one in effects.items() if np.isfinite(one).all()}):
                there = self._answer(self._moved(place, blocks)).figures
                for name, along in effects.items():
                    if name not in there:
                        continue
                    away = there[name] - self.value[name] - along @ place
                    off[name].append(abs(float(away)))
                    own.setdefault(name, []).append((float(along @ place), float(away)))
        ends = {name: (min(one)[1], max(one)[1]) for name, one in own.items()}
        return {name: np.array(found) for name, found in off.items()}, ends

    def _sampled(self, reason: str | None, left_out: list[str]) -> Sure:
        count = self.near.samples if self.near is not None else _WHOLE
        blocks = propagation.directions(self.sources)
        drawn = propagation.draws(self.sources, count)
        rows, kept = [], []
        spread: dict[str, Spread] = {}
        with self._progress(count) as advance:
            for index, draw in enumerate(drawn):
                advance(index / count)
                try:
                    answer = self._answer(self._moved(draw, blocks))
                except HyperfabError:
                    continue
                rows.append(answer.figures)
                kept.append(index)
                for name, values in answer.fields.items():
                    spread.setdefault(name, Spread(len(blocks) if name in HANDED.get(self.kind, ()) else 0)).add(
                        values, draw
                    )
        self.fields = {name: found.sd for name, found in spread.items()}
        self.along = {name: found.along for name, found in spread.items()}
        lost = count - len(rows)
        if lost > _FAILED * count:
            why = f"{lost} of {count} runs that were drawn fail"
            self.job.console.warn(f"uncertainty is not carried: {why}")
            self.fields, self.along = {}, {}
            return self._told("sampled", {}, [*left_out, f"all figures: {why}"], reason=reason, samples=len(rows))
        left_out += [f"{lost} of {count} runs that were drawn, which fail"] if lost else []
        bands = {}
        undrawn = self.near.undrawn if self.near is not None else {}
        for name, value in self.value.items():
            outcomes = np.array([row.get(name, np.nan) for row in rows])
            told = np.isfinite(outcomes)
            if told.sum() < (1.0 - _FAILED) * count:
                lacking = f"{count - int(told.sum())} of {count} runs that were drawn do not have it"
                left_out.append(f"{name}: {undrawn.get(name, lacking)}")
                continue
            bands[name] = propagation.sampled(value, outcomes[told], drawn[kept][told], self.sources)
        return self._told("sampled", bands, left_out, reason=reason, samples=len(rows))

    def _progress(self, runs: int) -> contextlib.AbstractContextManager[Advance]:
        """Return what tells how far so many runs have come, and early how long they will take."""
        return self.job.console.progress("Carrying uncertainty", f"{runs} runs")

    def _moved(self, shares: Array, blocks: Sequence[tuple[int, Array]]) -> Changes:
        """Return what the numbers of all sources change by, ``shares`` of each independent direction on."""
        changes = {number: np.zeros(len(one.numbers)) for number, one in enumerate(self.origins.found)}
        for share, (number, column) in zip(shares, blocks, strict=True):
            changes[number] += share * column
        return changes

    def _answer(self, changes: Changes) -> Answer:
        if self.near is not None:
            return self.near.at(changes)
        changed = self.origins.changed(self.case, self.job.inputs, changes)
        case = put(changed.case, "uncertainty", "none")
        given = changed.files
        if "-" in case.inputs:
            given.setdefault("-", self.job.inputs.read("-"))
        return Answer(dict(figures_of(rerun(case, "-", given).document, self.kind)))

    def _least(self, name: str) -> float:
        """Return below which difference two values of a figure are one."""
        return max(_SLIGHT * abs(self.value[name]), 0.0 if self.near is None else self.near.blur(name))

    def _told(
        self,
        method: Any,
        bands: Mapping[str, propagation.Band],
        left_out: list[str],
        slopes: Mapping[str, Array] = {},
        **more: Any,
    ) -> Sure:
        names = [number.name for number in self.origins.numbers]
        told = Uncertainty(
            level=LEVEL,
            method=method,
            quantities={
                name: Band(
                    sd=band.sd,
                    low=band.low,
                    high=band.high,
                    budget=[Share(source=source, share=share) for source, share in band.budget],
                    sensitivities=dict(zip(names, map(float, slopes[name]), strict=True)) if name in slopes else None,
                )
                for name, band in bands.items()
                if band.sd > _NOTHING * abs(self.value[name])
            },
            left_out=left_out,
            **more,
        )
        handed: dict[str, Array] = {}
        for name in HANDED.get(self.kind, ()):
            if len(self.along.get(name, ())):
                told.handed.append(name)
                by = self._by_number(self.along[name])
                handed |= {f"{name}_by_{k}": each for k, each in enumerate(by, 1)}
        if told.quantities or handed:
            told.sources = [described(one) for one in self.origins.found]
        shown = {name: sd for name, sd in self.fields.items() if name not in _UNSEEN}
        return Sure(told, shown, handed)

    def _by_number(self, along: Array) -> list[Array]:
        """Return what goes along directions (r, n) as what goes with each number; of numbers that can only go together
        the sum is what counts, and each has the least there is."""
        found: list[Array] = []
        at = 0
        for one in self.sources:
            root = one.root
            found += list(np.linalg.pinv(root).T @ along[at : at + root.shape[1]])
            at += root.shape[1]
        return found


def _tell(job: Job, found: Uncertainty, value: Figures) -> None:
    """Show the bands to a person."""
    if found.reason is not None:
        job.console.note(f"uncertainty is sampled, {found.samples} runs: {found.reason}")
    rows = [
        [
            name,
            figure(value[name], band.sd),
            " to ".join(interval(band.low, band.high, band.sd)),
            shares(band.budget),
        ]
        for name, band in found.quantities.items()
    ]
    if not rows:
        job.console.note(f"no figure has an uncertainty: {'; '.join(found.left_out) or 'none hangs on what is stated'}")
        return
    job.console.table(f"How sure ({found.method})", ("figure", "± sd", "95 %", "made of"), rows)
