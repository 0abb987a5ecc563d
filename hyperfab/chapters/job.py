"""What every command has in hand: its arguments, the console, what it read, and where it writes."""

from __future__ import annotations

import os
import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from hyperfab.cases.case import Case
from hyperfab.cases.like import Earlier
from hyperfab.chapters.validity import Ranges
from hyperfab.console import NEGATIVE_VERDICT, Console
from hyperfab.documents.base import Document, stated_kind
from hyperfab.documents.provenance import record, relative_name
from hyperfab.io.inputs import Inputs
from hyperfab.io.output import Output, write_stdout
from hyperfab.io.text import map_texts


@dataclass
class Job:
    """One run of one command.

    arguments  the options as the user gave them, for provenance
    target     where the document goes, ``-`` is standard output
    like       the document that the set-up was taken from
    ranges     where laws and tables were used, and what is known of them there
    strict     end with status 1 where they were used beyond that
    sums_up    whether a summary goes to standard output in place of the document
    """

    command: str
    arguments: Sequence[str]
    console: Console
    inputs: Inputs = field(default_factory=Inputs)
    target: str = "-"
    like: Earlier[Any] | None = None
    ranges: Ranges = field(default_factory=Ranges)
    strict: bool = False
    sums_up: bool = False

    def opened(self, *suffixes: str) -> Output:
        """Return where the command writes: its target and siblings; a run inside another command keeps them."""
        return Output(self.target, suffixes)

    def write(self, output: Output, document: Document, case: Case | None = None, **known: Any) -> None:
        """Write the document with its set-up and provenance, and the siblings queued in ``output``.

        ``known`` are values of the set-up, by key, that were not asked for but follow from inputs; so are those that
        the document itself has under ``setup``.
        """
        self.judge_ranges()
        document.format = document.format_name()
        document.validity = [
            # The file's own name: the same set-up gives the same document wherever it is written.
            entry.model_copy(update={"source": os.path.basename(entry.source)})
            for entry in self.ranges.entries
        ]
        data = self.stated(document, output.target, case, **known)
        # A document behind the model is one to open: its place counts.
        places = {file.name: relative_name(file.name, output.target) for file in self.inputs.files}
        far = {name: seen for name, seen in places.items() if name not in (seen, "-")}
        data = {
            key: value
            if key in ("setup", "files", "provenance")
            else (_renamed(value, far) if key == "upstream" else self.named(value))
            for key, value in data.items()
        }
        if self.like is not None:
            for name in self.like.altered(self.inputs):
                self.console.warn(f"{name} has changed since {self.like.name} was made from it")
        if output.target == "-" and self.sums_up:
            self._sum_up(data)
            return
        output.finish(data, self.inputs)
        if output.wants_files:
            beside = f" and {len(output.names)} files beside it" if output.names else ""
            self.console.note(f"written: {output.target}{beside}")

    def stated(self, document: Document, target: str, case: Case | None, **known: Any) -> dict[str, Any]:
        """Return a document that lies at ``target`` or beside it as plain data, with its set-up and provenance.

        ``known`` are values of the set-up as in ``write``.
        """
        document.provenance = record(self.command, self.arguments, self.inputs.files, target)
        data: dict[str, Any] = document.to_json()
        if case is None:
            return data
        own = data.get("setup", {})
        hashes = {file.name: file.sha256 for file in self.inputs.files}
        return document.to_json(case.setup(hashes, known | own) | own)

    def named(self, data: Any) -> Any:
        """Return plain data with the inputs in its texts under their own names, namesakes as the document sees them.

        The same set-up gives the same document wherever it is written.
        """
        own_names = Counter(os.path.basename(file.name) for file in self.inputs.files)
        seen = {
            file.name: base if own_names[base] == 1 else relative_name(file.name, self.target)
            for file in self.inputs.files
            if (base := os.path.basename(file.name)) != file.name
        }
        return _renamed(data, seen)

    def _sum_up(self, data: dict[str, Any]) -> None:
        from hyperfab.chapters.summary import paragraph

        write_stdout(("\n".join(paragraph(data)) + "\n").encode())
        self.console.note(f"-o {stated_kind(data)}.json keeps it, -o - prints the document")

    def judge_ranges(self) -> None:
        """Say in one line what was used beyond what is known."""
        if self.ranges.warning:
            self.console.warn(self.ranges.warning)

    def ended(self, status: int) -> int:
        """Return the exit status of a run whose chapter returned ``status``."""
        return NEGATIVE_VERDICT if self.strict and self.ranges.outside and status == 0 else status


def _renamed(data: Any, names: Mapping[str, str]) -> Any:
    """Return plain data with the inputs in its texts by other ``names``: no folder of this machine stands in it."""
    if not names:
        return data
    longest = sorted(names, key=len, reverse=True)
    pattern = re.compile(rf"(?<![\w./-])(?:{'|'.join(map(re.escape, longest))})(?![\w/-])")
    return map_texts(data, lambda text: pattern.sub(lambda found: names[found[0]], text))
