"""``hf report``: its options and its help."""

from __future__ import annotations

from typing import Annotated

import typer

from hyperfab.cli.shared import Debug, Quiet, run_chapter

SHORT_HELP = "One page to look at, from any documents"


def report(
    context: typer.Context,
    documents: Annotated[
        list[str], typer.Argument(metavar="DOCUMENT...", help="Documents of any kind, in any order.")
    ],
    title: Annotated[str, typer.Option(help="Title of the page.")] = "From fabric to press",
    output: Annotated[
        str,
        typer.Option(
            "--output", "-o", metavar="NAME.html", help="Where the page goes; - is standard output."
        ),
    ] = "-",
    quiet: Quiet = False,
    debug: Debug = False,
) -> None:
    """Write one self-contained page: verdicts, tables, curves, turnable views. It opens without a network.

    \b
    Example:
      hf report build/fabric.json build/drape.json build/press.json -o report.html
    """
    run_chapter(context)
