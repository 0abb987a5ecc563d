"""Which rows of a measured file are readings of their own, and which are one specimen's."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from hyperfab.arrays import Array, Flags
from hyperfab.chapters.fit.prepare import Steps, broken, stated
from hyperfab.chapters.job import Job
from hyperfab.errors import InputError, UsageError
from hyperfab.io.csv_table import Table
from hyperfab.io.headings import Heading, is_of, meaning
from hyperfab.io.roles import FEWEST_ROWS, begun_anew
from hyperfab.numerics.doubt import Doubt
from hyperfab.numerics.hygiene import look, sides, turns

#: Results whose instrument, a film or a load cell, has an end of its range (a contact is 0 or 1, and what no mold
#: touches has one thickness), and what moves while they are read: a hold reads the same without being at that end.
_RANGED, _WAYS = ("pressure", "force"), (*"xyz", "stroke", "depth")
#: What wobbles by less than this share of its way is held.
_HOLD = 0.02
#: Forces that are 0, and steps behind them, of which a load cell is known to show none so small.
_ZEROS = 3
AS_READ = Steps()
#: Pushes that are warmed between by so many kelvins are no repeats.
_WARMED = 2.0
#: What goes less far than this share of what the farthest does is no push of its own.
_FAR = 0.3
#: A force that goes so much (correlation) against its way was read along a way that counts the other way.
_AGAINST = 0.5


def once(table: Table, results: Sequence[str], left_out: Counter[str], along: str = "") -> Table:
    """Return a table of readings with every row once, in the order of what they were read ``along``, if anything; rows
    that are no reading, or copies, are counted in ``left_out``.

    ``results`` are the columns that say what was read, the others where. Rows that agree number for number are copies
    where no place was read again with another result; else they may be readings that agree. Copies would pass for
    repeats that have no noise. Pressures and forces at the end of an instrument's range are no readings
    either, nor forces of 0 that are less than a load cell shows: as quiet as they are, they would pass for noise that
    goes with the reading.
    """
    gone = Counter(table.left_out)
    where = [values for name, values in table.columns.items() if name not in results]
    rows = np.stack([*where, *(table[name] for name in results if name in table)], axis=1)
    _, first = np.unique(rows, axis=0, return_index=True)
    if len(first) == len(np.unique(rows[:, : len(where)], axis=0)) < len(rows):
        kept = np.sort(first)
        gone["row that stands there already"] += len(rows) - len(kept)
        table = table.rows(kept)
    if results[0] in _RANGED:
        ended = range_ended(table[results[0]])
        ways = [table[way] for way in _WAYS if way in table]
        if np.any(ended) and any(np.ptp(way[ended]) > _HOLD * np.ptp(way) for way in ways):
            gone[f"at the end of the range ({results[0]} {np.max(table[results[0]]):g})"] += int(np.sum(ended))
            table = table.rows(np.flatnonzero(~ended))
    if along:
        table = table.rows(np.argsort(table[along], kind="stable"))
    if along and results[0] == "force" and np.any(none := not_shown(table["force"])):
        gone[f"below what the load cell shows (force {np.min(table['force'][~none]):g})"] += int(np.sum(none))
        table = table.rows(np.flatnonzero(~none))
    left_out.update({f"{table.name}: {reason}": count for reason, count in gone.items()})
    return table


def specimens(table: Table, along: str) -> list[Table]:
    """Return the table of each specimen that a column names, called after it; else the table itself.

    A column that is called a specimen's is taken at its word. Words that nobody knows name specimens where each fills
    one run of rows at whose start the way ``along`` is near where that of the first began.
    """
    way = table[along]
    forces = [one.title for one in table.aside if _holds(one) == "force" and is_of(one.unit or "", "force")]
    if forces:
        raise InputError(
            "is a force too, and so is another column",
            file=table.name,
            column=forces[0],
            remedy=f"leave out which are not of the push, as in {table.option([(one, 'aside') for one in forces])}",
        )
    for head, cells in zip(table.aside, table.cells, strict=True):
        told = _holds(head)
        if told != "specimen":
            starts = begun_anew(cells, way) if told is None else []
            far = [float(np.ptp(part)) for part in np.split(way, starts)]
            if not starts or min(far) < _FAR * max(far):  # parts of one push: preload, push, hold
                continue
        parts = _parted(table, head, cells)
        if len(parts) > 1 and min(len(one.lines) for one in parts) >= FEWEST_ROWS:
            return parts
    return [table]


def _parted(table: Table, head: Heading, cells: Sequence[str]) -> list[Table]:
    """Return the table of each word of a column, called after it; the first has what was left out of all."""
    found: list[Table] = []
    for word in dict.fromkeys(cells):
        own = table.rows(np.array([row for row, cell in enumerate(cells) if cell == word], dtype=np.int64))
        others = [(one, column) for one, column in zip(own.aside, own.cells, strict=True) if one != head]
        aside, columns = tuple(one for one, _ in others), tuple(column for _, column in others)
        left_out = {} if found else table.left_out
        found.append(replace(own, name=f"{table.name} {word}", aside=aside, cells=columns, left_out=left_out))
    return found


def _holds(head: Heading) -> str | None:
    """Return what the dictionary has for a column, or None."""
    found = meaning(head)
    return None if found is None else found.name


def at_places(table: Table, where: Sequence[str]) -> list[Table]:
    """Return the table of each specimen that a column names; else the table itself.

    InputError where another column tells readings at the same places (``where``) apart, as frames and stages do: of
    them all the model has one state.
    """
    places = np.unique(np.stack([table[one] for one in where], axis=1), axis=0, return_inverse=True)[1].ravel()
    size = int(places.max(initial=-1)) + 1
    for head, cells in zip(table.aside, table.cells, strict=True):
        names = list(dict.fromkeys(cells))
        pairs = {*zip(cells, places.tolist(), strict=True)}
        if not 2 <= len(names) <= len(cells) // 2 or len(pairs) < len(cells) or len(pairs) < 0.9 * len(names) * size:
            continue
        if _holds(head) == "specimen":
            return _parted(table, head, cells)
        raise InputError(
            f"tells {len(names)} readings of each place apart ({', '.join(names[:3])}, …), and the model has one state",
            file=table.name,
            column=head.title,
            remedy=f"keep the rows of one; if each is a specimen of its own, say "
            f"{table.option([(head.title, 'specimen')])}, if they are repeats, {table.option([(head.title, 'aside')])}",
        )
    return [table]


def pushed(job: Job, table: Table, along: str, steps: Steps = AS_READ) -> Table:
    """Return forces without those behind a burst, on the way back and over again, which the table counts.

    Force and way are turned round where the machine counts them against the push, which is told, and counted from where
    the ``steps`` say. Warned of is a force that falls for good while the machine goes on, and one that is another on
    the way back or when it was pushed again: no sheet or sandwich of a model does either. The rows are as the machine
    wrote them.
    """
    table = _from_touch(_turned(job, table, along), along, steps)
    depth, force = table[along], table["force"]
    way = 1.0 + (depth - np.min(depth)) / max(float(np.ptp(depth)), 1e-300)
    end = broken(way, force)
    table = table.without(np.arange(len(way)) >= end, "behind the burst")
    way, force = way[:end], force[:end]
    others: list[Doubt] = []
    warmed = "temperature" in table and float(np.ptp(table["temperature"])) > _WARMED
    for doubt in look(way, force, time=table.columns.get("time")):
        if doubt.kind == "failing":
            size, line = f"{100 * doubt.size:.0f} % of the peak", table.lines[doubt.rows[0]]
            job.console.warn(
                f"{table.name}, line {line}: from here on the force falls, by {size}: what broke there? leave out "
                "these rows"
            )
        elif doubt.kind == "unloading" or (doubt.kind == "cycles" and not warmed):
            others.append(doubt)
    if not others:
        return table
    # What goes farther than any sweep before is pushed for the first time, unless it is warmer.
    first = turns(way)[0].stop
    again = (np.arange(end) >= first) & (way <= np.maximum.accumulate(np.concatenate([[-np.inf], way[:-1]])))
    gone = (sides(way) < 0) | (again & (not warmed))
    line = table.lines[min(min(doubt.rows) for doubt in others)]
    share = f"{100 * max(doubt.size for doubt in others):.0f} %"
    job.console.warn(
        f"{table.name}, line {line}: on the way back or when pushed again the force is another, by {share} of "
        f"the peak in the mean, which no model of a push knows: {np.count_nonzero(gone)} rows are left out; other "
        "specimens are told by a column specimen"
    )
    return table.without(gone, "on the way back or pushed again")


def _turned(job: Job, table: Table, along: str) -> Table:
    """Return forces of a push with force and way counted along it, each told where it is turned round."""
    columns = dict(table.columns)
    if float(np.sum(columns["force"])) < 0.0:
        columns["force"] = -columns["force"]
    if np.ptp(columns[along]) > 0.0 and np.ptp(columns["force"]) > 0.0:
        together = np.corrcoef(columns[along], columns["force"])[0, 1]
        if together < -_AGAINST:
            columns[along] = -columns[along]
    turned = [name for name in (along, "force") if columns[name] is not table[name]]
    if turned:
        job.console.note(f"{table.name}: {' and '.join(turned)} counted the other way: taken times -1")
    return replace(table, columns=columns)


def _from_touch(table: Table, along: str, steps: Steps) -> Table:
    """Return forces of a push counted from where the steps say: the first row, or where a force is reached."""
    columns = dict(table.columns)
    if steps.zero:
        columns |= {name: columns[name] - columns[name][0] for name in (along, "force")}
    if steps.preload is None:
        return replace(table, columns=columns)
    least, kind = stated(steps.preload)
    if kind != "force":
        raise UsageError(f"--preload {steps.preload}: of a push it is a force, as 0.1N")
    reached = np.flatnonzero(columns["force"] >= least)
    if not reached.size:
        raise InputError(
            f"does not reach the preload of {steps.preload}", file=table.name, remedy="state a smaller one"
        )
    row = int(reached[0])
    ends = slice(max(row - 1, 0), row + 1)
    columns[along] = columns[along] - np.interp(least, columns["force"][ends], columns[along][ends])
    return replace(table, columns=columns).without(np.arange(len(table.lines)) < row, f"before {steps.preload}")


def past_touch(name: str, way: Array, along: str) -> None:
    """InputError where a push has no way (n,) past the first touch, from which it counts."""
    if np.max(way) <= 0.0:
        raise InputError(
            f"has no {along} above 0",
            file=name,
            remedy=f"count {along} from the first touch: --zero counts it from the first row, --preload 0.1N from "
            "where that force is reached",
        )


def range_ended(values: Array) -> Flags:
    """Return which readings (n,), in no order, stand at the end of their instrument's range: at the largest one, digit
    for digit, and more than three times as many as agree anywhere else above zero.

    Some have to be less: where all agree, it is what there was to read.

    >>> int(range_ended(np.array([0.0, 0.0, 0.0, 0.0, 1.1, 1.4, 2.0, 2.0, 2.0, 2.0])).sum())
    4
    >>> bool(range_ended(np.full(9, 2.0)).any())
    False
    """
    found, counts = np.unique(values, return_counts=True)
    below = counts[:-1][found[:-1] > 0.0]
    ended = len(below) > 0 and counts[-1] > 3 * np.max(below)
    return np.asarray((values == found[-1]) & ended)


def not_shown(force: Array) -> Flags:
    """Return which forces (n,), in the order of the way, are 0 because the load cell shows none so small: where it
    shows one the first stands off 0 by more than twice what those behind it do off each other.

    >>> np.flatnonzero(not_shown(np.array([0.0, 0.0, 0.0, 0.5, 0.6, 0.72, 0.85]))).tolist()
    [0, 1, 2]
    >>> bool(not_shown(np.round(np.linspace(0.0, 9.0, 30) ** 2 / 9.0)).any())
    False
    """
    none = force == 0.0
    shown = np.abs(force[~none])
    if np.count_nonzero(none) < _ZEROS or len(shown) <= _ZEROS:
        return np.zeros_like(none)
    step = float(np.median(np.abs(np.diff(shown[: _ZEROS + 2]))))
    return np.asarray(none & bool(np.min(shown) > 2.0 * step > 0.0))
