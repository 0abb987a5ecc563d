"""The signs of a test: mechanics counts pulling as positive, machines may count pushing so."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hyperfab.arrays import Array
from hyperfab.io.csv_numbers import numbers
from hyperfab.io.csv_sheet import CsvSheet
from hyperfab.io.kinds_of_tests import Pressed
from hyperfab.io.roles import STRESSES, STRETCHES, Column, Roles


def farthest(values: Array, rest: float = 0.0) -> float:
    """Return the one of ``values`` (n,) that is farthest from ``rest``, the first of several."""
    return float(values[int(np.abs(values - rest).argmax())])


def counts_down(sheet: CsvSheet, roles: Roles, decimal: str) -> tuple[Column, Column] | None:
    """Return the columns of a pull where both go down, as of a stand that counts pushing as positive; else None."""
    pull, push = roles.first(("extension", "position", "strain")), roles.first(STRESSES)
    if pull is None or push is None or roles.first(STRETCHES) is not pull:
        return None
    if any(one.compressive or sheet.layout.choice(one.heading, sheet.headings) for one in (pull, push)):
        return None
    ways, forces = (numbers(sheet, one.heading, decimal) for one in (pull, push))
    if pull.name == "position":
        ways = ways - ways[0]
    return (pull, push) if farthest(ways) < 0.0 and farthest(forces) < 0.0 else None


def perhaps_pulled(sheet: CsvSheet, down: tuple[Column, Column], stretch: Array) -> str:
    """Return what is told where a machine's two readings count down and nothing says whether it pressed or pulled."""
    titles = " and ".join(one.heading.title for one in down)
    return (
        f"{titles} count down: taken as a compression, to a stretch of {stretch.min():.3g}; if it was pulled, say "
        + _signs(sheet, down, "--")
    )


def _signs(sheet: CsvSheet, used: Sequence[Column], signs: Sequence[str]) -> str:
    """Return the option that gives columns their ``signs``, each a minus or nothing."""
    units = [f" [{one.heading.unit}]" if one.heading.unit else "" for one in used]
    return sheet.option(
        [(one.heading.title, f"{minus}{one.name}{unit}") for minus, one, unit in zip(signs, used, units, strict=True)]
    )


def of_mechanics(
    test: str,
    pressed: Pressed,
    force: Column | None,
    stretch: Array,
    stress: Array,
    notes: list[str],
) -> tuple[Array, Array]:
    """Return stretch and stress (n,) of a ``test`` with the signs of mechanics; ``notes`` tells what was turned round.

    ``force`` is the column of a force, where there is one.
    """
    if test == "simple-shear" and -stretch.min() > stretch.max():
        # Which way counts as positive is a choice of the machine: a body alike all round knows no difference.
        notes.append("sheared the way that counts as negative in the file, which is taken as positive")
        return 0.0 - stretch, 0.0 - stress
    longer = farthest(stretch, 1.0) > 1.0
    pulled = test == "uniaxial" and longer
    if pulled and force is not None and not force.minus and stress.max() < 0.05 * -stress.min():
        # A rheometer's normal force, a load cell that counts pulling as negative; a stress is as stated.
        stress = 0.0 - stress
        notes.append(f"{force.heading.title} counts pushing as positive: what pulls is taken as positive")
    if pressed == "yes" and test in ("uniaxial", "confined-compression"):
        if longer:
            stretch = 2.0 - stretch
            notes.append("a compression test: its strain, counted positive in the file, is taken as negative")
        if farthest(stress) > 0.0:
            stress = -stress
            notes.append("a compression test: its stress, counted positive in the file, is taken as negative")
    return stretch, stress


def refuse_either_way(sheet: CsvSheet, used: Sequence[Column], stretch: Array, stress: Array) -> None:
    """InputError where a word says compression, nothing says that it is of the test, and the readings are of a pull."""
    pull, push = used[:2]
    if farthest(stretch, 1.0) <= 1.0 or pull.compressive or push.compressive:
        return
    if all(sheet.layout.choice(one.heading, sheet.headings) for one in (pull, push)):
        return
    behind = "-" if farthest(stress) < 0.0 else ""

    def option(*signs: str) -> str:
        return _signs(sheet, (pull, push), signs)

    raise sheet.wrong(
        f"a word says compression, and {pull.heading.title} grows: was the specimen pressed, or is that what it is of?",
        remedy=f"if it was pulled, say {option('', behind)}; if it was pressed, "
        f'{option("-", "" if behind else "-")}, or add a first line "# test: compression"',
    )
