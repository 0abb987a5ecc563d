"""What lines above a table state: words, and values beside them."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace

from hyperfab.io.cells import is_clock, is_number
from hyperfab.io.dictionary import fold, is_closing, plain, setting, setting_along, words
from hyperfab.io.headings import heading, is_of, unit_behind, unit_of
from hyperfab.io.named_tests import is_test, kind_named
from hyperfab.io.other_tests import unread
from hyperfab.io.rows import Row

#: Settings that are amounts: without a digit the cell beside one is the next title of a table.
SIZES = (
    "width", "thickness", "gauge length", "grip distance", "diameter", "area", "specimen length", "height",
    "extensometer length",
)  # fmt: skip
#: A title with such a word names a test; others, as ``shear modulus``, may be a setting's.
_OF_A_TEST = re.compile(r"(\btests?|versuche?|prufung|proef)\b|试验|試験|\b(ensayo|essai|prova|ensaio|proba)\b")
#: What parts the settings of one cell; a comma that no space follows may be a decimal mark.
_BETWEEN = re.compile(r";|, ")
#: A decimal comma that parted two cells.
_SPLIT = re.compile(r"(?<=\d), (?=\d)")
#: A setting under its group, in a cell of its own: Specimen properties : Width.
_GROUPED = re.compile(r"[^:=]{1,60}? : ([^:=]+)")
#: A number, perhaps with a unit behind it; and a name before one.
_AMOUNT = re.compile(r"[-+]?\d[\d.,]* ?\S{0,12}")
_KEY_AND_AMOUNT = re.compile(r"(\D{2,60}?) +([-+]?\d[\d.,]* ?\S{1,12})")
#: What tells how warm the room is, where a test may be made at another temperature.
_ROOM = """room temperature; ambient temperature; lab temperature; laboratory temperature; raumtemperatur;
    umgebungstemperatur; temperatura ambiente; temperature ambiante; 室温; 环境温度"""
#: Settings that are none, or change nothing.
_UNTOLD = (None, "quiet")
_SETTING = re.compile(r"\s*([^:=]{1,80}?)\s*[:=]\s*(.*)")
#: In a sentence, an amount and what stands in the place of its unit.
_LENGTH = re.compile(r"(?<![\w.,])(\d+(?:[.,]\d+)?) ?(\"|[^\W\d]{1,2})(?![\w/*^\u00b2\u00b3])")
#: Where a clause ends, in a number no blank follows the mark; and where a sentence does.
_CLAUSE = re.compile(r"[,;:()]\s|\.\s|\.$|\s[-\u2013]\s")
_SENTENCE = re.compile(r"[.;]\s")
#: What stands between a size and its amount, and what joins a size to another.
_LINKS = words("of; was; is; were; are; about; approx; ca; the; ist; war; von; betrug; est; de; era; es; fue; e; em")
_JOINS = words("and; with; und; mit; et; avec; y; con; e; com; a; at; the; of; its; in; x")
#: How an amount is said to be a size behind it, and of what, in the same sentence.
_BEHIND = {
    "width": words("wide; width; broad; breit; breite; de largeur; de ancho; larghi; largos; de largo"),
    "thickness": words("thick; thickness; dick; dicke; d epaisseur; de espesor; spessi; de espessura"),
    "gauge length": words("apart"),
}
_SPECIMENS = words("""strip; strips; specimen; specimens; sample; samples; streifen; probe; proben; eprouvette;
    eprouvettes; bande; bandes; probeta; probetas; tira; tiras; provini; provino; strisce; benchmarks; marks""")
_MARKS = words("benchmarks; bench marks; marks; gauge marks")
#: Of a machine, no size of a specimen.
_MACHINE = words("jaw; jaws; grip; grips; clamp; clamps; klemme; klemmen; backen; ball; sphere; kugel; mors; mordazas")


@dataclass(frozen=True)
class Entry:
    """A line of metadata: its value and where it stands; ``sure`` where it is a line of the contract's own form.

    ``axis`` is that of a biaxial test that it is said of, 1 or 2, or nothing; ``of`` the specimen in whose row of a
    small table it stands, where the rows differ.
    """

    value: str
    line: int
    sure: bool = True
    axis: str = ""
    of: str = ""


def entry_of(key: str, value: str, line: int, own: bool = False) -> tuple[str, Entry]:
    """Return the name under which a value is stated and its entry; ``own`` where the line has the contract's form."""
    known, axis = setting_along(key)
    name = fold(key) if known in (None, "quiet") else known
    return str(name), Entry(value, line, own and name == fold(key), axis)


