"""``[production]``: pieces laid on the hot mold one after the other: its dip, what each takes, what holds it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from hyperfab.arrays import Array
from hyperfab.chapters.mold_heat.conditions import Placing
from hyperfab.documents.heat import PieceResult, Production
from hyperfab.documents.mold import MoldDocument, ProductionSection
from hyperfab.errors import InputError
from hyperfab.io.csv_write import csv_bytes
from hyperfab.thermal.condition import Renewal, Switched
from hyperfab.thermal.facet_operator import FacetOperator
from hyperfab.thermal.history import History
from hyperfab.thermal.mesh import HeatMesh
from hyperfab.thermal.piece import Layer, Piece, column

#: Pieces after which a mold that has not come round is told as it is.
MOST_PIECES = 1000


@dataclass(frozen=True)
class Pieces:
    """The pieces of a run: where they lie, ``solid`` nodes of the mold before theirs, the turns in and out."""

    section: ProductionSection
    piece: Piece
    lying: Switched
    facets: FacetOperator
    solid: int
    tolerance: float

    @property
    def count(self) -> int:
        """Pieces at most."""
        return self.section.pieces or MOST_PIECES

    def fresh(self, temperature: Array) -> None:
        """Put the first piece in, in place: it lies on the mold as the run begins."""
        temperature[self.piece.own] = self.section.temperature

    def turns(self, bare: list[Switched]) -> list[Renewal]:
        """Return the turns: a piece is taken out, with its heat, and later the next laid in, as it comes."""
        period, lies, nodes = self.section.period, self.section.lies, self.piece.own.ravel()
        out = tuple(period * k + lies for k in range(self.count))
        into = tuple(period * k for k in range(1, self.count + 1))
        at = self.section.temperature
        return [
            Renewal("pieces taken out", nodes, at, out, on=tuple(bare), off=(self.lying,)),
            Renewal("pieces laid in", nodes, at, into, on=(self.lying,), off=tuple(bare)),
        ]

    def finished(self, history: History) -> bool:
        """Whether the next piece is due and either all are made, or each finds the mold as the one before did."""
        made = round(history.states[-1].time / self.section.period)
        if not np.isclose(history.states[-1].time, made * self.section.period, rtol=1e-12):
            return False
        if made >= self.count:
            return True
        return self.section.pieces is None and self.came_round(history)

    def came_round(self, history: History) -> bool:
        """Whether the mold will still change by less than the tolerance: its changes from piece to piece summed on."""
        changes = self.changes(history)
        if len(changes) < 2:
            return False
        now, before = changes[-1], changes[-2]
        left = now * now / (before - now) if now < before else np.inf
        return bool(now == 0.0 or left <= self.tolerance)

    def changes(self, history: History) -> list[float]:
        """Return by how much the mold differs, at most, each time a piece is due, from the time before [K]."""
        due = [history.states[i].temperature[: self.solid] for i in self.due(history)]
        return [float(np.abs(b - a).max()) for a, b in pairwise(due)]

    def due(self, history: History) -> list[int]:
        """Return the states, by number, at which a piece is laid in, and the last, where the next one would be."""
        return self._at(history, 0.0)

    def out(self, history: History) -> list[int]:
        """Return the states at which a piece is taken out, still as it was."""
        return self._at(history, self.section.lies)

    def _at(self, history: History, phase: float) -> list[int]:
        times = np.array([state.time for state in history.states])
        count = np.floor((times - phase) / self.section.period + 0.5)
        exact = count * self.section.period + phase
        return np.flatnonzero((count >= 0) & (np.abs(times - exact) <= 1e-9 * self.section.period)).tolist()


def pieces_of(
    document: MoldDocument, placing: Placing
) -> tuple[HeatMesh, Callable[[Placing, HeatMesh], Pieces]] | None:
    """Return the mesh with the pieces' cells as loose nodes, and what places the pieces on it; None without any."""
    section = document.production
    if section is None:
        return None
    work = document.work_surface.on if document.work_surface is not None else []
    key = "production.on" if section.on is not None else "work_surface.on"
    found = placing.facets_of(key, section.on or work)
    if not placing.mesh.facets.outer[found.mask].all():
        raise InputError(
            "pieces lie on outer faces; these are covered by another part",
            key=key,
            remedy="name faces that see the air",
        )
    layers = []
    for layer in section.layers:
        stuff = document.material[layer.material]
        assert isinstance(stuff.conductivity, float)
        assert isinstance(stuff.specific_heat, float)
        layers.append(Layer(layer.thickness / 1e3, stuff.conductivity, stuff.density * stuff.specific_heat))
    mesh = placing.mesh
    corners = mesh.points[mesh.facet_nodes(found.mask)[:, :3]]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    above = corners.mean(axis=1)[:, None] + normal[:, None] * column(layers).height[None, :, None]
    other = None if section.other is None else (section.other.h, section.other.temperature)

    def placed(placing: Placing, mesh: HeatMesh) -> Pieces:
        facets = FacetOperator(mesh.points, mesh.facet_nodes(found.mask))
        piece = Piece(facets, mesh.solid, layers, section.h, other)
        placing.areas[piece.name] = facets.area * 1e6
        return Pieces(section, piece, Switched(piece, on=True), facets, mesh.solid, document.run.tolerance)

    placing.covered = found.mask
    # Its nodes are in no element: it lies on the mold for a while.
    return replace(mesh, points=np.concatenate([mesh.points, above.reshape(-1, 3)])), placed


