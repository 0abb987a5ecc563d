"""What all documents share: format and version, strictness, provenance, reading with errors that name the place."""

from __future__ import annotations

import importlib
import re
from collections.abc import Callable, Iterator, Mapping
from typing import TYPE_CHECKING, Any, ClassVar, TypeVar

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from hyperfab.documents.provenance import Provenance
from hyperfab.errors import InputError, UsageError, near

if TYPE_CHECKING:
    from hyperfab.io.inputs import Inputs

#: Every kind of document and the class that describes it; imported only when asked for.
KINDS: dict[str, str] = {
    "material": "hyperfab.documents.material:MaterialDocument",
    "contact": "hyperfab.documents.contact:ContactDocument",
    "drape": "hyperfab.documents.drape:DrapeDocument",
    "mold": "hyperfab.documents.mold:MoldDocument",
    "heat": "hyperfab.documents.heat:HeatDocument",
    "foam": "hyperfab.documents.foam:FoamDocument",
    "press": "hyperfab.documents.press:PressDocument",
    "loop": "hyperfab.documents.loop:LoopDocument",
    "study": "hyperfab.documents.study:StudyDocument",
    "sweep": "hyperfab.documents.sweep:SweepDocument",
}


def optional(description: str) -> Any:
    """Return the field of a key that is absent where there is nothing to say; ``description`` goes to the schema."""
    return Field(default=None, description=description)


class Part(BaseModel):
    """A table of a document that a program wrote: keys of a later minor version are kept."""

    model_config = ConfigDict(extra="allow", allow_inf_nan=False)


class OrShort:
    """Lets the JSON Schema of a field take its short form too, which a validator writes out: one of a list, or what
    types ``short`` is of.
    """

    def __init__(self, *short: str) -> None:
        self.short = short

    def __get_pydantic_json_schema__(self, core: Any, handler: Callable[[Any], dict[str, Any]]) -> dict[str, Any]:
        full = handler(core)
        return {"anyOf": [*({"type": short} for short in self.short), full] if self.short else [full["items"], full]}


class Section(BaseModel):
    """A table of a document that people write: keys it does not know are refused."""

    model_config = ConfigDict(extra="forbid", allow_inf_nan=False, populate_by_name=True)


class Validity(Part):
    """One law or table: the range it was used over beside the range tested or tabulated, in the unit of ``of``."""

    model_config = ConfigDict(populate_by_name=True)

    of: str = Field(description="stretch, temperature_degC, strain, or a table's name")
    direction: str | None = optional("warp or weft, where each has a law of its own")
    used: tuple[float, float] = Field(description="smallest and largest value met")
    known: tuple[float, float] | None = optional(
        "smallest and largest value tested or tabulated; absent where nothing says"
    )
    within: bool | None = optional("whether used lies in known; absent where that is unknown")
    stress_ratio: float | None = optional(
        "the law's largest stress where it was used beyond its tests, over that at the end of them"
    )
    source: str = Field(alias="from", description="the input that the law or the table came from")


class MisfitError(ValueError):
    """What keys of a document say does not go together; ``key`` is the one to look at."""

    def __init__(self, key: str, message: str) -> None:
        super().__init__(message)
        self.key = key


class Document(BaseModel):
    """A document on disk. Subclasses state KIND, VERSION and their keys.

    Keys of a later minor version are kept, not refused. Documents that people write derive from HandWritten.
    """

    model_config = ConfigDict(extra="allow", allow_inf_nan=False, validate_assignment=True)

    KIND: ClassVar[str]
    VERSION: ClassVar[int] = 1

    format: str = Field(default="", description="kind and version of the document")
    files: list[str] = Field(default_factory=list, description="files written beside the document, relative to it")
    validity: list[Validity] | None = optional(
        "where each law and table was used, beside where it was tested or tabulated"
    )
    provenance: Provenance | None = optional("how the document came to be")
    setup: Any = optional("the set-up that was run, defaults included")

    @classmethod
    def format_name(cls) -> str:
        """Return the value of ``format``: ``hyperfab.KIND/VERSION``."""
        return f"hyperfab.{cls.KIND}/{cls.VERSION}"

    def to_json(self, setup: Mapping[str, Any] | None = None) -> dict[str, Any]:
        """Return the document as plain data: what was not computed is absent; ``setup`` and provenance come last."""
        data: dict[str, Any] = self.model_dump(mode="json", exclude_none=True, by_alias=True)
        data["format"] = self.format_name()
        tail: dict[str, Any] = {
            key: data.pop(key) for key in ("setup", "validity", "files", "provenance") if key in data
        }
        if setup is not None:
            tail = {"setup": setup, **{key: value for key, value in tail.items() if key != "setup"}}
        return {"format": data.pop("format"), **data, **tail}


