"""The command ``hf``. One file a command holds its options and help; the work is in its chapter."""

from __future__ import annotations

import os
import re
import sys
from typing import Annotated, Any

import typer
from typer.core import TyperCommand, TyperGroup

from hyperfab import __version__
from hyperfab.cases.registry import case_class
from hyperfab.cli import (
    close_loop,
    export,
    fit,
    mold_heat,
    press_contact,
    report,
    sample,
    schema,
    summary,
    sweep,
)
from hyperfab.cli.command import command_of
from hyperfab.errors import OutputError

#: What the parser says of a type behind the name of an argument; the help says it in words.
_TYPES = re.compile(r" <(?:str|int|float|list\[)[^>]*>")


class Command(TyperCommand):
    """A command whose help names no types of the language it is written in."""

    def get_help(self, ctx: Any) -> str:
        """Return the help page."""
        return _TYPES.sub(lambda found: " " * len(found[0]), super().get_help(ctx))


class Group(TyperGroup):
    """All commands; ``hf help COMMAND`` is ``hf COMMAND --help``."""

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        """Return the command that is meant."""
        if args and args[0] == "help":
            if len(args) == 1:
                print(self.get_help(ctx))
                raise typer.Exit
            args = [*args[1:], "--help"] if args[1] != "--man" else ["help", "--man"]
            if args[-1] == "--man":
                from hyperfab.cli.manual import manual

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

# In the order of the production line.
app.command("fit", cls=Command, short_help=fit.SHORT_HELP)(fit.fit)
app.command(
    "fabric-contact", cls=Command, short_help="A sphere, or any punch (STL), pushed into a clamped sheet"
)(command_of(case_class("fabric-contact")))
app.command("drape", cls=Command, short_help="Fabric relaxed onto a mold (STL)")(
    command_of(case_class("drape"))
)
app.command("mold-heat", cls=Command, short_help=mold_heat.SHORT_HELP)(mold_heat.mold_heat)
app.command("press-contact", cls=Command, short_help=press_contact.SHORT_HELP)(press_contact.press_contact)
app.command("close-loop", cls=Command, short_help=close_loop.SHORT_HELP)(close_loop.close_loop)
app.command("report", cls=Command, short_help=report.SHORT_HELP)(report.report)
app.command("sweep", cls=Command, short_help=sweep.SHORT_HELP)(sweep.sweep)
app.command("export", cls=Command, short_help=export.SHORT_HELP)(export.export)
app.command("summary", cls=Command, short_help=summary.SHORT_HELP)(summary.summary)
app.command("sample", cls=Command, short_help=sample.SHORT_HELP)(sample.sample)
app.command("schema", cls=Command, short_help=schema.SHORT_HELP)(schema.schema)


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


def main() -> None:
    """Entry point of ``hf``: exits with the statuses that README.md lists."""
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
