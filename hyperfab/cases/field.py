"""The fields of a case. Each says its key, unit, default, bounds, help and option once."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any

from hyperfab.cases.kinds import Amount, Choice, File, Flag, Kind, Many, Series, Text, Whole

#: The key of a field's own entry in its metadata.
_SETTING = "setting"


@dataclass(frozen=True)
class Setting:
    """One setting of a command: ``name`` in the case, ``kind``, the ``help`` of its option, the form it shows.

    ``argument``: stands without an option's name. ``over``: fields of an earlier set-up that make way when this one is
    given. ``shown`` is the default as people write it, None where there is none; ``called`` is the key where it is not
    the name with the unit. Not ``kept`` in a document is what the result does not hang on.
    """

    kind: Kind
    metavar: str
    help: str
    shown: Any = None
    required: bool = False
    argument: bool = False
    over: tuple[str, ...] = ()
    called: str | None = None
    kept: bool = True
    name: str = ""
    option: str = ""

    @property
    def key(self) -> str:
        """The key in a document's ``setup``: the name, and its unit.

        >>> Setting(Amount("compliance", "0.5mm^2/N"), "", "", name="rim_slip").key
        'rim_slip_mm2_N'
        """
        if self.called is not None:
            return self.called
        unit = self.kind.unit.replace("^", "").replace("/", "_")
        return f"{self.name}_{unit}" if unit else self.name

    @property
    def default(self) -> Any:
        """The value where nothing is given."""
        if self.shown is None and not self.kind.repeated:
            return None
        return self.kind.read(self.shown or [] if self.kind.repeated else self.shown, self.option)

    def files(self, value: Any) -> list[str]:
        """Return the input files that a value names."""
        kind = self.kind.item if isinstance(self.kind, Many) else self.kind
        if not isinstance(kind, File) or value is None:
            return []
        names = [value] if isinstance(value, str) else value
        return [kind.parted(name)[0] for name in names if kind.names(name)]

    @property
    def spoken(self) -> str:
        """How messages call it."""
        return self.metavar if self.argument else self.option


def settings_of(cls: type[Any]) -> tuple[Setting, ...]:
    """Return the settings of a case, in order."""
    found = []
    for one in dataclasses.fields(cls):
        setting: Setting = one.metadata[_SETTING]
        option = setting.option or f"--{one.name.replace('_', '-')}"
        found.append(dataclasses.replace(setting, name=one.name, option=option))
    return tuple(found)


def setting(kind: Kind, metavar: str, help: str, default: Any = None, **more: Any) -> Any:
    """Return a field of a case; ``default`` as people write it, None where nothing stands for it.

    ``more`` is what else a ``Setting`` says.
    """
    own = Setting(kind, metavar, help, default, **more)
    if own.required:
        return dataclasses.field(metadata={_SETTING: own})
    if kind.repeated:
        return dataclasses.field(default_factory=lambda: own.default, metadata={_SETTING: own})
    return dataclasses.field(default=own.default, metadata={_SETTING: own})


def amount(
    kind: str,
    metavar: str,
    help: str,
    default: str | None = None,
    *,
    example: str | None = None,
    least: float | None = None,
    most: float | None = None,
    above: float | None = None,
    **more: Any,
) -> Any:
    """Return a field for a quantity with its unit."""
    own = Amount(kind, example or default or "", least, most, above)
    return setting(own, metavar, help, default, **more)


def whole(
    metavar: str,
    help: str,
    default: str | None = None,
    *,
    example: str | None = None,
    least: int | None = None,
    most: int | None = None,
    **more: Any,
) -> Any:
    """Return a field for a whole number."""
    return setting(Whole(example or default or "", least, most), metavar, help, default, **more)


def choice(
    metavar: str,
    help: str,
    names: tuple[str, ...],
    default: str | None = None,
    *,
    lenient: bool = False,
    **more: Any,
) -> Any:
    """Return a field for one of a few names."""
    return setting(Choice(names, lenient), metavar, help, default, **more)


def text(metavar: str, help: str, default: str | None = None, **more: Any) -> Any:
    """Return a field for words."""
    return setting(Text(), metavar, help, default, **more)


def texts(metavar: str, help: str, **more: Any) -> Any:
    """Return a field for words, one an option."""
    return setting(Many(Text()), metavar, help, **more)


def flag(help: str, **more: Any) -> Any:
    """Return a field that is off until it is given."""
    return setting(Flag(), "", help, False, **more)


def file(metavar: str, help: str, **more: Any) -> Any:
    """Return a field for an input file."""
    return setting(File(), metavar, help, **more)


def files(metavar: str, help: str, **more: Any) -> Any:
    """Return a field for input files, one an option."""
    return setting(Many(File()), metavar, help, **more)


def series(item: Kind, mark: str, count: tuple[int, ...], metavar: str, help: str, default: str | None = None,
           *, example: str | None = None, **more: Any) -> Any:  # fmt: skip
    """Return a field for several of a kind in one option."""
    return setting(Series(item, mark, count, example or default or ""), metavar, help, default, **more)


def thickness() -> Any:
    """Return the field for the thickness of a fabric."""
    help = "Thickness; the material's own where it has one, else 1mm."
    return amount("length", "LENGTH", help, example="0.8mm", above=0.0, most=1000.0)


def uncertainty() -> Any:
    """Return the field for how uncertainty of the inputs is carried into the results."""
    return choice(
        "HOW",
        "What inputs state of their uncertainty is carried on: linear or sampled, as the result asks for, or none.",
        ("none", "linear", "sampled"),
    )


def stl_unit() -> Any:
    """Return the field for the unit of STL files, which state none."""
    return text("UNIT", "Unit of the numbers in STL files: mm, cm, m or inch.", "mm")