class HandWritten(Document):
    """A document that people write: a key it does not know is a spelling mistake, and refused."""

    model_config = ConfigDict(extra="forbid", allow_inf_nan=False)


DocumentT = TypeVar("DocumentT", bound=Document)


def document_class(kind: str) -> type[Document]:
    """Return the class of a kind of document; UsageError with the known kinds where there is none."""
    if kind not in KINDS:
        raise UsageError(f"no document kind {kind!r}; the kinds are {', '.join(KINDS)}")
    module, name = KINDS[kind].split(":")
    found: type[Document] = getattr(importlib.import_module(module), name)
    return found


def stated_kind(loaded: object) -> str:
    """Return the kind that plain data tells in ``format``, whether there is such a kind or not.

    >>> stated_kind({"format": "hyperfab.drape/1"})
    'drape'
    """
    found = loaded.get("format") if isinstance(loaded, Mapping) else None
    return str(found).removeprefix("hyperfab.").split("/")[0]


def told_format(found: object) -> tuple[str, int] | None:
    """Return the kind and version of ``format``, None where it is no format of hf."""
    match = re.fullmatch(r"hyperfab\.([a-z-]+)/([0-9]{1,6})", found) if isinstance(found, str) else None
    return None if match is None else (match[1], int(match[2]))


def schema(kind: str) -> dict[str, Any]:
    """Return the JSON Schema of a kind of document."""
    cls = document_class(kind)
    found = cls.model_json_schema(by_alias=True)
    found["$schema"] = "https://json-schema.org/draft/2020-12/schema"
    found["properties"]["format"] = {
        "const": cls.format_name(),
        "description": "kind and version of the document",
    }
    found["required"] = sorted({"format", *found.get("required", [])})
    return found


def read_document(inputs: Inputs, name: str, cls: type[DocumentT]) -> DocumentT:
    """Read a JSON or TOML document of the kind of ``cls`` (``-``: standard input).

    Raises InputError naming the file and the key where the document is not sound.
    """
    return inputs.parsed(name, cls, lambda loaded: parse_document(loaded, name, cls))


def parse_document(loaded: object, name: str, cls: type[DocumentT]) -> DocumentT:
    """Check plain data against the kind of ``cls``; ``name`` is the file it came from, for messages."""
    if not isinstance(loaded, Mapping):
        raise InputError("is not a document: its top level is not an object", file=name)
    check_format(loaded.get("format"), name, cls)
    try:
        return cls.model_validate(loaded)
    except ValidationError as error:
        raise first_error(error, name, cls, loaded) from None


def check_format(found: object, name: str, cls: type[Document]) -> None:
    """Refuse another kind, or a version that this program does not know, by name."""
    wanted = cls.format_name()
    told = told_format(found)
    if told is None:
        raise InputError(
            "does not say what it is" if found is None else f"unknown format {_short(found)}",
            file=name,
            key="format",
            remedy=f'a {cls.KIND} document has "format": "{wanted}"',
        )
    kind, version = told
    if kind != cls.KIND:
        raise InputError(
            f"is a {kind} document, a {cls.KIND} document is needed",
            file=name,
            key="format",
            remedy=_maker(cls.KIND),
        )
    if not 1 <= version <= cls.VERSION:
        again = "make the document again with this one"
        raise InputError(
            f"has version {version} of the format ({found}), this hf knows "
            + (f"up to {cls.VERSION}" if version else "none below 1"),
            file=name,
            key="format",
            remedy=f"use a newer hf, or {again}" if version else f'write "{wanted}", or {again}',
        )