def settings(rows: Sequence[Row]) -> dict[str, list[Entry]]:
    """Return what lines above a table state: ``Breite;50,0;mm``, ``Width: 50 mm``, ``L0 [mm];50``.

    Words nobody knows stand under their own name, so that they can be told. A title that names a test, as
    ``Zugversuch nach ISO 13934-1`` in a line by itself, states it.
    """
    found: dict[str, list[Entry]] = {}
    for line, row in rows:
        cells = [part for cell in row for part in _parted(cell)]
        if len(alone := [cell for cell in cells if cell]) == 1:
            cells = _of_its_own(alone[0])
        title = [cell for cell in cells if cell]
        if _is_title(title) and (kind_named(title[0]) or unread(title[0])) is not None:
            found.setdefault("test", []).append(Entry(title[0], line, sure=False))
        if _is_title(title):
            found.setdefault("title", []).append(Entry(", ".join(title), line, sure=False))
        place = 0
        while place < len(cells):
            taken = _stated(cells, place)
            if taken is None:
                place += 1
                continue
            if is_test(key := taken[0]) and setting(key) is None:  # Tensile test: warp-knitted fabric
                found.setdefault("test", []).append(Entry(key, line, sure=False))
            key, value, unit, place = taken
            text = value if unit is None or not value or unit_of(value.lstrip("+-0123456789., ")) else f"{value} {unit}"
            name, entry = entry_of(key, text, line)
            if name == "direction" and kind_named(value) is not None:  # Direction: compression
                name = "test"
            if name and value and (name not in SIZES or any(map(str.isdigit, value))):
                found.setdefault("room temperature" if plain(key) in words(_ROOM) else name, []).append(entry)
    return {**in_sentences([(line, _SPLIT.sub(",", ", ".join(filter(None, row)))) for line, row in rows]), **found}


def in_sentences(lines: Sequence[tuple[int, str]]) -> dict[str, list[Entry]]:
    """Return the sizes of a specimen that lines of words tell.

    A size is named before its amount, and begins the clause or is joined to another; or behind the amount, of strips or
    specimens that the sentence is about.

    >>> def told(line):
    ...     return {key: one.value for key, [one] in in_sentences([(1, line)]).items()}
    >>> told("Gauge length was 100 mm and width 50mm, preload 0.1 N")
    {'gauge length': '100 mm', 'width': '50 mm'}
    >>> told("Streifen 50 mm breit, 0,6 mm dick"), told("Jaws 60 mm wide"), told("Grip width 60 mm")
    ({'width': '50 mm', 'thickness': '0,6 mm'}, {}, {})
    """
    found: dict[str, list[Entry]] = {}
    for line, text in lines:
        for match in _LENGTH.finditer(text):
            size = _size(text[: match.start()], text[match.end() :])
            if size is not None and is_of("in" if match[2] == '"' else match[2], "length"):
                found.setdefault(size, []).append(Entry(f"{match[1]} {match[2]}", line, sure=False))
    return found


def _size(before: str, after: str) -> str | None:
    """Return which size of a specimen an amount is, by what stands ``before`` and ``after`` it."""
    named = plain(_CLAUSE.split(before)[-1]).split()
    while named and named[-1] in _LINKS:
        named.pop()
    for place in range(max(len(named) - 5, 0), len(named)):
        known = setting(" ".join(named[place:]))
        joined = not place or named[place - 1] in _JOINS or named[place - 1][:1].isdigit()
        if joined and known in ("width", "thickness", "gauge length", "grip distance"):
            return known
    about = {*plain(_SENTENCE.split(before)[-1]).split()}
    if not about & _SPECIMENS or about & _MACHINE:
        return None
    behind = f"{plain(_CLAUSE.split(after)[0])} "
    size = next((key for key, told in _BEHIND.items() if any(behind.startswith(f"{one} ") for one in told)), None)
    return None if size == "gauge length" and not about & _MARKS else size


def tabled(rows: Sequence[Row]) -> dict[str, list[Entry]]:
    """Return sizes that stand in a small table above: titles, perhaps units, then a row for each specimen.

    Of specimens whose sizes differ that of each is told with its name.

    >>> tabled([(1, ["Name", "Width"]), (2, ["", "mm"]), (3, ["A", "50"]), (4, ["Mean", "50.0"])])["width"][0].value
    '50 mm'
    """
    found: dict[str, list[Entry]] = {}
    for k, (_, titles) in enumerate(rows):
        heads = [heading(title, place) for place, title in enumerate(titles)]
        sized = [(one, key) for one in heads if (key := setting(one.label)) in SIZES and key != "area"]
        widest = max((one.index for one, _ in sized), default=-1)
        below = [(line, cells) for line, cells in rows[k + 1 :] if any(cells)]
        if not sized or len(titles) < 2 or not below or len(below[0][1]) <= widest:
            continue
        units = [unit_of(below[0][1][one.index].strip("[](){} ")) for one, _ in sized]
        values = []
        for line, cells in below[1:] if all(units) else below:
            own = [cells[one.index] for one, _ in sized if len(cells) > widest]
            if not own or not all(is_number(cell) or unit_behind(cell) for cell in own):
                break
            if not is_closing(next(filter(None, cells), "")):
                values.append((line, cells))
        for (one, key), unit in zip(sized, units, strict=True):
            told = [
                Entry(cell if unit_behind(cell) else f"{cell} {unit or one.unit or ''}".strip(), line, False, of=of)
                for line, cells in values
                for of, cell in [(cells[0], cells[one.index])]
            ]
            alike = len({entry.value for entry in told}) == 1
            found.setdefault(str(key), []).extend([replace(told[0], of="")] if alike else told)
    return found


