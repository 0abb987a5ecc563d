"""What an equilibrium says: stretches, stresses, thickness, slack, forces, and how deep anything is in the mold."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from hyperfab.arrays import Array, Flags

from .depth import Cut, cut
from .law import SpringLaw
from .membrane import Cells, cells_of
from .mold import FREE, Mold
from .net import Sheet
from .start import settled
from .state import Equilibrium, State

#: A spring shorter than its rest length by more than this share is slack (below it: rounding).
SLACK = 1e-9
#: A node this many mm off the mold lies on it: where nothing presses, a node is no surer of its place than that.
TOUCHES = 1e-5


@dataclass(frozen=True)
class Answers:
    """Fields of the draped sheet; nodes (n, m), cells (n - 1, m - 1), springs by direction.

    Stresses are nominal (force per undeformed section), at a node the mean of its springs of that direction. Of a
    membrane stretches along warp and weft are those in the middle of its cells, in place of springs'; stresses,
    thickness and slack are its law's, in the ``cells``.
    """

    stretch_warp: Array  # (n - 1, m) springs
    stretch_weft: Array  # (n, m - 1)
    stress_warp: Array  # (n, m) MPa
    stress_weft: Array  # (n, m) MPa
    cell_stretch_warp: Array  # (n - 1, m - 1)
    cell_stretch_weft: Array
    cell_shear: Array  # degrees off the right angle
    cell_thickness: Array  # mm
    cell_slack: Flags
    cell_on_edge: Flags  # a taut spring of the cell runs over a sharp edge of the mold
    contact_edges: int  # taut springs that a sharp edge of the mold carries
    slack_springs: int  # of a membrane: cells without tension in one direction or both
    touching: Flags  # (n, m) nodes on the mold
    contact_force: Array  # (n, m, 3) N, of the mold on the sheet
    reaction: Array  # (n, m, 3) N, of the clamps on the sheet
    spring_energy: float  # N mm
    press_force: float  # N, along z
    imbalance: float  # N, clamp reactions + contact forces + weight
    cut: Cut  # how deep the net is in the mold
    cells: Cells | None = None  # of a membrane

    @property
    def cell_stretch(self) -> Array:
        """(n - 1, m - 1) the larger stretch: of a cell's springs, the mean of two; of a membrane the principal one."""
        if self.cells is not None:
            return self.cells.stretch
        return np.maximum(self.cell_stretch_warp, self.cell_stretch_weft)

    @property
    def stretched(self) -> tuple[Array, ...]:
        """Stretches of all springs by direction, or of a membrane's cells."""
        return (self.stretch_warp, self.stretch_weft) if self.cells is None else (self.cells.stretch,)

    @property
    def most_stretched(self) -> tuple[tuple[int, int], tuple[int, int]]:
        """The nodes on both ends of the spring that is stretched most, or across that cell of a membrane."""
        direction = int(np.argmax([float(one.max()) for one in self.stretched]))
        stretch = self.stretched[direction]
        i, j = (int(k) for k in np.unravel_index(int(stretch.argmax()), stretch.shape))
        if self.cells is not None:
            return (i, j), (i + 1, j + 1)
        return (i, j), ((i, j + 1) if direction else (i + 1, j))

    @property
    def stretch_max(self) -> float:
        """Largest stretch of a spring, or of a membrane in the middle of a cell."""
        return float(max(one.max() for one in self.stretched))


