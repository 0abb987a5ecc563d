"""How one setting is written: by people as words, in documents as plain data. A kind reads, checks and writes it."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

from hyperfab.errors import UsageError
from hyperfab.io.units import KINDS, Toleranced, quantity, tolerance, toleranced, worded


class Kind:
    """A kind of setting. ``read`` takes the words of an option, ``load`` the plain data of a document's ``setup``.

    ``read`` raises UsageError with the right form, ``load`` ValueError saying what is wrong.
    """

    #: The unit that the key in a document ends in.
    unit: str = ""
    #: May the option be repeated? ``read`` and ``words`` then take and give a list.
    repeated: ClassVar[bool] = False

    def read(self, text: Any, option: str) -> Any:
        """Return the value of an option's text."""
        raise NotImplementedError

    def words(self, value: Any) -> Any:
        """Return the text that ``read`` takes for a value."""
        return str(value)

    def load(self, data: Any) -> Any:
        """Return the value of plain data."""
        raise NotImplementedError

    def dump(self, value: Any) -> Any:
        """Return a value as plain data."""
        return value

    def schema(self) -> dict[str, Any]:
        """Return the JSON Schema of the plain data."""
        raise NotImplementedError

    def checked(self, text: object, option: str, load: Callable[[], Any]) -> Any:
        """Return what ``load`` gives; its ValueError becomes a UsageError that names the option."""
        try:
            return load()
        except ValueError as error:
            raise UsageError(f"{option} {text}: {error}") from None


@dataclass(frozen=True)
class Amount(Kind):
    """A quantity of a kind of io.units, in the unit that is computed in; ``example`` shows the right form.

    ``least`` and ``most`` are allowed, ``above`` is not.

    >>> Amount("length", "60mm", above=0.0).read("6cm", "--depth")
    60.0
    >>> Amount("length", "60mm", above=0.0).read("0mm", "--depth")
    Traceback (most recent call last):
    hyperfab.errors.UsageError: --depth 0mm: must be more than 0mm, as 60mm
    """

    kind: str
    example: str
    least: float | None = None
    most: float | None = None
    above: float | None = None

    @property
    def unit(self) -> str:  # type: ignore[override]
        """The unit that is computed in; none for a bare number."""
        found = KINDS[self.kind].unit
        return "" if found == "1" else found

    def read(self, text: Any, option: str) -> float:
        value = quantity(text, self.kind, option=option)
        return self.checked(text, option, lambda: self.load(value))

    def words(self, value: float) -> str:
        return f"{value!r}{self.unit}" if not tolerance(value) else worded(value, self.unit)

    def load(self, data: Any) -> float:
        if isinstance(data, bool) or not isinstance(data, (int, float)) or not math.isfinite(data):
            raise ValueError("a number is needed" + (f", in {self.unit}" if self.unit else ""))
        if self.above is not None and not data > self.above:
            raise ValueError(f"must be more than {self.above:g}{self.unit}, as {self.example}")
        low = self.least is not None and data < self.least
        if low or (self.most is not None and data > self.most):
            raise ValueError(f"{_range(self.least, self.most, self.unit)}, as {self.example}")
        return toleranced(data, tolerance(data))

    def dump(self, value: float) -> float:
        """Return the number; ``tolerances`` has how sure it is."""
        return float(value)

    def schema(self) -> dict[str, Any]:
        bounds = {"minimum": self.least, "maximum": self.most, "exclusiveMinimum": self.above}
        return {"type": "number", **{key: value for key, value in bounds.items() if value is not None}}


@dataclass(frozen=True)
class Percent(Amount):
    """A share that is counted in percent, with the sign or without: ``Amount`` would read ``80%`` as 0.8.

    >>> kind = Percent("dimensionless", "80%", least=0.0, most=100.0)
    >>> kind.read("80%", "--min-spotted"), kind.read("80", "--min-spotted")
    (80.0, 80.0)
    """

    def read(self, text: Any, option: str) -> float:
        return self.checked(text, option, lambda: self.load(_percent(text, self.example)))


