"""The picture of a closed loop: measured against predicted, the residual before and after, and the candidates."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from hyperfab.arrays import Array
from hyperfab.report.labels import AFTER, BEFORE, DATA, PLACES, png, title, value_names

_MOST_PANELS, _MOST_STATES, _MOST_ENTRIES = 12, 5, 10
#: A state of no more values than this is shown value by value, under its own names.
_FEW = 8
_VERDICTS = {
    "noise": "verdict noise: nothing is lacking that these data show",
    "effect": "verdict effect: {} added; what is left is noise",
    "ambiguous": "verdict ambiguous: {} added, or what these data cannot tell from it",
    "unexplained": "verdict unexplained: something is lacking beside {}",
}
#: What a reading in this unit is.
_READINGS = {
    "MPa": "nominal stress",
    "N/mm": "membrane stress",
    "N": "force",
    "degC": "temperature",
    "mm": "place",
}
#: States that tell tests apart, in the order they are named, and what they may wander by within a test; one that moves
#: more does not.
_TELL = {"mode": 0.0, "direction_deg": 1.0, "temperature_degC": 2.0, "probe": 0.0}


@dataclass(frozen=True)
class LoopPicture:
    """What the picture of a closed loop shows.

    abscissa, label       what the readings are drawn over, and its name
    unit                  of the readings
    curves                the rows of each test
    measured              the readings
    before, after         what the model says of them, refitted and with what was added
    sd                    standard deviations of the readings
    states                the state variables the residual, in units of ``sd``, is drawn against; readings at scattered
                          places are drawn as maps
    scores, scores_label  of the entries, and what they are
    verdict, added        what was found
    value_words           what the values of a state number
    delivered             what the model tells before any of its constants was refitted
    widths                stretch, measured transverse stretch and what the model says of it before and after, each
                          (rows,), curve by curve; none where it was not read
    """

    abscissa: Array
    label: str
    unit: str
    curves: Sequence[slice]
    measured: Array
    before: Array
    after: Array
    sd: Array
    states: Mapping[str, Array]
    scores: Mapping[str, float]
    scores_label: str
    verdict: str
    added: Sequence[str]
    value_words: Mapping[str, Sequence[str]] = field(default_factory=dict)
    delivered: Array | None = None
    widths: Sequence[tuple[Array, Array, Array, Array]] = ()

    def png(self) -> bytes:
        """Return the picture as PNG."""
        return png(self.drawing(), 100)

    def drawing(self) -> Figure:
        """Return the picture."""
        places = next((pair for pair in PLACES if all(name in self.states for name in pair)), None)
        shown = {name: values for name, values in self.states.items() if _varies(values)}
        shown = dict(list(shown.items())[:_MOST_STATES])
        columns = max(len(shown), 2)
        words = self.value_words
        kinds = kinds_of_test(self.curves, self.states, words) if places is None else {}
        upper_height = 4.4 if len(kinds) < 4 else 2.2 * _grid(min(len(kinds), _MOST_PANELS))[1]
        figure = Figure(figsize=(3.1 * columns + 1.0, 3.8 + upper_height), layout="constrained")
        halves = figure.add_gridspec(2, 1, height_ratios=[upper_height, 3.5])
        split = max(columns - max(columns // 3, 1), 1)
        upper = halves[0].subgridspec(1, columns)
        if places is None:
            self._curves(figure, upper[0, :split], kinds)
        else:
            self._maps(figure, upper[0, :split], places)
        beside = upper[0, split:].subgridspec(2 if self.widths else 1, 1)
        _scores(figure.add_subplot(beside[0, 0]), self.scores, self.scores_label, self.added)
        if self.widths:
            _widths(figure.add_subplot(beside[1, 0]), self.widths)
        scale = np.maximum(self.sd, 1e-300)
        lower = halves[1].subgridspec(1, columns)
        for column, (name, values) in enumerate(shown.items()):
            axes = figure.add_subplot(lower[0, column])
            rests = (self.measured - self.before) / scale, (self.measured - self.after) / scale
            _residual(axes, name, values, *rests, words.get(name, ()))
            if column == 0:
                axes.set_ylabel("measured - model, in sd of a reading about its curve")
                axes.legend(fontsize=8, loc="best", markerscale=4)
        heading = _VERDICTS[self.verdict].format(", ".join(self.added) or "nothing")
        # A line of the heading holds some 11 letters an inch; constrained layout does not make room to the sides.
        room = int(10.5 * figure.get_figwidth())
        told = (heading, self._missed())
        figure.suptitle("\n".join(textwrap.fill(line, room, break_on_hyphens=False) for line in told))
        return figure

    def _missed(self) -> str:
        """Return by how much of the readings (rms) the model misses them, as it was given and as it became."""
        models = {"as delivered": self.delivered, "refitted": self.before, "at the end": self.after}
        told = [
            f"{_share(self.measured - one, self.measured)} {name}"
            for name, one in models.items()
            if one is not None and np.all(np.isfinite(one))
        ]
        words = f"misses the readings by {', '.join(told)}" if told else ""
        if self.widths:
            _, read, before, after = (np.concatenate(part) for part in zip(*self.widths, strict=True))
            narrower = (_share(read - one, 1.0 - read) for one in (before, after))
            words += "; how much narrower it becomes by {} refitted, {} at the end".format(*narrower)
        return words

    def _curves(self, figure: Any, place: Any, kinds: Mapping[str, Sequence[int]]) -> None:
        """Draw the curves in panels of one scale, one for each kind of test."""
        chosen = list(kinds)
        if len(chosen) > _MOST_PANELS:
            chosen = [chosen[round(i)] for i in np.linspace(0, len(chosen) - 1, _MOST_PANELS)]
        across, down = _grid(len(chosen))
        panels = place.subgridspec(down, across)
        first: Any = None
        for number, kind in enumerate(chosen):
            axes = figure.add_subplot(panels[divmod(number, across)], sharex=first, sharey=first)
            for curve in kinds[kind]:
                rows = self.curves[curve]
                axes.plot(self.abscissa[rows], self.measured[rows], ".", ms=2.5, color=DATA, label="measured")
                axes.plot(self.abscissa[rows], self.before[rows], "-", lw=0.9, color=BEFORE, label="model before")
                axes.plot(self.abscissa[rows], self.after[rows], "-", lw=1.2, color=AFTER, label="model after")
            if first is None:
                first = axes
                axes.legend(axes.lines[:3], ["measured", "model before", "model after"], fontsize=8, markerscale=2)
                axes.set_ylabel(f"{_READINGS.get(self.unit, 'reading')} [{self.unit}]")
            axes.grid(alpha=0.3)
            axes.set_title(kind, fontsize=9)
            axes.tick_params(labelbottom=number + across >= len(chosen), labelleft=number % across == 0)
            if number + across >= len(chosen):
                axes.set_xlabel(self.label)
        if len(chosen) < len(kinds):
            first.set_ylabel(f"{first.get_ylabel()}; {len(chosen)} of {len(kinds)} kinds of test")

    def _maps(self, figure: Any, place: Any, names: tuple[str, str]) -> None:
        """Draw what is left at each place, before and after on one scale: arrows where it has two axes in the plane."""
        x, y = (self.states[name] for name in names)
        axis = self.states.get("axis")
        before, after = self.measured - self.before, self.measured - self.after
        pair = place.subgridspec(1, 2)
        vectors = axis is not None and len(np.unique(axis)) == 3
        if vectors:
            assert axis is not None
            rows = [np.flatnonzero(axis == k) for k in range(3)]
            at = rows[0]
            rests = [np.stack([rest[k] for k in rows], axis=1) for rest in (before, after)]
            sizes = [np.linalg.norm(rest, axis=1) for rest in rests]
        else:
            at, sizes, rests = np.arange(len(x)), [before, after], []
        top = max(float(np.nanmax(np.abs(sizes[0]))), float(np.nanmax(np.abs(sizes[1]))), 1e-300)
        scale = Normalize(0.0 if vectors else -top, top)
        drawn, panels = None, []
        for number, (words, size) in enumerate(zip(("before", "after"), sizes, strict=True)):
            axes = figure.add_subplot(pair[0, number])
            colours = "viridis" if vectors else "RdBu_r"
            drawn = axes.scatter(x[at], y[at], c=size, cmap=colours, norm=scale, s=14, edgecolors="0.5", linewidths=0.2)
            if vectors:
                rest = rests[number]
                reach = 0.12 * max(float(np.ptp(x[at])), float(np.ptp(y[at])), 1e-9)
                axes.quiver(
                    x[at], y[at], rest[:, 0], rest[:, 1], angles="xy", scale_units="xy", scale=top / reach,
                    color="0.15", width=0.004,
                )  # fmt: skip
            root = float(np.sqrt(np.nanmean(size**2)))
            axes.set_title(f"{words}: {root:.3g} {self.unit} rms", fontsize=9)
            axes.set_aspect("equal")
            axes.set_xlabel(title(names[0]), fontsize=8)
            axes.set_ylabel(title(names[1]) if number == 0 else "", fontsize=8)
            axes.tick_params(labelsize=7)
            panels.append(axes)
        figure.colorbar(
            drawn,
            ax=panels,
            label=f"measured - model [{self.unit}]",
            shrink=0.75,
            location="bottom",
            aspect=40,
        )


def _share(rest: Array, whole: Array) -> str:
    """Return the rms of a rest as a share of the whole's."""
    return f"{100.0 * float(np.sqrt(np.mean(rest**2))) / (float(np.sqrt(np.mean(whole**2))) or 1.0):.2g} %"


