"""``hf schema``: its options and its help."""

from __future__ import annotations

from typing import Annotated

import typer

from hyperfab.cli.shared import Debug, run_chapter

SHORT_HELP = "JSON Schema of a document kind"


def schema(
    context: typer.Context,
    kind: Annotated[
        str,
        typer.Argument(
            metavar="KIND", help="material, contact, drape, mold, heat, foam, press, loop, study or sweep."
        ),
    ],
    debug: Debug = False,
) -> None:
    """Print the JSON Schema of a kind of document.

    \b
    Example:
      hf schema material
    """

    run_chapter(context)
