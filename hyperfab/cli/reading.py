"""Options that say how measured files are read, alike in all commands that read them."""

from __future__ import annotations

from typing import Annotated

import typer

Specimen = Annotated[
    str | None, typer.Option(metavar="NAME", help="Standard specimen, as iso-37-2 or iso-13934-1.")
]
GaugeLength = Annotated[
    str | None, typer.Option(metavar="LENGTH", help="Gauge length of force-extension tests.")
]
Width = Annotated[str | None, typer.Option(metavar="LENGTH", help="Width of force-extension tests.")]
Thickness = Annotated[str | None, typer.Option(metavar="LENGTH", help="Thickness of the fabric, as 0.6mm.")]
Diameter = Annotated[str | None, typer.Option(metavar="LENGTH", help="Diameter of a biaxial disc.")]
Branch = Annotated[str, typer.Option(metavar="BRANCH", help="Rows that take part: load, unload or all.")]
Cycle = Annotated[
    str, typer.Option(metavar="CYCLE", help="Cycle that takes part: a number, first, last or all.")
]
Zero = Annotated[
    bool, typer.Option("--zero", help="Count stretch and stress from the first row of each test.")
]
Preload = Annotated[
    str | None,
    typer.Option(
        metavar="LOAD", help="Take out slack: count from where this is reached, as 0.1N or 0.002MPa."
    ),
]
Resample = Annotated[
    int | None, typer.Option(metavar="N", help="Mean of N equal steps of stretch on each branch.")
]
Columns = Annotated[
    list[str],
    typer.Option(metavar="LIST", help='What columns are, as "Standardkraft=force [N],Weg=extension [mm]".'),
]
SkipRows = Annotated[
    int | None,
    typer.Option(metavar="N", help="Lines above the head of the table, where they cannot be told."),
]
