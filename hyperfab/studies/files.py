"""Files that a step reads: found in its arguments and in the documents these name, known by their contents."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable
from typing import Any

from hyperfab.errors import HyperfabError
from hyperfab.io.inputs import Inputs
from hyperfab.io.json_io import load_json
from hyperfab.io.toml_io import load_toml

#: Documents may name documents; nobody nests them deeper.
_MAX_DEPTH = 8


class FileKnowledge:
    """What is known of the files of a study. Each is read once: files must not change while a study runs."""

    def __init__(self, folder: str, inputs: Inputs) -> None:
        self.folder = os.path.abspath(folder)
        self._inputs = inputs
        self._hashes: dict[str, str] = {}

    def find(self, text: str, folder: str | None = None) -> str | None:
        """Return the absolute path that ``text`` names, seen from ``folder`` (the study's), if there is such a file."""
        if not text or len(text) > 1000 or "\n" in text or "\0" in text:
            return None
        path = os.path.normpath(os.path.join(folder or self.folder, text))
        return path if os.path.isfile(path) else None

    def digest(self, path: str, depth: int = 0) -> str:
        """Return the hash of a file and of every file that it names, if it is a document."""
        if path not in self._hashes:
            data = self._inputs.read(path)
            whole = hashlib.sha256(data)
            if path.endswith((".toml", ".json")) and depth < _MAX_DEPTH:
                self._hashes[path] = ""  # a document that names itself ends here
                for name in sorted(self._named(data, path)):
                    whole.update(self.digest(name, depth + 1).encode())
            self._hashes[path] = whole.hexdigest()
        return self._hashes[path]

    def _named(self, data: bytes, path: str) -> set[str]:
        try:
            loaded = load_toml(data, path) if path.endswith(".toml") else load_json(data, path)
        except HyperfabError:
            return set()  # the step that reads it will say what is wrong with it
        found: set[str] = set()

        def note(text: str) -> str:
            place = self.find(text, os.path.dirname(path))
            if place is not None:
                found.add(place)
            return text

        map_texts(loaded, note)
        return found


def map_texts(value: Any, change: Callable[[str], str]) -> Any:
    """Return plain data with every text in it changed; keys stay.

    >>> map_texts({"a": ["x", 1]}, str.upper)
    {'a': ['X', 1]}
    """
    if isinstance(value, str):
        return change(value)
    if isinstance(value, dict):
        return {key: map_texts(item, change) for key, item in value.items()}
    if isinstance(value, list):
        return [map_texts(item, change) for item in value]
    return value
