"""The tables a mold document names, read into functions."""

from __future__ import annotations

import numpy as np

from hyperfab.documents.quantity import TableFile
from hyperfab.errors import InputError
from hyperfab.io.csv_table import read_table
from hyperfab.io.inputs import Inputs
from hyperfab.thermal.tables import Table

#: What columns of a table may be called, by kind of quantity.
COLUMNS = {
    "film-coefficient": ("h", "film coefficient", "film"),
    "conductivity": ("conductivity", "k"),
    "specific-heat": ("specific heat", "specific_heat", "cp", "c"),
    "temperature": ("temperature", "T"),
    "power": ("power",),
    "dimensionless": ("contact", "closed"),
}


class Tables:
    """Reads tables beside the document ``document``."""

    def __init__(self, inputs: Inputs, document: str) -> None:
        self._inputs = inputs
        self._document = document
        #: Tables against temperature by kind and the name that the document gives them: their ends [degC].
        self.tabulated: dict[tuple[str, str], tuple[float, float]] = {}

    def function(self, value: float | TableFile, kind: str, against: str = "temperature") -> Table:
        """Return a constant, or the table of a file: ``kind`` against ``temperature`` or ``time``."""
        if not isinstance(value, TableFile):
            return Table.constant(value)
        return self.file(value.table, kind, against)

    def file(self, relative: str, kind: str, against: str) -> Table:
        """Read a table; InputError with the line where it does not rise, or a value is impossible."""
        name = self._inputs.beside(self._document, relative)
        data = self._inputs.read(name)
        names = COLUMNS[kind]
        table = read_table(
            data, name, {against: against}, optional=dict.fromkeys(names, kind), increasing=against
        )
        found = next((column for column in names if column in table), None)
        if found is None:
            read_table(data, name, {against: against, names[0]: kind})  # says which columns there are
            raise InputError(f"has no column {names[0]}", file=name)
        values = table[found]
        if kind != "temperature":
            self._refuse_negative(name, found, table.lines, values, kind)
        if against == "temperature":
            self.tabulated[kind, relative] = float(table[against][0]), float(table[against][-1])
        return Table(table[against], values)

    @staticmethod
    def _refuse_negative(name: str, column: str, lines: np.ndarray, values: np.ndarray, kind: str) -> None:
        must_be_positive = kind in ("conductivity", "specific-heat")
        bad = np.flatnonzero(values <= 0.0 if must_be_positive else values < 0.0)
        if bad.size:
            raise InputError(
                f"{values[bad[0]]:g} is {'not positive' if must_be_positive else 'negative'}",
                file=name,
                line=int(lines[bad[0]]),
                column=column,
                remedy="correct the value",
            )
