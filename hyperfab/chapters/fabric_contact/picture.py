"""The picture of the sheet under the punch."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hyperfab.arrays import Array
from hyperfab.chapters.fabric_contact.fields import mirrors_of
from hyperfab.membrane.sphere_contact import Outcome, Solved
from hyperfab.report.figures_contact import Curve, Surface, contact_figure


def picture(
    names: Sequence[str],
    outcomes: Sequence[Outcome],
    compared: tuple[Solved, Array] | None,
    interval: tuple[float, float] | None,
) -> bytes:
    """Return force against depth, the first law's stress, and where the laws differ if they were ``compared``;
    ``interval`` is that of the first law's last force, where it is known."""
    curves = [
        Curve(
            name,
            [0.0] + [solved.state.depth for solved in outcome.solved],
            [0.0] + [solved.state.force for solved in outcome.solved],
            f"no equilibrium beyond {outcome.path.limit.depth:.1f} mm" if outcome.path.limit else None,
            interval if outcome is outcomes[0] else None,
        )
        for name, outcome in zip(names, outcomes, strict=True)
    ]
    last = outcomes[0].solved[-1]
    stress = last.fields.cauchy.max(axis=1)
    return contact_figure(curves, _surface(last, stress), None if compared is None else _surface(*compared))


def _surface(solved: Solved, values: Array) -> Surface:
    """The whole deformed sheet as straight triangles with a value at each node."""
    mesh, places = solved.press.sheet.mesh, solved.state.places
    mirrors = mirrors_of(mesh.copies)
    return Surface(
        points=np.concatenate([places * mirror for mirror in mirrors]),
        triangles=np.concatenate(
            [mesh.elements[:, :3] + number * len(places) for number in range(len(mirrors))]
        ),
        values=np.tile(values, len(mirrors)),
    )
