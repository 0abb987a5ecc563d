"""What is said of readings that took no part (tests, probes, parts of a file), and of those that read nothing."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from hyperfab.documents.loop import Errors, Misfit
from hyperfab.loop.engine import Finding
from hyperfab.loop.problem import Problem
from hyperfab.loop.thresholds import MARGIN, SHARE

#: What says of an error that it is on files that were set apart.
OF_FILES = "the files of --hold-out"
#: What is left out of the readings, one by one: one of them, several. Files of other domains are cut in parts, so that
#: one that is alone tells too.
_PARTS = {"heat": ("probe", "probes"), "fabric": ("test", "tests")}
_OTHERS = ("part of the readings", "parts of the readings")
#: Readings of nothing are told of from this share of all on.
_SILENT = 0.1


def parts_of(domain: str, held: Errors | None = None, many: bool = True) -> str:
    """Return what is left out in a domain, in words; where it is known of ``held``, that.

    >>> parts_of("heat"), parts_of("press", many=False)
    ('probes', 'part of the readings')
    """
    of_files = held is not None and held.source == OF_FILES
    return (_PARTS["fabric"] if of_files else _PARTS.get(domain, _OTHERS))[many]


def size_of(misfit: Misfit, unit: str) -> str:
    """Return how large a misfit is, in its unit and as a share."""
    return f"{misfit.rms:.3g} {unit} ({100.0 * misfit.relative_rms:.2g} %)"


def not_added(names: Sequence[str], domain: str) -> str:
    """Return that names were left out for what they do to the readings that take no part."""
    return f"not added: {', '.join(names)}; with it these data, or {parts_of(domain)} left out, are missed by more"


def refused(found: Finding, domain: str) -> Iterator[str]:
    """Yield why an entry that lowers BIC was not added, where nothing was and nothing else says so."""
    if found.added:
        return
    for name, one in found.tried.items():
        if one.delta_bic < MARGIN or one.accepted() or name in (*found.doubted, *found.worse):
            continue
        if one.help is not None and one.variance_share >= SHARE:
            why = f"{parts_of(domain)} left out are foretold no better with it"
        else:
            why = f"it takes {one.variance_share:.0%} of what lacks"
        yield f"{name} lowers BIC by {one.delta_bic:.0f}, but is not added: {why}."


def missed_by_more(held: Errors, domain: str) -> str:
    """Return that what was added is no good for readings that took no part."""
    parts = parts_of(domain, held)
    return (
        f"{parts} left out are missed by {size_of(held.after, held.unit)} with what was added, by "
        f"{size_of(held.before, held.unit)} without: do not carry it over to {parts} like these"
    )


def told_of(held: Errors, domain: str) -> str:
    """Return by how much readings are missed that took no part."""
    many = held.tests != 1
    parts = f"{'' if held.tests is None else f'{held.tests} '}{parts_of(domain, held, many)}"
    how = f", {'each ' * many}predicted from the others" if held.source != OF_FILES else ""
    before, after = size_of(held.before, held.unit), size_of(held.after, held.unit)
    if held.before.rms == held.after.rms:
        return f"On {parts} left out{how} it misses by {before}."
    return f"On {parts} left out{how} it misses by {before} without, by {after} with what was added."


def silent(problem: Problem, found: Finding) -> str:
    """Return how many readings read nothing where the model has nothing either, where they are many.

    What all readings are missed by is then less than the noise of those that read something.
    """
    first = problem.channel == 0
    none = np.all([rows[first] == 0.0 for rows in (problem.measured, found.after.fit.predicted)], axis=0)
    if np.mean(none) < _SILENT:
        return ""
    return (
        f" where something is read; the misfit is that of all {len(none)} readings, of which {np.count_nonzero(none)} "
        "read nothing where the model has nothing"
    )