def first_error(error: ValidationError, name: str, cls: type[BaseModel], loaded: object) -> InputError:
    """Return the first finding of pydantic as an InputError that names the key and the entry of ``loaded``."""
    found = error.errors(include_url=False)
    # A misspelt key is also a missing one: the spelling is what helps.
    first = next((one for one in found if one["type"] == "extra_forbidden"), found[0])
    misfit = first.get("ctx", {}).get("error")
    key = misfit.key if isinstance(misfit, MisfitError) else _key(first["loc"])
    others = list(dict.fromkeys(_key(one["loc"]) for one in found if one is not first))
    more = _entry(loaded, first["loc"])
    if others:
        more += f" (and {len(others)} more: {', '.join(others[:5])}{', ...' if len(others) > 5 else ''})"
    kind, value = first["type"], first.get("input")
    if kind == "missing":
        return InputError(f"is missing{more}", file=name, key=key, remedy="add the key")
    if kind == "extra_forbidden":
        known = list(_keys(cls.model_json_schema()))
        word, beside = str(first["loc"][-1]), first["loc"][:-1]
        needed = [str(one["loc"][-1]) for one in found if one["type"] == "missing" and one["loc"][:-1] == beside]
        if word in known and beside:
            hint = near(word, needed) or "it belongs to another section; move it there or leave it out"
            return InputError(f"is no key of {_key(beside)}{more}", file=name, key=key, remedy=hint)
        hint = near(word, [*needed, *known]) or "check the spelling"
        return InputError(f"is not a key of this document{more}", file=name, key=key, remedy=hint)
    if kind == "list_type" and isinstance(value, dict) and len(first["loc"]) == 1:
        text = f"is one table where a list of them is due{more}"
        return InputError(text, file=name, key=key, remedy=f"write [[{key}]], in two brackets, at its head")
    text = first["msg"].removeprefix("Value error, ")
    shown = "" if isinstance(value, (dict, list)) else f", not {_short(value)}"
    return InputError(f"{text[:1].lower()}{text[1:]}{shown if kind != 'value_error' else ''}{more}", file=name, key=key)


def _key(place: tuple[int | str, ...]) -> str:
    return ".".join(str(part) for part in place) or "format"


def _entry(loaded: object, place: tuple[int | str, ...]) -> str:
    """Return the name of the entry of a list that a key is in: numbers of entries are counted by programs alone.

    >>> _entry({"part": [{"name": "plate"}, {"name": "lid"}]}, ("part", 1, "stl"))
    " in part 'lid'"
    """
    said, now = "", loaded
    for before, step in zip(("", *place), place, strict=False):
        if isinstance(now, list) and isinstance(step, int) and step < len(now):
            now = now[step]
            if isinstance(now, Mapping):
                called = now.get("name")
                said = f" in {before} {_short(called)}" if called else f" in {_ordinal(step + 1)} {before}"
        elif isinstance(now, Mapping) and step in now:
            now = now[step]
        else:
            break
    return said


def _ordinal(number: int) -> str:
    """Return 1st, 2nd, 3rd, 4th."""
    teen = 10 < number % 100 < 14
    return f"{number}{'th' if teen else {1: 'st', 2: 'nd', 3: 'rd'}.get(number % 10, 'th')}"


def _keys(schema: Any) -> Iterator[str]:
    """Return the names of all keys that a document may have, at whatever depth."""
    if isinstance(schema, dict):
        yield from schema.get("properties", {}) if isinstance(schema.get("properties"), dict) else ()
        for value in schema.values():
            yield from _keys(value)
    elif isinstance(schema, list):
        for value in schema:
            yield from _keys(value)


def _maker(kind: str) -> str:
    makers = {
        "material": "fit",
        "contact": "fabric-contact",
        "drape": "drape",
        "heat": "mold-heat",
        "press": "press-contact",
    }
    return f"make one with hf {makers[kind]}" if kind in makers else f"hf schema {kind} prints what belongs in one"


def _short(value: object) -> str:
    text = repr(value)
    return text if len(text) <= 60 else text[:57] + "..."