@dataclass(frozen=True)
class Whole(Kind):
    """A whole number."""

    example: str
    least: int | None = None
    most: int | None = None

    def read(self, text: Any, option: str) -> int:
        return self.checked(text, option, lambda: self.load(_whole(text, self.example)))

    def load(self, data: Any) -> int:
        if isinstance(data, bool) or not isinstance(data, int):
            raise ValueError(f"a whole number is needed, as {self.example}")
        if self.least is not None and data < self.least and self.most is None:
            raise ValueError(f"at least {self.least}, as {self.example}")
        if (self.least is not None and data < self.least) or (self.most is not None and data > self.most):
            raise ValueError(f"{_range(self.least, self.most, '')}, as {self.example}")
        return data

    def schema(self) -> dict[str, Any]:
        bounds = {"minimum": self.least, "maximum": self.most}
        return {"type": "integer", **{key: value for key, value in bounds.items() if value is not None}}


@dataclass(frozen=True)
class Choice(Kind):
    """One of a few names; ``lenient`` ones may be typed in either case."""

    names: tuple[str, ...]
    lenient: bool = False

    def read(self, text: Any, option: str) -> str:
        meant = {name.lower(): name for name in self.names}.get(text.lower(), text) if self.lenient else text
        return str(self.checked(text, option, lambda: self.load(meant)))

    def load(self, data: Any) -> str:
        if data not in self.names:
            raise ValueError(f"choose {', '.join(self.names[:-1])} or {self.names[-1]}")
        return str(data)

    def schema(self) -> dict[str, Any]:
        return {"enum": list(self.names)}


@dataclass(frozen=True)
class Text(Kind):
    """Words that the chapter makes sense of."""

    def read(self, text: Any, option: str) -> str:
        return str(text)

    def load(self, data: Any) -> str:
        if not isinstance(data, str):
            raise ValueError("a text is needed")
        return data

    def schema(self) -> dict[str, Any]:
        return {"type": "string"}


@dataclass(frozen=True)
class File(Text):
    """The name of an input file, ``-`` is standard input; ``besides`` are names that stand for something else."""

    besides: tuple[str, ...] = ()

    @staticmethod
    def parted(name: str) -> tuple[str, str]:
        """Return the file of a name, and what of it is meant: ``heat.json:plate``, ``tests.xlsx:warp``.

        >>> File.parted("a/heat.json:plate"), File.parted("fabric.json")
        (('a/heat.json', ':plate'), ('fabric.json', ''))
        """
        found = re.fullmatch(r"(.+\.(?:json|xlsx))(:[^/\\:]+)", name)
        return (name, "") if found is None else (found[1], found[2])

    def names(self, text: str) -> bool:
        """Return whether a value is the name of a file."""
        return text not in self.besides


@dataclass(frozen=True)
class AmountOrFile(File):
    """A quantity, ``4mm``, or the file that says it place by place.

    >>> kind = AmountOrFile(item=Amount("length", "4mm", above=0.0))
    >>> kind.names("wanted.csv"), kind.names("0.4 cm"), kind.amount("0.4 cm", "--wanted")
    (True, False, 4.0)
    """

    item: Amount = Amount("length", "4mm")

    def read(self, text: Any, option: str) -> str:
        """Return the text; a quantity must be one of the right kind."""
        if not self.names(str(text)):
            self.amount(text, option)
        return str(text)

    def names(self, text: str) -> bool:
        """Return whether it is the name of a file: a quantity begins with a number and has no ending of a file."""
        return re.match(r"\s*[-+]?\.?\d", text) is None or text.lower().endswith((".csv", ".xlsx"))

    def amount(self, text: str, option: str) -> float | None:
        """Return the quantity; None where it is a file's name."""
        return None if self.names(text) else self.item.read(text, option)


@dataclass(frozen=True)
class Flag(Kind):
    """Yes or no."""

    def read(self, text: Any, option: str) -> bool:
        return bool(text)

    def load(self, data: Any) -> bool:
        if not isinstance(data, bool):
            raise ValueError("true or false is needed")
        return data

    def schema(self) -> dict[str, Any]:
        return {"type": "boolean"}


@dataclass(frozen=True)
class _Several(Kind):
    """Values of one kind, in a list."""

    item: Kind

    @property
    def unit(self) -> str:  # type: ignore[override]
        """The unit of each."""
        return self.item.unit

    def load(self, data: Any) -> tuple[Any, ...]:
        if not isinstance(data, (list, tuple)):
            raise ValueError("a list is needed")
        return tuple(self.item.load(one) for one in data)

    def dump(self, value: Sequence[Any]) -> list[Any]:
        return [self.item.dump(one) for one in value]

    def schema(self) -> dict[str, Any]:
        return {"type": "array", "items": self.item.schema()}


