"""What no test can have shown: most likely a wrong unit, a wrong column or a wrong sign."""

from __future__ import annotations

import numpy as np

from hyperfab.curve import TestCurve
from hyperfab.errors import InputError
from hyperfab.io.csv_sheet import CsvSheet
from hyperfab.io.kinds_of_tests import is_pulled
from hyperfab.io.roles import STRESSES, STRETCHES, STRONGEST, Column, Roles

#: Beyond these no fabric or rubber was ever tested: a wrong unit or a wrong column. The stress is the largest of a
#: test, in MPa or N/mm.
LARGEST_STRETCH = 50.0
PEAK_STRESS = (1e-9, STRONGEST)
#: Up to this share of the rows of a push may read tension.
_FEW = 0.1


def _as_strain(sheet: CsvSheet, column: Column) -> str:
    """Return the option that says of a column that it is a strain, in its unit."""
    return sheet.option([(column.heading.title, f"strain [{column.heading.unit or '-'}]")])


def refuse_impossible(found: TestCurve, sheet: CsvSheet, columns: Roles, clock: bool) -> list[str]:
    """Return what was read that no test shows, in few rows: they stay. InputError, with the line, where it is the file.

    What is merely odd is the fit's to judge. Without ``clock`` times are not judged.
    """
    if found.mode in ("volumetric", "simple-shear"):
        return []
    stretch, stress = found.stretch, found.stress

    def refuse(row: int, message: str, remedy: str) -> InputError:
        line = None if found.lines is None else int(found.lines[row])
        return InputError(message, line=line, remedy=remedy)

    held = found.stretch2 is not None or found.time_s is not None  # a strip test across, a relaxation
    if len(stretch) > 1 and np.ptp(stretch) == 0.0 and not held:
        raise refuse(0, f"the stretch is {stretch[0]:g} in all {len(stretch)} rows", "export the stretch of every row")
    peak = float(np.abs(stress).max())
    # A pull may begin with slack; what is nowhere longer than at rest was not pulled.
    below = 0.9 if stretch.max() > 1.001 else max(0.9, 0.5 * (1.0 + float(stretch.min())))
    swapped = (
        np.flatnonzero((stretch < below) & (stress > 0.05 * peak))
        if peak > 0.0 and found.mode != "biaxial-general"
        else np.array([], dtype=int)
    )
    told = []
    # A glitch of the load cell, or a platen that sticks, is no wrong column.
    if swapped.size > _FEW * np.count_nonzero(stretch < below):
        row = int(swapped[0])
        pull, push = columns.first(STRETCHES), columns.first(STRESSES)
        remedy = "are the columns of stretch and stress swapped?"
        if pull is not None and pull.name == "stretch" and stretch.min() < 0.5 and stress.min() >= 0.0:
            remedy = f"is it a strain? then say {_as_strain(sheet, pull)}; {remedy}"
        elif push is not None and pull is not None:
            signed = pull.name not in ("stretch", "length")  # none of these is below nothing
            for turned, where in [(pull, "it was pulled")] * signed + [(push, "pushing counts as positive")]:
                flip = sheet.option([(turned.heading.title, f"-{turned.name} [{turned.heading.unit or '-'}]")])
                remedy += f" where {where}, say {flip};" if turned is pull or not is_pulled(sheet) else ""
            remedy = remedy.rstrip(";")
        raise refuse(
            row,
            f"tension ({stress[row]:g} {found.stress_unit}) at a stretch of {stretch[row]:g}, below 1",
            remedy,
        )
    if swapped.size:
        lines = swapped if found.lines is None else found.lines[swapped]
        told.append(f"tension below a stretch of 1 in {len(lines)} of {len(stretch)} rows, first line {lines[0]}")
    pull = columns.first(STRETCHES)
    if pull is not None and pull.name == "strain" and sheet.layout.choice(pull.heading, sheet.headings) is None:
        rest = int(np.abs(stress).argmin())
        # No strain is one at rest, and none carries less the larger it is: both are stretches, the latter of a push.
        pushed = stretch.max() - 0.02 < stretch[rest] > stretch.min() + 0.02
        if abs(stretch[rest] - 2.0) < 0.02 and (pushed or abs(stress[rest]) <= 0.02 * peak) and stretch.min() > 1.2:
            title = pull.heading.title
            raise refuse(
                rest,
                f"a strain of {stretch[rest] - 1.0:g} where the stress is {stress[rest]:g}",
                f"is it a stretch? then say {sheet.option([(title, 'stretch')])}; if it is none, "
                f"{_as_strain(sheet, pull)}",
            )
    if clock and found.time_s is not None:
        back = np.flatnonzero(np.diff(found.time_s) < 0.0)
        if back.size and found.cycle is None and found.branch is None and found.rate_1_s is None:
            column = columns.columns.get("time")
            drop = "" if column is None else f"; without the times: {sheet.option([(column.heading.title, 'aside')])}"
            raise refuse(
                int(back[0]) + 1,
                f"the time goes back from {found.time_s[back[0]]:g} s to {found.time_s[back[0] + 1]:g} s",
                f"sort the rows, or tell the specimens apart in a column named specimen{drop}",
            )
    row = int(stretch.argmax())
    if stretch[row] > LARGEST_STRETCH or stretch.min() < 1.0 / LARGEST_STRETCH:
        row = row if stretch[row] > LARGEST_STRETCH else int(stretch.argmin())
        raise refuse(row, f"no fabric reaches a stretch of {stretch[row]:g}", "check the unit of the column")
    if peak > 0.0 and not PEAK_STRESS[0] < peak < PEAK_STRESS[1]:
        row = int(np.abs(stress).argmax())
        raise refuse(row, f"no fabric carries {peak:g} {found.stress_unit} at most", "check the unit of the column")
    return told
