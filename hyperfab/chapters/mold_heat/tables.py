"""The tables a mold document names, read into functions, and the names its parts, faces and probes go by."""

from __future__ import annotations

import difflib

from hyperfab.documents.mold import FacesInBox, MoldDocument
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
#: Kinds whose tables may say how sure they are, in a column ``NAME sd``.
_WITH_SD = ("film-coefficient",)


class Tables:
    """Reads tables beside the document ``document``."""

    def __init__(self, inputs: Inputs, document: str) -> None:
        self._inputs = inputs
        self._document = document
        #: Tables against temperature by kind and the name that the document gives them: their ends [degC].
        self.tabulated: dict[tuple[str, str], tuple[float, float]] = {}
        #: Tables against time by the name that the document gives them: their ends [s].
        self.timed: dict[str, tuple[float, float]] = {}
        #: Film coefficients that state how sure they are, by the file.
        self.unsure: dict[str, Table] = {}

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
        optional = dict.fromkeys(names, kind)
        if kind in _WITH_SD:
            optional |= {f"{column} sd": kind for column in names}
        table = read_table(data, name, {against: against}, optional=optional, increasing=against)
        found = next((column for column in names if column in table), None)
        if found is None:
            read_table(data, name, {against: against, names[0]: kind})  # says which columns there are
            raise InputError(f"has no column {names[0]}", file=name)
        values, positive = table[found], kind in ("conductivity", "specific-heat")
        for column in (found, f"{found} sd") if kind != "temperature" else ():
            if column in table:
                wrong = table[column] <= 0.0 if positive else table[column] < 0.0
                why = f"{{:g}} is {'not positive' if positive else 'negative'}"
                table.refuse(wrong, why, column=column, remedy="correct the value")
        ends = float(table[against][0]), float(table[against][-1])
        if against == "temperature":
            self.tabulated[kind, relative] = ends
        else:
            self.timed[relative] = ends
        sd = table.columns.get(f"{found} sd")
        read = Table(table[against], values, sd if sd is not None and sd.any() else None)
        if read.sd is not None:
            self.unsure[name] = read
        return read


#: Where ``exposed`` stands: every outer face without another condition.
EXPOSED = "exposed"
#: The ways a face can look.
WAYS = ("x-", "x+", "y-", "y+", "z-", "z+", "all")


def refuse_unknown_names(document: MoldDocument) -> None:
    """Raise InputError with the nearest names where a place names no body of the document."""
    known = document.names()
    parts = [part.name for part in document.part]
    for key, place in document.places():
        if isinstance(place, FacesInBox):
            _known(key, place.part, parts, "part")
        elif place != EXPOSED:
            body, _, way = place.rpartition(".")
            if not body or way not in WAYS:
                raise InputError(
                    f"{place!r} names no face",
                    key=key,
                    remedy=f"write NAME.WAY, as {known[0]}.z+, with WAY one of {' '.join(WAYS)}",
                )
            _known(key, body, known, "body", f".{way}")
    for number, heater in enumerate(document.heater):
        if heater.volume is not None:
            _known(f"heater.{number}.volume", heater.volume, parts, "part")
    for number, contact in enumerate(document.contact):
        for part in contact.between:
            _known(f"contact.{number}.between", part, parts, "part")


def refuse_exposed(document: MoldDocument) -> None:
    """Raise InputError where ``exposed`` stands for anything but one film and one radiation."""
    seen: dict[str, str] = {}
    for key, place in document.places():
        kind = key.split(".")[0]
        if place != EXPOSED:
            continue
        if kind not in ("convection", "radiation"):
            raise InputError("exposed is where convection and radiation act", key=key, remedy="name the faces")
        if kind in seen:
            raise InputError(
                f"exposed has a {kind} already, {seen[kind]}",
                key=key,
                remedy="take one of the two out, or name its faces",
            )
        seen[kind] = key


def _known(key: str, name: str, known: list[str], what: str, tail: str = "") -> None:
    if name not in known:
        near = difflib.get_close_matches(name, known, 4, 0.4) or known[:8]
        offered = ", ".join(other + tail for other in near)
        raise InputError(f"there is no {what} {name!r}", key=key, remedy=f"the nearest names are {offered}")
