"""The command ``hf``. One file a command holds its options and help; the work is in its chapter."""

from __future__ import annotations

import os
import sys
from typing import Annotated

import typer

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

app = typer.Typer(
    name="hf",
    no_args_is_help=True,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
    add_completion=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)

# In the order of the production line.
app.command("fit", short_help=fit.SHORT_HELP)(fit.fit)
app.command("fabric-contact", short_help="A sphere, or any punch (STL), pushed into a clamped sheet")(
    command_of(case_class("fabric-contact"))
)
app.command("drape", short_help="Fabric relaxed onto a mold (STL)")(command_of(case_class("drape")))
app.command("mold-heat", short_help=mold_heat.SHORT_HELP)(mold_heat.mold_heat)
app.command("press-contact", short_help=press_contact.SHORT_HELP)(press_contact.press_contact)
app.command("close-loop", short_help=close_loop.SHORT_HELP)(close_loop.close_loop)
app.command("report", short_help=report.SHORT_HELP)(report.report)
app.command("sweep", short_help=sweep.SHORT_HELP)(sweep.sweep)
app.command("export", short_help=export.SHORT_HELP)(export.export)
app.command("summary", short_help=summary.SHORT_HELP)(summary.summary)
app.command("sample", short_help=sample.SHORT_HELP)(sample.sample)
app.command("schema", short_help=schema.SHORT_HELP)(schema.schema)


@app.callback(invoke_without_command=True)
def hf(
    version: Annotated[bool, typer.Option("--version", help="Show the version and stop.")] = False,
) -> None:
    """Simulate how stretch fabrics are tested, stretched, heated and pressed into shape.

    Each command reads files and writes one JSON document, with fields, curves and pictures beside it.
    A later command takes the document of an earlier one; - reads it from standard input.
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