def answers(sheet: Sheet, mold: Mold, found: Equilibrium, deepest: Cut | None = None) -> Answers:
    """Fields and figures of an equilibrium; ``deepest`` is how deep the net is in the mold, where that is known."""
    x = found.state.x
    along = np.linalg.norm(np.diff(x, axis=0), axis=2)
    across = np.linalg.norm(np.diff(x, axis=1), axis=2)
    for (i, j, d, _), length in zip(found.bent, found.bent_length, strict=True):
        (along if d == 0 else across)[i, j] = length
    rest, lengths = sheet.rest, sheet.rest_lengths
    warp, weft = along / lengths[0], across / lengths[1]
    slack_warp, slack_weft = warp < 1.0 - SLACK, weft < 1.0 - SLACK
    diagonal = (x[1:, 1:] - x[:-1, :-1], x[:-1, 1:] - x[1:, :-1])
    area = 0.5 * np.linalg.norm(np.cross(*diagonal), axis=2)
    side_x, side_y = 0.5 * (diagonal[0] - diagonal[1]), 0.5 * (diagonal[0] + diagonal[1])
    cosine = (side_x * side_y).sum(2) / np.maximum(
        np.linalg.norm(side_x, axis=2) * np.linalg.norm(side_y, axis=2), 1e-300
    )
    # Where springs are laid over an edge the chords cut it off: the area is that of the sides as they run.
    folded, on_edge = np.zeros(area.shape, np.bool_), np.zeros(area.shape, np.bool_)
    own = np.array([lengths[d][i, j] for i, j, d, _ in found.bent])
    carried = found.bent_length > own * (1.0 + SLACK)
    for (i, j, d, _), taut in zip(found.bent, carried, strict=True):
        beside = np.s_[i : i + 1, max(j - 1, 0) : j + 1] if d == 0 else np.s_[max(i - 1, 0) : i + 1, j : j + 1]
        folded[beside] = True
        on_edge[beside] |= taut
    sides = 0.25 * (along[:, :-1] + along[:, 1:]) * (across[:-1] + across[1:])
    area = np.where(folded, sides * np.sqrt(np.maximum(1.0 - cosine**2, 0.0)), area)
    cell_slack = slack_warp[:, :-1] | slack_warp[:, 1:] | slack_weft[:-1] | slack_weft[1:]
    touching = (found.state.contact != FREE)[:, :, None]
    unbalanced = found.residual
    held = np.zeros_like(x)
    for axis in range(3):
        held[:, :, axis] = (sheet.fixed >> axis) & 1
    contact = np.where(touching, (unbalanced - found.force) * (1.0 - held), 0.0)
    reaction = -found.force * held
    reaction += np.where(touching, 0.0, (unbalanced - found.force) * (1.0 - held))  # of the blank holder
    weight = sheet.arrays.weight.sum()
    total = contact.sum((0, 1)) + reaction.sum((0, 1)) + found.push - [0.0, 0.0, weight]
    said = Answers(
        warp,
        weft,
        _at_nodes(sheet.warp, warp, 0),
        _at_nodes(sheet.weft, weft, 1),
        0.5 * (warp[:, :-1] + warp[:, 1:]),
        0.5 * (weft[:-1] + weft[1:]),
        np.degrees(np.arcsin(np.clip(cosine, -1.0, 1.0))),
        sheet.thickness * rest[0] * rest[1] / np.maximum(area, 1e-300),
        cell_slack,
        on_edge,
        int(carried.sum()),
        int(slack_warp.sum() + slack_weft.sum()),
        on_mold(x, sheet, mold, found.state),
        contact,
        reaction,
        found.energy - float((sheet.arrays.weight * x[:, :, 2]).sum()),
        float(contact[:, :, 2].sum() + found.push[2]),
        float(np.abs(total).max()),
        deepest or cut(x, sheet, mold, found.state, found.bent, found.bent_at),
    )
    if sheet.membrane is None:
        return said
    cells = cells_of(sheet, x, along, across)
    return replace(
        said,
        stretch_warp=cells.stretch_warp,
        stretch_weft=cells.stretch_weft,
        cell_stretch_warp=cells.stretch_warp,
        cell_stretch_weft=cells.stretch_weft,
        cell_shear=cells.shear,
        stress_warp=cells.stress_warp,
        stress_weft=cells.stress_weft,
        cell_thickness=sheet.thickness * cells.thickness,
        cell_slack=cells.wrinkled,
        slack_springs=int(cells.wrinkled.sum()),
        cells=cells,
    )


def on_mold(x: Array, sheet: Sheet, mold: Mold, state: State) -> Flags:
    """(n, m) nodes on the mold, also those that lie on a flat of it without pressing."""
    skin = np.full(x.shape[:2], TOUCHES)
    return settled(x, mold, sheet, skin, (state.clear.copy(), state.slot.copy())).contact != FREE


def _at_nodes(law: SpringLaw, stretch: Array, axis: int) -> Array:
    stress = law(stretch)[1]
    pad = [(0, 0), (0, 0)]
    pad[axis] = (1, 1)
    padded = np.pad(stress, pad, mode="edge")
    n = padded.shape[axis]
    return np.asarray(0.5 * (padded.take(range(n - 1), axis) + padded.take(range(1, n), axis)))
