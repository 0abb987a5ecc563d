"""What the command line says of a table: which column is what, where its head stands, the decimal mark."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

from hyperfab.errors import InputError, UsageError
from hyperfab.io.cells import is_one_at_rest, shape
from hyperfab.io.dictionary import fold, looked_up, plain
from hyperfab.io.heading_words import COLUMNS
from hyperfab.io.headings import KIND, Heading, beside, heading, is_of
from hyperfab.io.rows import Row
from hyperfab.io.units import is_unit

_ASIDE = ("aside", "ignore", "none", "-")
_ENTRY = (
    r"\s*(?:\"(?P<quoted>[^\"]*)\"|(?P<title>.+?))\s*=\s*(?P<sign>-?)(?P<name>{own}[A-Za-z][A-Za-z ]*?(?: ?[12])?|-)"
    r"\s*(?:\[(?P<unit>[^\]]*)\]|\((?P<round>[^)]*)\))?\s*(?:,|;|$)"
)


@dataclass(frozen=True)
class Choice:
    """One entry of ``--columns``: the column called ``title`` holds ``name`` in ``unit``, times -1 where ``minus``."""

    title: str
    name: str
    unit: str | None
    minus: bool = False

    @property
    def entry(self) -> tuple[str, str]:
        """The entry as it is typed: title, and name with sign and unit."""
        return self.title, f"{'-' if self.minus else ''}{self.name}" + (f" [{self.unit}]" if self.unit else "")

    @property
    def is_number(self) -> bool:
        """Whether the column is named by its number, from 1."""
        return re.fullmatch(r"#?\s*\d+", self.title.strip()) is not None

    def fits(self, head: Heading, alone: bool) -> bool:
        """Whether it is meant for a column: by its title or label, else by its number from 1."""
        # A column that is named already has that name for a label; what stands in the file names it still.
        names = {head.title, head.label, heading(head.title, head.index).label}
        if plain(self.title) and plain(self.title) in map(plain, names):
            return True
        if self.title.strip() and fold(self.title) in map(fold, names):
            return True
        return alone and re.fullmatch(r"#?\s*" + str(head.index + 1), self.title.strip()) is not None


@dataclass(frozen=True)
class Layout:
    """How tables are to be read where the command line says it: ``--columns``, ``--skip-rows``, ``--decimal``."""

    columns: tuple[Choice, ...] = ()
    skip_rows: int | None = None
    decimal: str | None = None

    @property
    def titles(self) -> tuple[str, ...]:
        """The titles that a file must have for its encoding to be the right one."""
        return tuple(one.title for one in self.columns)

    def choice(self, head: Heading, heads: Sequence[Heading]) -> Choice | None:
        """Return the entry that is meant for a column: whole titles first, then what they say, then numbers."""
        whole = {fold(other.title): other.index for other in reversed(heads)}
        for one in self.columns:
            if one.fits(head, alone=False) and whole.get(fold(one.title), head.index) == head.index:
                return one
        titled = {one for one in self.columns for other in heads if one.fits(other, alone=False)}
        return next((one for one in self.columns if one not in titled and one.fits(head, alone=True)), None)


#: Where the command line says nothing.
PLAIN = Layout()


def layout(
    columns: Sequence[str] = (), skip_rows: int | None = None, decimal: str | None = None, own: Sequence[str] = ()
) -> Layout:
    """Read the options as typed; UsageError where one cannot be meant. ``own`` are names that columns may have beside
    those of the dictionary: the probes of a mold.

    >>> layout(["Standardkraft=force [N],Weg, korr.=-extension [mm]"]).columns[1]
    Choice(title='Weg, korr.', name='extension', unit='mm', minus=True)
    """
    if skip_rows is not None and skip_rows < 0:
        raise UsageError(f"--skip-rows {skip_rows}: a number of lines, as 12")
    if decimal is not None and decimal not in (".", ","):
        raise UsageError(f"--decimal {decimal}: the decimal mark is . or ,")
    found = tuple(dict.fromkeys(one for text in columns for one in _choices(text, own)))
    titles = [one.title for one in found]
    twice = next((title for title in titles if titles.count(title) > 1), None)
    if twice is not None:
        raise UsageError(f"--columns: {twice} is said to be two things; a column is one")
    return Layout(found, skip_rows, decimal)


def _choices(text: str, own: Sequence[str]) -> list[Choice]:
    found, place = [], 0
    entry = re.compile(_ENTRY.format(own="".join(f"{re.escape(one)}|" for one in own)), re.IGNORECASE)
    while place < len(text):
        match = entry.match(text, place)
        name = None if match is None else _name(match["name"], own)
        if match is None or name is None:
            known = ", ".join(dict.fromkeys([*own, *COLUMNS, "aside"]))
            raise UsageError(
                f'--columns {text}: write it as in --columns "Standardkraft=force [N],Weg=extension '
                f'[mm]"; names are {known}'
            )
        written = match["unit"] if match["unit"] is not None else match["round"]
        read = None if written is None else beside(written)
        unit = None if written is None else read or "-"
        if (written or "").strip() not in ("", "-") and not (read and is_unit(read)):
            raise UsageError(f"--columns {text}: {written} is no unit")
        found.append(Choice((match["quoted"] or match["title"]).strip(), name, unit, bool(match["sign"])))
        place = match.end()
    return found


def _name(text: str, own: Sequence[str]) -> str | None:
    """Return the name of a column as the dictionary has it, with the number of its axis where there is one, or one of
    its ``own``, without case as columns are compared."""
    if text.casefold() in {one.casefold() for one in own}:
        return text.casefold()
    text = fold(text) if text not in _ASIDE else "aside"
    if text in ("aside", "ignore", "none"):
        return "aside"
    core, _, axis = text.rpartition(" ") if text[-1:] in "12" else (text, "", "")
    core = core or text.rstrip("12 ")
    axis = "" if axis in ("", "1") else f" {axis}"
    if core in COLUMNS:
        return core + axis
    known = looked_up(plain(core))
    return known[0].name + axis if known and known[0].name != "aside" else None


def filled_in(entries: Sequence[tuple[str, str]]) -> str:
    """Return the option that says what columns hold, ready to be pasted into a shell.

    >>> filled_in([("Kraft", "force [N]"), ('5" gauge', "aside")])
    '--columns \\'Kraft=force [N],5" gauge=aside\\''
    """
    text = ",".join(f"{title}={name}" for title, name in entries)
    if re.search(r"[\"$`\\!]", text):
        quoted = text.replace("'", "'\\''")
        return f"--columns '{quoted}'"
    return f'--columns "{text}"'


def named(choice: Choice, head: Heading) -> Heading:
    """Return a column as the command line names it; the unit of the file stands where none is typed."""
    kind, own = KIND.get(choice.name.rstrip(" 2")), head.unit or heading(head.title, head.index).unit
    if own is not None and kind == "dimensionless" and not is_of(own, kind):
        own = None  # Kanal 1 [V], said to be a stretch
    return Heading(head.title, choice.name, choice.unit or own, head.index)


def headless(rows: Sequence[Row], sought: Sequence[str]) -> InputError:
    """Return the error that no line names the columns, with what is ``sought``, of a test what its first readings
    suggest."""
    if sought:
        return InputError(
            "starts with numbers, there is no header",
            line=rows[0][0],
            remedy=f'name the columns, as in "{",".join(sought)}", or say what they are by number, whichever stands '
            f"first: {filled_in([(str(k), one) for k, one in enumerate(sought, 1)])}",
        )
    columns = list(zip(*(cells for _, cells in rows if len(cells) == len(rows[0][1])), strict=True))
    one, two = (*columns, ())[:2]
    names = [("1", shape(one, stress=two)), ("2", "stress [MPa]")]
    if names[0][1] != "stretch" and is_one_at_rest(two, one):
        names = [("1", "stress [MPa]"), ("2", "stretch")]
    return InputError(
        "starts with numbers, there is no header",
        line=rows[0][0],
        remedy=f'name the columns, as in "stretch,stress [MPa]", or say what they are by number: {filled_in(names)} '
        "(of a machine's own readings extension [mm] and force [N], whichever stands first)",
    )