def pieces_made(pieces: Pieces, history: History) -> list[PieceResult]:
    """Return what each piece took, and what it did to the mold."""
    section, ledger, model = pieces.section, history.ledger, pieces.piece
    names = ledger.names
    entered = np.array(ledger.entered)
    due, out = pieces.due(history), pieces.out(history)
    exchanged = [i for i, name in enumerate(names) if name.startswith("pieces ")]
    rows = []
    for number, (begin, end, taken) in enumerate(zip(due[:-1], due[1:], out, strict=False)):
        means = [pieces.facets.mean(state.temperature) for state in history.states[begin : end + 1]]
        local = history.states[begin].temperature - np.min(
            [state.temperature for state in history.states[begin : end + 1]], axis=0
        )
        through = entered[begin:end].sum(axis=0)
        gained = model.heat(history.states[taken].temperature, section.temperature)
        supplied, lost = (float(heat[begin:end].sum()) for heat in ledger.by_step)
        from_other = float(through[names.index(model.name)])
        left = -lost - float(through[exchanged].sum()) - from_other
        cells = history.states[taken].temperature[model.own]
        share = model.cells.capacity / model.cells.capacity.sum()
        mean = float(model.area @ (cells @ share) / model.area.sum())
        rows.append(
            PieceResult(
                number=number + 1,
                time_s=history.states[begin].time,
                surface_degC=means[0],
                lowest_degC=min(means),
                dip_K=means[0] - min(means),
                dip_max_K=float(local[pieces.facets.all_nodes].max()),
                heat_from_mold_J=gained - from_other,
                heat_from_other_J=from_other if section.other is not None else None,
                taken_out_degC=mean,
                supplied_J=supplied,
                lost_J=-left,
            )
        )
    return rows


def describe(pieces: Pieces, history: History) -> Production:
    """Return the figures of a production: of its last piece, and of the power that holds the mold through it."""
    section, model = pieces.section, pieces.piece
    rows = pieces_made(pieces, history)
    last = rows[-1]
    changes = pieces.changes(history)
    return Production(
        pieces=len(rows),
        period_s=section.period,
        in_s=section.lies,
        area_mm2=model.area.sum() * 1e6,
        piece_capacity_J_K=float(model.capacity.sum()),
        came_round=pieces.came_round(history),
        drift_K=changes[-1] if changes else None,
        power_W=last.supplied_J / section.period,
        power_to_hold_W=(last.lost_J + last.heat_from_mold_J) / section.period,
        last=last,
    )


def pieces_csv(pieces: Pieces, history: History) -> bytes:
    """Return one row a piece."""
    found = pieces_made(pieces, history)
    names = list(PieceResult.model_fields)
    return csv_bytes(names, [[getattr(row, name) for name in names] for row in found])
