"""Males that are made: of the gap that is asked for, and such that what the press forms is what is wanted."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from hyperfab.arrays import Array, Flags
from hyperfab.chapters.job import Job
from hyperfab.chapters.press_contact.formed import Formed, Setting, Wanted, formed
from hyperfab.chapters.press_contact.model import Model
from hyperfab.chapters.press_contact.warmth import column_of, settled
from hyperfab.documents.press import CompensationPart, CompensationStep, DesignPart, WantedPart
from hyperfab.errors import InputError
from hyperfab.io.stl_write import stl_bytes
from hyperfab.pressing.closing import Closed
from hyperfab.pressing.design import Design, DesignRefused, Offset, constant_gap, gaps, offset, with_back
from hyperfab.pressing.mold import Growth, Mold, PressFrame, mold, ungrown
from hyperfab.pressing.placement import clearance

#: The product is what is wanted where no place that can be misses it by more [mm]; a tenth of what a gauge tells.
_GOAL = 0.005
_MOST = 15
#: A gap is moved by no more than this at once [mm].
_LONGEST = 1.0
#: A place whose gap has come to its end and that still misses by more [mm] is out of reach.
_MISSED = 0.05
#: A thickness gains at least this share of what the gap gains, or nothing sets and the gap is left.
_LEAST_RATE = 0.02
#: A gap that is asked to be constant and that is off by more [mm] somewhere is told.
_UNEVEN = 0.05


def design_of(job: Job, closed: Closed, frame: PressFrame, gap: float, growth: Growth) -> tuple[bytes, DesignPart]:
    """Return the STL of the cold male whose hot gap is constant; refused with the place where there is none."""
    design, male, to_set = _male(closed, offset(closed.female), frame, gap, growth, f"--design-gap {gap:g} mm")
    # What a frame yields by at the force of that gap is not known here.
    unloaded = to_set if closed.case.frame is None else None
    left, places = gaps(male.moved(male.vertices + growth.at(male.vertices)), closed.female)
    part = DesignPart(
        gap_mm=gap,
        spread_mm=design.spread,
        gap_min_mm=float(left.min(initial=gap)),
        gap_max_mm=float(left.max(initial=gap)),
        clearance_to_set_mm=unloaded,
        facets=len(male.faces),
    )
    off = np.abs(left - gap)
    if off.max(initial=0.0) > _UNEVEN:
        at = ", ".join(f"{value:.1f}" for value in frame.outward(places[np.argmax(off)]))
        job.console.warn(
            f"the male of --design-gap leaves {part.gap_min_mm:.3f} to {part.gap_max_mm:.3f} mm, furthest off near "
            f"({at}) mm: facets of the female turn sharply there; give a finer STL, or its edge a radius"
        )
    return stl_bytes(frame.outward(male.vertices), male.faces), part


def _male(
    closed: Closed, base: Offset, frame: PressFrame, gap: float | Array, growth: Growth, asked: str = "--compensate"
) -> tuple[Design, Mold, float]:
    """Return the cold male that leaves ``gap`` [mm], everywhere or (n,), to the hot female where it stands.

    Before it the design, after it the cold clearance [mm] to set. Refused with the place in the drawing
    where there is no such male.
    """
    try:
        design = constant_gap(base, gap)
    except DesignRefused as error:
        at = ", ".join(f"{value:.1f}" for value in frame.outward(np.array(error.at)))
        raise InputError(
            f"{asked}: the surface {error.what} near ({at}) mm, on {error.faces} facets",
            remedy="ask for a smaller gap, or give the female a larger radius or more draft there, or a finer "
            "STL where its facets are few",
        ) from None
    mount = closed.case.male.mount
    vertices, faces = with_back(ungrown(design.vertices, growth), design.faces, mount)
    male = mold(vertices, faces, 1, mount, closed.case.male.smooth)
    apart = clearance(male, closed.case.female).gap
    return design, male, apart + closed.clearance_cold - closed.datum.gap


@dataclass(frozen=True)
class _Tried:
    """A male that was tried: the press closed on it, what it forms, what it misses by, the clearance to set, cold and
    before the frame yields."""

    closed: Closed
    found: Formed
    beside: WantedPart
    clearance: float

    @property
    def step(self) -> CompensationStep:
        return CompensationStep(worst_mm=self.beside.worst_mm, rms_mm=self.beside.rms_mm)


def compensate(
    job: Job,
    model: Model,
    closed: Closed,
    setting: Setting,
    wanted: Wanted,
    first: WantedPart,
    advance: Callable[[float], None],
) -> tuple[bytes, CompensationPart]:
    """Return the STL of the male that forms what is wanted, the female standing where it stands, and how it was found.

    Each vertex of the female's front has a gap of its own, and the male is the female moved in by it. What is formed
    there, less what is wanted, moves the gap by a secant step. Raises InputError where a male is undercut or cuts
    into itself.
    """
    frame = model.files.frame
    base = offset(closed.female)
    places = base.front.vertices
    gap = np.clip(wanted.at(places), *_reach(closed))
    history = [CompensationStep(worst_mm=first.worst_mm, rms_mm=first.rms_mm)]
    before: tuple[Array, Array] | None = None
    best: tuple[float, Flags, _Tried] | None = None
    stuck = np.zeros(len(places), dtype=bool)
    for turn in range(_MOST):
        advance(turn / _MOST)
        tried = _try(job, model, closed, base, setting, wanted, gap)
        history.append(tried.step)
        off, rate = _at_design(tried, wanted, len(places))
        low, high = _reach(tried.closed)
        stuck = ((gap <= low + 1e-9) & (off > _MISSED)) | ((gap >= high - 1e-9) & (off < -_MISSED))
        stuck |= (rate <= _LEAST_RATE) & (np.abs(off) > _MISSED)
        missed = float(np.abs(np.where(stuck, 0.0, off)).max())
        if best is None or missed < best[0]:
            best = missed, stuck, tried
        if missed <= _GOAL:
            break
        if before is not None:
            moved = gap - before[0]
            gained = (off - before[1]) / np.where(moved == 0.0, 1.0, moved)
            slope = np.where(np.abs(moved) > 1e-6, gained, rate)
            rate = np.clip(slope, rate, 5.0 * rate)
        before = gap, off
        step = np.where(rate > _LEAST_RATE, off / np.maximum(rate, _LEAST_RATE), 0.0)
        gap = np.clip(gap - np.clip(step, -_LONGEST, _LONGEST), low, high)
    assert best is not None
    missed, stuck, tried = best
    area = tried.closed.front.molding_areas
    of = tried.closed.front.of_mold
    mine = of < len(places)
    lost = float(area[mine][stuck[of[mine]]].sum() / area.sum())
    vertices, faces = tried.closed.case.male.vertices, tried.closed.case.male.faces
    front_gap = tried.closed.contact.gap[area > 0.0]
    return stl_bytes(frame.outward(vertices), faces), CompensationPart(
        converged=missed <= _GOAL and lost == 0.0,
        iterations=len(history) - 2,
        history=history,
        wanted=tried.beside,
        clearance_to_set_mm=tried.clearance,
        gap_min_mm=float(front_gap.min()),
        gap_max_mm=float(front_gap.max()),
        facets=len(faces),
        unreached_area_fraction=lost,
    )


def _reach(closed: Closed) -> tuple[float, float]:
    """Return the least and the greatest gap [mm] that mean anything: foam at the end of its law, and untouched."""
    sandwich = closed.press.sandwich
    foam, fabric = float(np.min(sandwich.foam)), float(np.max(sandwich.fabric))
    return fabric + foam * (1.0 - min(float(np.min(sandwich.law.limit)), 0.95)), float(np.max(sandwich.thickness))


def _try(job: Job, model: Model, closed: Closed, base: Offset, setting: Setting, wanted: Wanted, gap: Array) -> _Tried:
    """Close the press on the male that leaves ``gap`` (n,) [mm] to the female where it stands; form the sandwich."""
    from scipy.spatial import cKDTree

    growth, frame = model.grown[0].growth, model.files.frame
    _, male, to_set = _male(closed, base, frame, gap, growth)
    nearest = np.asarray(cKDTree(closed.case.male.vertices).query(male.vertices)[1], dtype=np.int64)
    carried = closed.case.sandwich.of_vertices(nearest) if closed.case.sandwich.uneven else closed.case.sandwich
    case = replace(
        closed.case,
        male=male,
        male_growth=growth.at(male.vertices),
        sandwich=carried,
        gap=to_set,
        force=None,
        zero_hot=False,
        frame=None,
    )
    uneven, thinned = model.files.uneven, model.files.thinned
    files = replace(
        model.files,
        uneven=uneven[nearest] if isinstance(uneven, np.ndarray) else uneven,
        thinned=None if thinned is None else (thinned[0][nearest], thinned[1][nearest]),
    )
    there = replace(model, closing=case, files=files)
    again = settled(job, there)
    assert model.case.dwell is not None
    found = formed(setting, column_of(job, there, again), model.case.dwell, again)
    if closed.case.frame is not None:
        to_set -= again.contact.closing_force / closed.case.frame
    return _Tried(again, found, wanted.beside(found, again, frame), to_set)


def _at_design(tried: _Tried, wanted: Wanted, count: int) -> tuple[Array, Array]:
    """Return formed less wanted (n,) [mm] at the design's vertices, 0 where none mold, and the share that sets."""
    of = tried.closed.front.of_mold
    mine = of < count
    off, rate = np.zeros(count), np.zeros(count)
    off[of[mine]] = (tried.found.thickness - wanted.at(tried.closed.cold))[mine]
    rate[of[mine]] = tried.found.share[mine]
    return off, rate
