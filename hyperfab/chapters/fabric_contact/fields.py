"""The sheet's fields and curves as files, and the picture of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from hyperfab.arrays import Array
from hyperfab.io.vtu import unstructured
from hyperfab.membrane.sphere_contact import Outcome, Solved


def sure_fields(solved: Solved) -> dict[str, Array]:
    """Return the fields at the nodes (n,) that are told with their standard deviations."""
    found = solved.fields
    return {
        "stress_1_MPa": found.cauchy[:, 0],
        "stress_2_MPa": found.cauchy[:, 1],
        "stretch_1": found.stretch[:, 0],
        "stretch_2": found.stretch[:, 1],
        "thickness_mm": found.thickness,
    }


def vtu(solved: Solved, difference: Array | None, twins: Mapping[str, Array]) -> bytes:
    """Return the whole deformed sheet with its fields; a computed quarter is mirrored. ``twins`` (n,) by name are
    standard deviations of fields, where they are known."""
    sheet, state = solved.press.sheet, solved.state
    found = solved.fields
    gap = solved.press.punch.near(state.places, state.depth).gap
    data = {
        **sure_fields(solved),
        **twins,
        "gap_mm": np.where(state.touching, 0.0, gap),
        "contact": state.touching,
        "pressure_MPa": pressure(solved, found.cauchy, found.thickness),
        "undeformed_mm": np.column_stack([sheet.mesh.nodes, np.zeros(len(gap))]),
    }
    if difference is not None:
        data["stress_difference_MPa"] = difference
    states = sheet.response(state.places).state.reshape(sheet.mesh.weights.shape)
    wrinkled = (states != 0).mean(axis=1)
    mirrors = mirrors_of(sheet.mesh.copies)
    elements = sheet.mesh.elements
    flipped = elements[:, [0, 2, 1, 5, 4, 3] if elements.shape[1] == 6 else [0, 2, 1]]
    places, cells = [], []
    repeated: dict[str, list[Array]] = {name: [] for name in data}
    for number, mirror in enumerate(mirrors):
        places.append(state.places * mirror)
        cells.append((elements if mirror.prod() > 0 else flipped) + number * len(state.places))
        for name, values in data.items():
            repeated[name].append(values * mirror if values.ndim == 2 else values)
    kind = "triangle6" if elements.shape[1] == 6 else "triangle"
    return unstructured(
        np.concatenate(places),
        {kind: np.concatenate(cells)},
        {name: np.concatenate(values) for name, values in repeated.items()},
        {"wrinkled": np.tile(wrinkled, len(mirrors))},
    )


def pressure(solved: Solved, cauchy: Array, thickness: Array) -> Array:
    """Return the contact pressure (n,) [MPa]: tensions times curvature, the mean curvature of the punch."""
    state = solved.state
    turning = solved.press.punch.near(state.places, state.depth).turning
    curvature = 0.5 * np.trace(turning, axis1=1, axis2=2)
    return np.where(state.touching, cauchy.sum(axis=1) * thickness * curvature, 0.0)


def mirrors_of(copies: int) -> list[Array]:
    """Return the signs of x, y, z that make the whole sheet of a computed part."""
    signs = [(1, 1), (-1, 1), (-1, -1), (1, -1)] if copies == 4 else [(1, 1)]
    return [np.array([x, y, 1.0]) for x, y in signs]


def picture(
    names: Sequence[str],
    outcomes: Sequence[Outcome],
    compared: tuple[Solved, Array] | None,
    interval: tuple[float, float] | None,
) -> bytes:
    """Return force against depth, the first law's stress, and where the laws differ if they were ``compared``;
    ``interval`` is that of the first law's last force, where it is known."""
    # matplotlib takes a fifth of the start.
    from hyperfab.report.figures_contact import Curve, Surface, contact_figure

    def surface(solved: Solved, values: Array) -> Surface:
        """The whole deformed sheet as straight triangles with a value at each node."""
        mesh, places = solved.press.sheet.mesh, solved.state.places
        mirrors = mirrors_of(mesh.copies)
        corners = [mesh.elements[:, :3] + number * len(places) for number in range(len(mirrors))]
        return Surface(
            points=np.concatenate([places * mirror for mirror in mirrors]),
            triangles=np.concatenate(corners),
            values=np.tile(values, len(mirrors)),
        )

    curves = [
        Curve(
            name,
            [0.0] + [solved.read for solved in outcome.solved],
            [0.0] + [solved.state.force for solved in outcome.solved],
            f"no equilibrium beyond {outcome.path.limit.depth:.1f} mm" if outcome.path.limit else None,
            interval if outcome is outcomes[0] else None,
        )
        for name, outcome in zip(names, outcomes, strict=True)
    ]
    last = outcomes[0].solved[-1]
    stress = last.fields.cauchy.max(axis=1)
    return contact_figure(curves, surface(last, stress), None if compared is None else surface(*compared))
