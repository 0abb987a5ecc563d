"""A case: what is asked of a command, as a value. It is read from words, kept in documents and read from them."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Self

from hyperfab.cases.field import Setting, settings_of
from hyperfab.cases.kinds import plain
from hyperfab.errors import InputError, UsageError
from hyperfab.io.units import Toleranced, toleranced

#: Keys of ``setup`` beside the fields: which were not asked but follow from inputs, and what the input files hold.
DERIVED, HASHES = "derived", "sha256"
#: And how sure the quantities are, by the places of their numbers.
TOLERANCES = "tolerances"


@dataclass(frozen=True)
class Case:
    """The set-up of one run. Subclasses are frozen dataclasses whose docstring is the command's help.

    A case is always sound: what a single field forbids its kind refuses, what fields say together ``check`` does.
    """

    #: The command, and the kind of document it writes (None: no document).
    COMMAND: ClassVar[str]
    KIND: ClassVar[str | None] = None
    #: The form and help of ``--output``; None where there is no such option.
    OUTPUT: ClassVar[tuple[str, str] | None] = ("NAME.json", "Where the document goes; - is standard output.")
    _SETTINGS: ClassVar[Mapping[str, Setting]]

    def __post_init__(self) -> None:
        self.check()

    def check(self) -> None:
        """Raise UsageError where fields contradict each other."""
        if self.inputs.count("-") > 1:
            raise UsageError("only one of the inputs can come from standard input")

    @property
    def values(self) -> dict[str, Any]:
        """The values by field."""
        return {name: getattr(self, name) for name in self.settings()}

    @property
    def inputs(self) -> list[str]:
        """The input files that the case names."""
        return [name for one in self.settings().values() for name in one.files(getattr(self, one.name))]

    @classmethod
    def settings(cls) -> Mapping[str, Setting]:
        """Return the settings by the field's name."""
        if "_SETTINGS" not in vars(cls):
            cls._SETTINGS = {one.name: one for one in settings_of(cls)}
        return cls._SETTINGS

    @classmethod
    def of(cls, given: Mapping[str, Any], like: Mapping[str, Any] = {}) -> Self:
        """Return the case of options ``given`` by field name as people write them; ``like`` are values of others.

        An empty text takes a field of ``like`` back to its default. Raises UsageError where an option cannot be meant,
        is missing, or is empty beside nothing: a variable of a shell that is not set is no wish for the default.
        """
        settings = cls.settings()
        values = dict(like)
        for name in given:
            for other in settings[name].over:
                values.pop(other, None)
        for name, text in given.items():
            one = settings[name]
            alone = text in ("", [""], ("",))
            if alone and (like or one.required):
                values.pop(name, None)
            elif alone or (isinstance(text, (list, tuple)) and "" in text):
                raise UsageError(f'{one.spoken} "": is empty; give a value ({one.metavar}), or leave it out')
            else:
                values[name] = one.kind.read(text, one.spoken)
        for one in settings.values():
            if one.required and not values.get(one.name):
                raise UsageError(f"{one.spoken}{'' if one.argument else ' ' + one.metavar} is missing: {one.help}")
        return cls(**values)

    def setup(self, hashes: Mapping[str, str], known: Mapping[str, Any] | None = None) -> dict[str, Any]:
        """Return the case as a document keeps it: every field that has a value, by its key.

        ``hashes`` are the SHA-256 of what was read, by name: files stand with their base name, and what they hold
        beside. ``known`` are values by key that were not asked for but follow from inputs.
        """
        found: dict[str, Any] = {}
        derived = []
        held: dict[str, Any] = {}
        unsure: dict[str, float] = {}
        for one in self.settings().values():
            value = getattr(self, one.name)
            if not one.kept:
                continue
            if value is None:
                if known is not None and known.get(one.key) is not None:
                    found[one.key] = known[one.key]
                    derived.append(one.key)
                continue
            found[one.key] = plain(one.kind.dump(value))
            unsure |= tolerances(value, one.key)
            names = one.files(value)
            if names and all(name in hashes for name in names):
                found[one.key] = _bare(value)
                digests = [hashes[name] for name in names]
                held[one.key] = digests[0] if isinstance(value, str) else digests
        more = ({DERIVED: derived} if derived else {}) | ({TOLERANCES: unsure} if unsure else {})
        return found | more | {HASHES: held}

    @classmethod
    def load(cls, setup: Mapping[str, Any], name: str) -> dict[str, Any]:
        """Return the values that the document ``name`` keeps, by field; InputError names a key that is not sound."""
        values = {}
        for one in cls.settings().values():
            if one.key not in setup or one.key in setup.get(DERIVED, ()):
                continue
            try:
                value = one.kind.load(setup[one.key])
                values[one.name] = with_tolerances(value, one.key, setup.get(TOLERANCES, {}))
            except ValueError as error:
                raise InputError(str(error), file=name, key=f"setup.{one.key}") from None
        return values

    @classmethod
    def schema(cls) -> dict[str, Any]:
        """Return the JSON Schema of ``setup``."""
        properties = {
            one.key: {**one.kind.schema(), "description": one.help} for one in cls.settings().values() if one.kept
        }
        return {
            "type": "object",
            "description": "the set-up that was run, defaults included: --like takes it from here",
            "properties": {
                **properties,
                DERIVED: {"type": "array", "items": {"enum": list(properties)},
                          "description": "keys that were not asked but follow from inputs"},
                TOLERANCES: {"type": "object", "additionalProperties": {"type": "number", "minimum": 0},
                             "description": "standard deviations of quantities, by key, in the unit of the key"},
                HASHES: {"type": "object", "description": "SHA-256 of the input files, by key"},
            },
        }  # fmt: skip


def _bare(value: Any) -> Any:
    return os.path.basename(value) if isinstance(value, str) else [os.path.basename(name) for name in value]


def tolerances(value: Any, path: str) -> dict[str, float]:
    """Return the standard deviations that a value states, by the places of its numbers: ``size_mm.0``.

    >>> tolerances((Toleranced(20.0, 0.5), 30.0), "size_mm")
    {'size_mm.0': 0.5}
    """
    if isinstance(value, Toleranced):
        return {path: value.sd}
    found: dict[str, float] = {}
    if isinstance(value, (Mapping, tuple, list)):
        items = value.items() if isinstance(value, Mapping) else enumerate(value)
        for key, one in items:
            found |= tolerances(one, f"{path}.{key}")
    return found


def with_tolerances(value: Any, path: str, known: Mapping[str, float]) -> Any:
    """Return a value with the standard deviations that are ``known`` of its numbers, by their places."""
    if isinstance(value, float) and path in known:
        return toleranced(value, known[path])
    if isinstance(value, tuple):
        return tuple(with_tolerances(one, f"{path}.{i}", known) for i, one in enumerate(value))
    if isinstance(value, Mapping):
        return {key: with_tolerances(one, f"{path}.{key}", known) for key, one in value.items()}
    return value