def _widths(axes: Any, widths: Sequence[tuple[Array, Array, Array, Array]]) -> None:
    """Draw how much narrower specimens become, measured and by the model before and after."""
    for stretch, measured, before, after in widths:
        axes.plot(stretch, measured, ".", ms=2.5, color=DATA)
        axes.plot(stretch, before, "-", lw=0.9, color=BEFORE)
        axes.plot(stretch, after, "-", lw=1.2, color=AFTER)
    axes.set_xlabel("stretch")
    axes.set_ylabel("transverse stretch")
    axes.grid(alpha=0.3)


def _varies(values: Array) -> bool:
    known = values[np.isfinite(values)]
    return len(known) > 0 and float(np.ptp(known)) > 1e-6 * max(1.0, float(np.abs(known).max()))


def _grid(count: int) -> tuple[int, int]:
    """Return how many panels stand beside and below each other."""
    across = count if count <= 3 else 2 if count == 4 else 3 if count <= 9 else 4
    return across, -(-count // across)


def _scores(axes: Any, scores: Mapping[str, float], label: str, added: Sequence[str]) -> None:
    rows = sorted(scores.items(), key=lambda item: item[1])[-_MOST_ENTRIES:]
    colours = [AFTER if name in added else "0.7" for name, _ in rows]
    values = np.array([max(value, 0.0) for _, value in rows])
    axes.barh(range(len(rows)), values, color=colours)
    axes.set_yticks(range(len(rows)), [name for name, _ in rows], fontsize=8)
    if len(values) and values.max() > 0.0:
        axes.set_xscale("symlog", linthresh=10.0)
        axes.xaxis.set_major_formatter("{x:g}")
    else:
        axes.set_xlim(0.0, 10.0)
        axes.text(0.5, 0.5, "no entry helps", transform=axes.transAxes, ha="center", color="0.4")
    axes.set_xlabel(label)


def _residual(axes: Any, name: str, values: Array, before: Array, after: Array, known: Sequence[str] = ()) -> None:
    """Draw what is left against a state: at its own values, or value by value where there are few."""
    axes.axhspan(-2.0, 2.0, color="0.9")
    values = np.exp(values) if name == "log rate" else values
    finite = np.isfinite(values)
    reach = float(np.ptp(values[finite]))
    # What differs by rounding, as rates of one machine do, stands together.
    near = np.full(len(values), np.nan)
    near[finite] = clusters(values[finite], 1e-3 * reach)
    distinct = np.unique(near[finite])
    at, beside = values, 0.0
    if len(distinct) <= _FEW:
        # Equally far apart, each under its own value, so that no reading seems to stand where none was taken.
        at, beside = np.full(len(values), np.nan), 0.14
        at[finite] = np.searchsorted(distinct, near[finite])
        axes.set_xticks(range(len(distinct)), value_names(name, distinct.tolist(), known))
        axes.set_xlim(-0.6, len(distinct) - 0.4)
        axes.tick_params(axis="x", labelsize=8, rotation=30 if len(distinct) > 4 else 0)
    elif name == "log rate":
        axes.set_xscale("log")
    else:
        axes.locator_params(axis="x", nbins=5)
    axes.plot(at - beside, before, ".", ms=2, color=BEFORE, alpha=0.5, label="before")
    axes.plot(at + beside, after, ".", ms=2, color=AFTER, alpha=0.5, label="after")
    axes.set_xlabel(title(name))


def kinds_of_test(
    curves: Sequence[slice], states: Mapping[str, Array], words: Mapping[str, Sequence[str]]
) -> dict[str, list[int]]:
    """Return the numbers of the curves of each kind of test, named by what the kinds differ in, in that order.

    ``words`` name what the values of a state number.

    >>> curves = [slice(0, 2), slice(2, 4), slice(4, 6)]
    >>> hot = np.array([23.0, 23.1, 80.0, 80.0, 80.2, 80.1])
    >>> kinds_of_test(curves, {"temperature_degC": hot}, {})
    {'23 °C': [0], '80 °C': [1, 2]}
    """
    told: list[tuple[list[float], list[str]]] = [([], []) for _ in curves]
    for name, wander in _TELL.items():
        values = states.get(name)
        if values is None:
            continue
        means = _means([values[rows] for rows in curves], wander)
        if means is None:
            continue
        groups = clusters(means, wander)
        if len(np.unique(groups)) < 2:
            continue
        for number, group in enumerate(groups):
            told[number][0].append(float(group))
            told[number][1].append(_word(name, group, words.get(name, ())))
    found: dict[str, list[int]] = {}
    for number in sorted(range(len(curves)), key=lambda k: told[k][0]):
        found.setdefault(", ".join(told[number][1]), []).append(number)
    return found


def clusters(values: Array, apart: float) -> Array:
    """Return for each value the mean of those it stands together with, none further than ``apart`` from the next.

    >>> clusters(np.array([1.0, 5.0, 1.5]), 1.0).tolist()
    [1.25, 5.0, 1.25]
    """
    order = np.argsort(values)
    group = np.concatenate([[0], np.cumsum(np.diff(values[order]) > apart)])
    means = np.bincount(group, weights=values[order]) / np.bincount(group)
    found = np.empty_like(values)
    found[order] = means[group]
    return found


def _means(parts: Sequence[Array], wander: float) -> Array | None:
    """Return the value of each test; None where it is unknown or moves within one."""
    still = all(len(part) and np.all(np.isfinite(part)) and np.ptp(part) <= wander for part in parts)
    return np.array([float(np.mean(part)) for part in parts]) if still and parts else None


def _word(name: str, value: float, known: Sequence[str]) -> str:
    if name == "temperature_degC":
        return f"{value:.0f} °C"
    if name == "direction_deg":
        along = {0: "warp", 90: "weft"}
        return along.get(round(value), f"{value:.0f}°") if abs(value - round(value)) < 0.5 else f"{value:.1f}°"
    return value_names(name, [round(value)], known)[0]