@dataclass(frozen=True)
class Series(_Several):
    """Several of a kind in one option, as ``20mm,40mm``: ``count`` says how many, (2,) or (1, 2) or any.

    One alone stands for both of a pair.

    >>> Series(Amount("length", "60mm"), "x", (1, 2), "220mmx180mm").read("20cm", "--size")
    (200.0, 200.0)
    """

    mark: str
    count: tuple[int, ...]
    example: str

    def read(self, text: Any, option: str) -> tuple[Any, ...]:
        parts = [part.strip() for part in str(text).replace("×", "x").split(self.mark)]
        parts = [part for part in parts if part] if not self.count else parts
        if (self.count and len(parts) not in self.count) or not all(parts):
            raise UsageError(f"{option} {text}: write {self.example}")
        try:
            found = [self.item.read(part, f"{option} {text}:" if len(parts) > 1 else option) for part in parts]
        except UsageError as error:
            # The right form of what was typed stays; any number of the kind says less than the option's own example.
            told, any_number, _ = str(error).partition("; write it like ")
            raise UsageError(f"{told}; write {self.example}" if any_number else told) from None
        return tuple(found * 2 if self.count == (1, 2) and len(found) == 1 else found)

    def words(self, value: Sequence[Any]) -> str:
        return self.mark.join(self.item.words(one) for one in value)

    def load(self, data: Any) -> tuple[Any, ...]:
        if not isinstance(data, (list, tuple)) or (self.count and len(data) != max(self.count)):
            raise ValueError("a list is needed" + (f" of {max(self.count)}" if self.count else ""))
        return super().load(data)


@dataclass(frozen=True)
class Many(_Several):
    """An option that is repeated, each with one value."""

    repeated: ClassVar[bool] = True

    def read(self, text: Any, option: str) -> tuple[Any, ...]:
        return tuple(self.item.read(one, option) for one in text)

    def words(self, value: Sequence[Any]) -> list[str]:
        return [self.item.words(one) for one in value]


@dataclass(frozen=True)
class OrName(Kind):
    """An amount, or one of a few names in its place, as ``0.3`` or ``stick``."""

    item: Amount
    names: tuple[str, ...]

    @property
    def unit(self) -> str:  # type: ignore[override]
        """The unit of the amount."""
        return self.item.unit

    def read(self, text: Any, option: str) -> float | str:
        if text in self.names:
            return str(text)
        try:
            return self.item.read(text, option)
        except UsageError as error:
            raise UsageError(f"{error}; or {', '.join(self.names)}") from None

    def words(self, value: float | str) -> str:
        return value if isinstance(value, str) else self.item.words(value)

    def load(self, data: Any) -> float | str:
        return str(data) if data in self.names else self.item.load(data)

    def dump(self, value: float | str) -> float | str:
        return value if isinstance(value, str) else self.item.dump(value)

    def schema(self) -> dict[str, Any]:
        return {"anyOf": [self.item.schema(), {"enum": list(self.names)}]}


def plain(data: Any) -> Any:
    """Return tuples as lists and mappings as dictionaries, as a document holds them."""
    if isinstance(data, Mapping):
        return {key: plain(value) for key, value in data.items()}
    if isinstance(data, Toleranced):
        return float(data)
    return [plain(value) for value in data] if isinstance(data, (list, tuple)) else data


def _whole(text: Any, example: str) -> int:
    try:
        return int(str(text).strip(), 10)
    except ValueError:
        raise ValueError(f"a whole number is needed, as {example}") from None


def _percent(text: Any, example: str) -> float:
    try:
        return float(str(text).strip().removesuffix("%"))
    except ValueError:
        raise ValueError(f"a number of percent is needed, as {example}") from None


def _range(least: float | None, most: float | None, unit: str) -> str:
    if most is None:
        return f"{least:g}{unit} or more"
    if least is None:
        return f"{most:g}{unit} or less"
    return f"between {least:g}{unit} and {most:g}{unit}"