def sizes(rows: Sequence[Row]) -> dict[str, list[Entry]]:
    """Return the sizes of specimens that rows without readings state, in lines or in a small table.

    >>> found = sizes([(1, ["Operator", "mk"]), (2, ["Specimen width", "50", "mm"])])
    >>> {name: told[0].value for name, told in found.items()}
    {'width': '50 mm'}
    """
    return {key: told for key, told in {**tabled(rows), **settings(rows)}.items() if key in SIZES}


def _is_title(cells: Sequence[str]) -> bool:
    """Whether the filled cells of a row are words alone: one, or ``Biaxial test, knit`` parted at its commas."""
    if len(cells) == 1:
        return _stated(cells, 0) is None
    named = bool(cells) and _OF_A_TEST.search(plain(cells[0])) is not None
    return named and not any(is_number(cell.split()[0]) for cell in cells)


def _parted(cell: str) -> list[str]:
    """Return the settings of a cell that holds several, as ``b0 = 25 mm, a0 = 2 mm``; else the cell."""
    parts = [part.strip() for part in _BETWEEN.split(cell)]
    return parts if len(parts) > 1 and all(_SETTING.fullmatch(part) for part in parts if part) else [cell]


def _of_its_own(line: str) -> list[str]:
    """Return the known setting of a line that the separator of the table does not part, its unit behind the value: by a
    separator of its own, or by the white space before an amount; else the line.

    >>> _of_its_own('"Probenbreite","50 mm"'), _of_its_own("Width;50;mm"), _of_its_own("Gauge length 100 mm")
    (['Probenbreite', '50 mm'], ['Width', '50', 'mm'], ['Gauge length', '100 mm'])
    >>> _of_its_own("Breite 50,5 mm"), _of_its_own("Width of 50 strips, mean"), _of_its_own("b0 50,5 mm")
    (['Breite', '50,5 mm'], ['Width of 50 strips, mean'], ['b0 50,5 mm'])
    """
    match = _KEY_AND_AMOUNT.fullmatch(line)
    if match is not None and setting(match[1]) not in _UNTOLD and unit_behind(match[2]) is not None:
        return [match[1], match[2]]
    for mark in ";|\t,":
        parts = [part.strip(' "') for part in line.split(mark)]
        if not 1 < len(parts) < 4 or not parts[0] or is_number(parts[0].split()[-1]):
            continue  # a decimal comma parts no name from its amount
        if setting(parts[0]) not in _UNTOLD and _AMOUNT.fullmatch(" ".join(parts[1:])):
            return parts
    return [line]


def _stated(cells: Sequence[str], place: int) -> tuple[str, str, str | None, int] | None:
    """Return key, value, unit and the next place, where the cell at ``place`` begins a setting."""
    group = _GROUPED.fullmatch(cells[place])
    if group and place + 1 < len(cells) and (is_number(cells[place + 1]) or setting(group[1]) is not None):
        return _stated([*cells[:place], group[1], *cells[place + 1 :]], place)
    match = _SETTING.fullmatch(cells[place])
    if match and match[2] and not is_clock(cells[place]):
        key, value, after = match[1], match[2], place + 1
    elif cells[place] and place + 1 < len(cells) and not is_number(cells[place]):
        key, value, after = cells[place].rstrip(":= "), cells[place + 1], place + 2
        titles = setting(value) in SIZES and setting(key) != "direction"  # Direction: width
        if not value or titles or (place > 0 and setting(key) is None):
            return None
        beyond = cells[after + (after < len(cells) and unit_of(cells[after].strip("[](){} ")) is not None) :]
        if any(beyond) and setting(next(filter(None, beyond)).rstrip(":= ")) is None:
            return None  # a table's row, no setting
    else:
        return None
    read = heading(key, 0)
    unit = read.unit and unit_of(read.unit)  # Thickness [h0]
    if unit is None and after < len(cells) and (one := unit_of(cells[after].strip("[](){} "))) is not None:
        unit, after = one, after + 1
    return (read.label if setting(key) in (None, setting(read.label)) else key), value, unit, after
