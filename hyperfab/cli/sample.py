"""``hf sample``: its options and its help."""

from __future__ import annotations

from typing import Annotated

import typer

from hyperfab.cli.shared import Debug, Quiet, run_chapter

SHORT_HELP = "The sample specimens and molds"


def sample(
    context: typer.Context,
    folder: Annotated[str, typer.Argument(metavar="DIR", help="Folder that receives specimens/ and molds/.")],
    force: Annotated[bool, typer.Option("--force", help="Overwrite files that differ.")] = False,
    quiet: Quiet = False,
    debug: Debug = False,
) -> None:
    """Write the sample specimens and molds.

    \b
    Example:
      hf sample .
    """

    run_chapter(context)
