"""Which column of a test is what, and which specimen's: from headings to the names the reader works with."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from hyperfab.arrays import Array
from hyperfab.io import heading_words
from hyperfab.io.cells import is_number, plain_values
from hyperfab.io.csv_numbers import numbers, settle_decimal
from hyperfab.io.csv_sheet import CsvSheet
from hyperfab.io.dictionary import Meaning, axis_of, plain, word_for, words
from hyperfab.io.headings import KIND, Heading, is_gauged, is_of, meaning, suffixed
from hyperfab.io.named_tests import kind_named

#: What gives a stretch and what a stress, the surest first.
STRETCHES = (
    "stretch",
    "strain",
    "true strain",
    "green strain",
    "volume ratio",
    "shear strain",
    "extension",
    "length",
    "position",
)
STRESSES = ("stress", "true stress", "membrane stress", "shear stress", "force")
#: No stress of a test is larger, in MPa or N/mm: the strongest fibre breaks at 7000 MPa, the strongest geotextile at
#: 3000 N/mm.
STRONGEST = 2e4
#: What a unit of each kind suggests that a column is.
BY_KIND = {"stress": "stress", "force": "force", "membrane-stress": "membrane stress", "length": "extension"}
SPECIMEN = re.compile(
    r"(?:probe|specimen|sample|probeta|muestra|eprouvette|echantillon|provino|campione|corpo de "
    r"prova|amostra|prufling|probekorper|test piece|versuch|spec|cp)"
    r"(?: n| no| nr)? ?(\d{1,3}|[a-z])\b[ :]*(.*)"
)
#: What a title may state of its column beside what that holds: setting, form, unit.
_STATES = (
    ("direction", re.compile(r"(\d{1,3}) ?(?:deg|degrees|°)"), "deg"),
    ("temperature", re.compile(r"([-−]?\d+(?:\.\d+)?) ?(?:°|deg)? ?C"), "degC"),
    ("rate", re.compile(r"(\d*\.?\d+(?:[eE]-?\d+)?) ?(?:1?/s|s-1|s\^-1)"), "1/s"),
    ("rate", re.compile(r"(\d*\.?\d+) ?mm/min"), "mm/min"),
    ("rate", re.compile(r"(\d*\.?\d+) ?mm/s"), "mm/s"),
)
#: An angle beside words of directions.
_ANGLED = re.compile(r"\d{1,3} ?(?:deg|°)?")
#: How near, as a share of the way, each specimen of a table begins to where the first did, and the fewest rows of one.
_AT_REST, FEWEST_ROWS = 0.05, 3
#: A word and a specimen's number behind it.
_NUMBERED = re.compile(r"(.*[^\W\d])[ _-]?\d{1,2}")
#: Names of letters of which mechanics numbers the axes: sigma 1, sigma 2, sigma 3.
_SYMBOLS = ("sigma", "lambda", "epsilon", "gamma", "tau", "lam", "sig", "eps")
#: A specimen's number or letter behind what a column holds.
_LABELLED = re.compile(r"([a-z ]*[a-z]{3}) ?(\d{1,2}|(?<= )[a-z])")


@dataclass(frozen=True)
class Column:
    """A column under the name it is read by: ``heading`` with its unit; ``compressive`` where pushing is positive."""

    name: str
    heading: Heading
    compressive: bool = False
    minus: bool = False


@dataclass(frozen=True)
class Roles:
    """The columns of one specimen by name (``force``, ``strain 2``), and the titles of those nothing is known of."""

    columns: dict[str, Column]
    aside: tuple[str, ...] = ()

    def first(self, names: Sequence[str], place: str = "") -> Column | None:
        """Return the column of the first of ``names`` that is there, along the axis ``place`` (nothing or " 2")."""
        return next((self.columns[name + place] for name in names if name + place in self.columns), None)

    def decimal_mark(self, sheet: CsvSheet, given: str | None) -> str:
        """Return the decimal mark of these columns of ``sheet``, but for those that begin with words."""
        heads = [one.heading for one in self.columns.values()]
        return settle_decimal(sheet, [one for one in heads if any(map(is_number, sheet.columns[one.index][:3]))], given)


def fits(heads: Sequence[Heading]) -> bool:
    """Whether headings give a stretch and a stress."""
    ones = [read(head) or ((found := label_of(head)) and read(found[0])) for head in heads]
    names = {one.name for one in ones if one}
    if any(names & set(STRETCHES)) and any(names & set(STRESSES)):
        return True
    return bool(names & set(STRETCHES)) and any(by_unit(head) for head in heads)


def read(head: Heading) -> Meaning | None:
    """Return what a column holds: by the command line, by its words, or by its words before a unit after ``_``."""
    found = meaning(head)
    if found is None or (head.unit is None and found.name in KIND):
        found = meaning(suffixed(head)) or found
    return found


def by_unit(head: Heading) -> str | None:
    """Return what a column that is called after a specimen holds, by its unit."""
    match = SPECIMEN.fullmatch(plain(head.label))
    return None if match is None or match[2] else _of_unit(head)


def _of_unit(head: Heading) -> str | None:
    return next((name for kind, name in BY_KIND.items() if head.unit is not None and is_of(head.unit, kind)), None)


@dataclass(frozen=True)
class Label:
    """What a title says beside what its column holds: ``key``, the setting it is and its value."""

    key: str
    setting: str
    value: str


def label_of(head: Heading) -> tuple[Heading, Label] | None:
    """Return a heading without the label in its title and that: ``Stress_2``, ``Course stress``, ``Stress 20C``.

    A title may be the label alone, where the unit is one of a stress or a force: ``Warp [MPa]``.
    """
    head = suffixed(head)  # stress_warp_MPa
    match = _LABELLED.fullmatch(plain(head.label))
    if match and read(made := replace(head, label=match[1].strip())):
        return None if made.label in _SYMBOLS else (made, Label(match[2], "specimen", match[2]))
    words = [word.strip("()[]") for word in re.split(r"[\s_]+", head.title)]
    words = [word for word in words if word != head.unit]
    pairs = ((words[-2:], words[:-2]), (words[:2], words[2:]))
    for own, rest in ((words[-1:], words[:-1]), *pairs, (words[:1], words[1:])):
        made = replace(head, label=" ".join(rest))
        label = state_of(" ".join(own)) or _test_of(head, " ".join(own))
        if rest and label and read(made) is not None:
            return made, label
    label, name = state_of(" ".join(words)), _of_unit(head)
    return (replace(head, label=name), label) if label and name in STRESSES else None


def state_of(text: str) -> Label | None:
    """Return what a word in a title states of its column: a direction, an angle, a temperature or a rate."""
    numbered = _NUMBERED.fullmatch(text)  # Warp 1, of several strips
    for word in (text, *(numbered.groups() if numbered else ())):
        if word_for(word, "DIRECTIONS"):
            return Label(text.casefold(), "direction", word)
    for name, form, unit in _STATES:
        if match := form.fullmatch(text):
            return Label(text, name, f"{match[1]} {unit}")
    return None


def _test_of(head: Heading, text: str) -> Label | None:
    """Return the test that a word in a title names where the title as a whole says nothing: stress_biaxial."""
    kind = kind_named(text) if read(head) is None else None
    return Label(kind, "test", kind) if kind else None


def roles(sheet: CsvSheet) -> Roles:
    """Return which column is what; InputError with the option that settles it where two could be one thing."""
    found: dict[str, list[tuple[int, Column]]] = {}
    aside: list[str] = []
    for head in sheet.headings:
        choice = sheet.layout.choice(head, sheet.headings) if sheet.layout.columns else None
        if choice is not None:
            if choice.name != "aside":
                found.setdefault(choice.name, []).append((-1, Column(choice.name, head, minus=choice.minus)))
            continue
        what = read(head)
        along = label_of(head) if what is None else None
        if along is not None and along[1].setting in ("direction", "test"):
            what, head = read(along[0]), along[0]
            if what is not None and along[1].setting == "direction":  # an axis of a biaxial test, by its name
                axis = axis_of(along[1].value)
                what = replace(what, axis=axis) if axis else None
        if what is None or what.name == "aside":
            if head.title.strip() and any(sheet.columns[head.index]):
                aside.append(head.title)
            continue
        made = head if meaning(head) is what or head.unit is not None else suffixed(head)
        key = what.name + {"2": " 2", "x": " x", "y": " y"}.get(what.axis, "")
        found.setdefault(key, []).append((what.rank, Column(key, made, what.compressive)))
    _by_the_letter_t(sheet, found, aside)
    _of_directions(sheet, found, aside)
    _never_read(sheet, found, aside)
    _still_out(sheet, found, aside)
    _of_machine_or_gauge(sheet, found)
    _pressure(sheet, found, aside)
    _of_four_arms(sheet, found)
    columns = {name: _one_of(sheet, name, ones) for name, ones in found.items() if ones}
    for ones in found.values():
        best = min((rank for rank, _ in ones), default=0)
        aside += [one.heading.title for rank, one in ones if rank > best]
    return Roles(_axes(sheet, columns), tuple(aside))


def begun_anew(cells: Sequence[str], way: Array) -> list[int]:
    """Return the rows, but the first, at which words of a column begin that may name specimens: each fills one run of
    rows, at whose start the ``way`` (n,) is near where that of the first began. Empty where they do not.

    >>> begun_anew([*"aaabbb"], np.array([0.0, 1.0, 2.0, 0.0, 1.0, 2.0])), begun_anew([*"aaabbb"], np.arange(6.0))
    ([3], [])
    """
    starts = [row for row in range(1, len(cells)) if cells[row] != cells[row - 1]]
    if not starts or len(set(cells)) != len(starts) + 1 or any(not c or is_number(c) for c in cells):
        return []
    near = np.abs(way[starts] - way[0]) <= _AT_REST * np.ptp(way)
    return starts if near.all() and min(np.diff([0, *starts, len(cells)])) >= FEWEST_ROWS else []


def with_names(sheet: CsvSheet, columns: Roles, decimal: str, notes: list[str]) -> Roles:
    """Return the roles with a column of words that nobody knows, if it names the specimens that stand in one table.

    Each word fills one run of rows, at whose start the clock, where there is one, begins anew, and the stretch is where
    that of the first began. Of several (a file and its material) the one that tells most of them apart.
    """
    stretch, time = columns.first(STRETCHES), columns.columns.get("time")
    if stretch is None or columns.first(("specimen", "cycle", "branch", "test")) is not None:
        return columns
    way = numbers(sheet, stretch.heading, decimal)
    clock = None if time is None else plain_values(sheet.columns[time.heading.index])
    best: tuple[int, Heading] | None = None
    for head in sheet.headings:
        cells = sheet.columns[head.index]
        free = head.title in columns.aside and sheet.layout.choice(head, sheet.headings) is None
        starts = begun_anew(cells, way) if free else []
        anew = clock is None or (len(clock) == len(cells) and all(clock[row] < clock[row - 1] for row in starts))
        if starts and anew:
            best = max(best or (0, head), (len(starts), head), key=lambda one: one[0])
    if best is None:
        return columns
    notes.append(f"{best[1].title} names the specimens")
    aside = tuple(title for title in columns.aside if title != best[1].title)
    return Roles({**columns.columns, "specimen": Column("specimen", best[1])}, aside)


def _by_the_letter_t(sheet: CsvSheet, found: dict[str, list[tuple[int, Column]]], aside: list[str]) -> None:
    """Take sigma_t beside a true strain for a true stress; epsilon_t beside an epsilon nobody knows may be across."""
    lettered = [one for one in found.get("true strain", []) if _ends_in_t(one[1], "epsilon", "eps")]
    others = [head for head in sheet.headings if plain(head.label).startswith("eps")]
    if lettered and len(others) > 1 and not found.get("strain"):
        found["true strain"] = [one for one in found["true strain"] if one not in lettered]
        aside.extend(one.heading.title for _, one in lettered)
    for rank, one in list(found.get("stress", [])):
        if rank < 0 or not _ends_in_t(one, "sigma"):
            continue
        if not found.get("true strain"):
            title, unit = one.heading.title, one.heading.unit or "MPa"
            options = (sheet.option([(title, f"{name} [{unit}]")]) for name in ("true stress", "stress"))
            raise sheet.wrong(f"{title} is a true stress, or a tensile one", remedy=f"say {' or '.join(options)}")
        found["stress"].remove((rank, one))
        found.setdefault("true stress", []).append((rank, replace(one, name="true stress")))


def _ends_in_t(column: Column, *symbols: str) -> bool:
    return plain(column.heading.label).replace(" ", "") in [f"{symbol}t" for symbol in symbols]


def _of_directions(sheet: CsvSheet, found: dict[str, list[tuple[int, Column]]], aside: list[str]) -> None:
    """Take a column for the direction, if none is, whose cells are words of several, or of one where its title speaks
    of directions, whatever it is called: ``dir``, ``Loading direction``."""
    free = [head for head in sheet.headings if head.title in aside and not sheet.layout.choice(head, sheet.headings)]
    for head in [] if "direction" in found else [*(one.heading for _, one in found.get("branch", [])), *free]:
        ways = {_ANGLED.sub("", cell) and word_for(cell, "DIRECTIONS") for cell in {*sheet.columns[head.index]}}
        told = len(ways) > 1 or "dir" in plain(head.title)
        if not told or None in ways or not ways - {""} or sheet.layout.choice(head, sheet.headings):
            continue
        found["branch"] = [one for one in found.get("branch", []) if one[1].heading is not head]
        aside[:] = [title for title in aside if title != head.title]
        found["direction"] = [(0, Column("direction", head))]
        return


def _never_read(sheet: CsvSheet, found: dict[str, list[tuple[int, Column]]], aside: list[str]) -> None:
    """Set columns aside that a machine leaves without any reading where another tells the same kind of thing."""
    for names in (STRETCHES, STRESSES):
        same = [(key, one) for key, ones in found.items() if re.sub(" [2xy]$", "", key) in names for one in ones]
        read = [one for _, one in same if any(map(is_number, sheet.columns[one[1].heading.index]))]
        for name, one in same if read else ():
            if one not in read and one[0] >= 0:
                found[name].remove(one)
                aside.append(one[1].heading.title)


def _still_out(sheet: CsvSheet, found: dict[str, list[tuple[int, Column]]], aside: list[str]) -> None:
    """Set columns of a strain aside that stand still in every row while another column of that name moves."""
    names = [name for name in found if name.split(" ")[0] in ("strain", "stretch", "extension")]
    for base in ("strain", "stretch", "extension"):
        same = [(name, one) for name in names if name in (base, f"{base} x", f"{base} y") for one in found[name]]
        moving = [one for _, one in same if len(set(sheet.columns[one[1].heading.index])) > 1]
        if not moving or len(moving) == len(same):
            continue
        for name, one in same:
            if one not in moving and one[0] >= 0 and name == base:
                found[name].remove(one)
                aside.append(one[1].heading.title)


def _of_machine_or_gauge(sheet: CsvSheet, found: Mapping[str, list[tuple[int, Column]]]) -> None:
    """Refuse to guess over which length an elongation is where an extensometer and the machine both tell one."""
    if any(name in found for name in STRETCHES[: STRETCHES.index("extension")]):
        return
    ones = [one for name in ("extension", "position") for one in found.get(name, []) if one[0] >= 0]
    gauged = [one.heading for _, one in ones if is_gauged(one.heading)]
    others = [one.heading for _, one in ones if one.heading not in gauged]
    if gauged and others and all(rank >= 0 for rank, _ in found.get("extension", [])):
        raise sheet.two([*others, *gauged], "extension")


def _pressure(sheet: CsvSheet, found: dict[str, list[tuple[int, Column]]], aside: list[str]) -> None:
    """Take a pressure beside a volume ratio for the mean stress, which pulls where it is positive."""
    if "volume ratio" not in found or any(name in found for name in STRESSES):
        return
    for head in sheet.headings:
        if head.title in aside and plain(head.label) in words(heading_words.PRESSURES):
            aside.remove(head.title)
            found.setdefault("stress", []).append((0, Column("stress", head, compressive=True)))


def _of_four_arms(sheet: CsvSheet, found: Mapping[str, list[tuple[int, Column]]]) -> None:
    """Refuse to take the second of forces that are numbered further for that of the second axis: of a cross of four
    arms two are of one axis, and how they are numbered is not told."""
    second = next((one.heading for rank, one in found.get("force 2", []) if rank >= 0), None)
    match = None if second is None else re.fullmatch(r"(.*?) ?2", plain(second.label))
    if match is None or not any(name.endswith((" 2", " y")) for name in found if name != "force 2"):
        return
    stem = match[1]
    arms = [one for one in sheet.headings if re.fullmatch(rf"{re.escape(stem)} ?[1-4]", plain(one.label))]
    if len(arms) > 2:
        told = [f"{name} [{arms[0].unit or 'N'}]" for name in ("force", "force 2")]
        first, third = (
            sheet.option([(arm.title, told[pair.index(k)] if k in pair else "aside") for k, arm in enumerate(arms)])
            for pair in ((0, 1), (0, 2))
        )
        raise sheet.wrong(
            f"{arms[0].title} to {arms[-1].title}: which are along one axis?",
            remedy=f"say {first} where neighbours in number are of two axes, {third} where they are of one",
        )


def _one_of(sheet: CsvSheet, name: str, found: list[tuple[int, Column]]) -> Column:
    """Return the best told of columns that are one thing; columns with the same cells are one."""
    best = min(rank for rank, _ in found)
    ones = [column for rank, column in found if rank == best]
    cells = {tuple(sheet.columns[one.heading.index][:50]) for one in ones}
    if len(ones) > 1 and len(cells) > 1:
        raise sheet.two([one.heading for one in ones], name)
    return ones[0]


def _axes(sheet: CsvSheet, columns: dict[str, Column]) -> dict[str, Column]:
    """Turn the axes x and y of image correlation into first and second: the axis of the one stress comes first."""
    lettered = {name: name[-1] for name in columns if name.endswith((" x", " y"))}
    if not lettered:
        return columns
    stretches = {axis for name, axis in lettered.items() if name[:-2] in STRETCHES}
    stresses = {axis for name, axis in lettered.items() if name[:-2] in STRESSES}
    if len(stresses) == 1:
        first = next(iter(stresses))
    elif len(stresses) == 2 or len(stretches) < 2:
        first = min(stresses or stretches)
    else:
        first = _pulled(sheet, columns)
    found: dict[str, Column] = {}
    for name, column in columns.items():
        axis = lettered.get(name)
        new = name if axis is None else name[:-2] if axis == first else f"{name[:-2]} 2"
        if new in found:
            raise sheet.two([found[new].heading, column.heading], new)
        found[new] = replace(column, name=new)
    return found


def _pulled(sheet: CsvSheet, columns: dict[str, Column]) -> str:
    """Refuse to guess which of two strains is the loading direction, with the likelier one filled in."""
    pair = [
        (name[-1], column) for name, column in columns.items() if name.endswith((" x", " y")) and name[:-2] in STRETCHES
    ]
    sizes = {}
    for axis, column in pair:
        sizes[axis] = max(plain_values(sheet.columns[column.heading.index]), key=abs, default=0.0)
    first = max(sizes, key=lambda axis: sizes[axis])
    entries = [
        (column.heading.title, column.name[:-2] if axis == first else f"{column.name[:-2]} 2") for axis, column in pair
    ]
    raise sheet.wrong(
        f"{pair[0][1].heading.title} or {pair[1][1].heading.title}: which is along the pull?",
        remedy=f"say {sheet.option(entries)}",
    )
