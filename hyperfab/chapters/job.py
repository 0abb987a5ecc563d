"""What every command has in hand: its arguments, the console, what it read, and where it writes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from hyperfab.console import Console
from hyperfab.documents.base import Document
from hyperfab.documents.provenance import record
from hyperfab.io.inputs import Inputs
from hyperfab.io.output import Output


@dataclass
class Job:
    """One run of one command.

    ``arguments`` are the options as the user gave them, for provenance.
    """

    command: str
    arguments: Sequence[str]
    console: Console
    inputs: Inputs = field(default_factory=Inputs)

    def opened(self, target: str, suffixes: Sequence[str]) -> Output:
        """Return where the command writes: ``target`` and its siblings; a run inside another command keeps them."""
        return Output(target, suffixes)

    def keep(self, told: object) -> None:
        """Offer what was computed to a command that runs this one inside itself; nobody takes it otherwise."""

    def write(self, output: Output, document: Document) -> None:
        """Write the document with its provenance, and the siblings queued in ``output``."""
        document.format = document.format_name()
        document.provenance = record(self.command, self.arguments, self.inputs.files, output.target)
        output.finish(document.to_json(), self.inputs)
