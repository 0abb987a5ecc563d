"""``hf summary``: its options and its help."""

from __future__ import annotations

from typing import Annotated

import typer

from hyperfab.cli.shared import Debug, run_chapter

SHORT_HELP = "One screen about a set of documents"


def summary(
    context: typer.Context,
    documents: Annotated[list[str], typer.Argument(metavar="DOCUMENT...", help="Documents of any kind.")],
    debug: Debug = False,
) -> None:
    """Print what documents say, a few lines each, and where their pictures are.

    \b
    Example:
      hf summary fabric.json contact.json drape.json
    """

    run_chapter(context)
