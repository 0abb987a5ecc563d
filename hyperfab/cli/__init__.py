"""The command ``hf``. One file a command holds its options and help; the work is in its chapter."""

from __future__ import annotations

import os
import re
import sys
from typing import Annotated, Any

import typer
import typer.main
from typer.core import TyperCommand, TyperGroup

from hyperfab import __version__
from hyperfab.cases.registry import case_class
from hyperfab.cli.command import command_of
from hyperfab.errors import OutputError

#: What the parser says of a type behind the name of an argument; the help says it in words.
_TYPES = re.compile(r" <(?:str|int|float|list\[)[^>]*>")
#: In the order of the production line.
COMMANDS = {
    "fit": "Constants of a law from fabric tests",
    "fabric-contact": "A sphere, or any punch (STL), pushed into a clamped sheet",
    "drape": "Fabric relaxed onto a mold (STL)",
    "mold-heat": "Warm-up of a heated mold",
    "press-contact": "Where two hot molds touch",
    "close-loop": "What the model lacks, found in measured data",
    "report": "One page to look at, from any documents",
    "sweep": "Many runs over materials, molds and settings",
    "export": "Material card for a finite-element program",
    "summary": "One screen about a set of documents",
    "sample": "The sample specimens and molds",
    "schema": "JSON Schema of a document kind",
}


class Command(TyperCommand):
    """A command whose help names no types of the language it is written in."""

    def get_help(self, ctx: Any) -> str:
        """Return the help page."""
        return _TYPES.sub(lambda found: " " * len(found[0]), super().get_help(ctx))


class Group(TyperGroup):
    """All commands, each made when it is asked for: the list of them needs none of their options.

    ``hf help COMMAND`` is ``hf COMMAND --help``.
    """

    def __init__(self, **attributes: Any) -> None:
        super().__init__(**attributes)
        self.commands = dict.fromkeys(COMMANDS, None)  # type: ignore[assignment]

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        """Return the command of a name, None where there is none."""
        if cmd_name not in COMMANDS:
            return None
        alone = typer.Typer(rich_markup_mode=None, pretty_exceptions_enable=False, add_completion=False)
        made = alone.command(cmd_name, cls=Command, short_help=COMMANDS[cmd_name])
        made(command_of(case_class(cmd_name)))
        return typer.main.get_command(alone)

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        """Write the list of commands."""
        with formatter.section("Commands"):
            formatter.write_dl(list(COMMANDS.items()))

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        """Return the command that is meant."""
        if args and args[0] == "help":
            if len(args) == 1:
                print(self.get_help(ctx))
                raise typer.Exit
            args = [*args[1:], "--help"] if args[1] != "--man" else ["help", "--man"]
            if args[-1] == "--man":
                print(manual(self, ctx), end="")
                raise typer.Exit
        return super().resolve_command(ctx, args)


app = typer.Typer(
    name="hf",
    cls=Group,
    no_args_is_help=True,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
    add_completion=True,
    context_settings={"help_option_names": ["-h", "--help"]},
)


@app.callback(invoke_without_command=True)
def hf(
    version: Annotated[bool, typer.Option("--version", "-V", help="Show the version and stop.")] = False,
) -> None:
    """Simulate how stretch fabrics are tested, stretched, heated and pressed into shape.

    Each command reads files and writes one JSON document, with fields, curves and pictures beside it.
    A later command takes the document of an earlier one; - reads it from standard input.
    hf help COMMAND shows every option with an example, hf help --man prints a manual page.
    """
    if version:
        print(f"hf {__version__}")
        raise typer.Exit


#: What a shell asks for its completion: ``source_bash``, ``complete_zsh``.
_COMPLETE = "_HF_COMPLETE"


def main() -> None:
    """Entry point of ``hf``: exits with the statuses that README.md lists."""
    asked = os.environ.get(_COMPLETE, "").partition("_")
    if asked[2] in ("source", "complete"):  # the other order, as click itself and its guides have it
        os.environ[_COMPLETE] = f"{asked[2]}_{asked[0]}"
    try:
        try:
            app(prog_name="hf")
        except SystemExit as end:
            status = end.code if isinstance(end.code, int) else 0
        sys.stdout.flush()
    except OSError as error:
        # Help and usage are printed by typer, which lets a full disk through.
        print(f"hf: output: standard output: {error.strerror or error}", file=sys.stderr)
        # The interpreter would try to flush standard output once more, and print a traceback.
        os._exit(OutputError.exit_status)
    if status == OutputError.exit_status:
        os._exit(status)
    sys.exit(status)


def manual(group: Any, context: Any) -> str:
    """Return the page as man reads it: the group's own help, then that of each command."""
    lines = [
        f'.TH HF 1 "" "hf {__version__}" "hyperfab"',
        ".SH NAME",
        "hf \\- stretch fabrics, from test to press",
    ]
    lines += [".SH DESCRIPTION", *_literal(group.get_help(context))]
    for name in group.list_commands(context):
        command = group.get_command(context, name)
        own = command.context_class(command, info_name=name, parent=context)
        lines += [f'.SH "HF {name.upper()}"', *_literal(command.get_help(own))]
    return "\n".join(lines) + "\n"


def _literal(text: str) -> list[str]:
    """Return text that is set as it stands."""
    escaped = text.replace("\\", "\\e").replace("-", "\\-")
    return [
        ".nf",
        *(f"\\&{line}" if line[:1] in (".", "'") else line for line in escaped.splitlines()),
        ".fi",
    ]
