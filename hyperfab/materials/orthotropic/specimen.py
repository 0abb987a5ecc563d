"""What test specimens cut at an angle answer: strips free to contract and to shear, held strips, biaxial squares.

A specimen's first axis t lies at an angle from the warp, n across it; C = Ctt tt + Cnn nn + Ctn (tn + nt).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from hyperfab.arrays import Array, Flags
from hyperfab.materials.material import Uniaxial
from hyperfab.materials.orthotropic.energy import Answer, Orthotropic, Room, answer_at, least_modulus, make_room
from hyperfab.numerics.kernels import kernel, part

_STEPS, _HALVINGS = 60, 30
#: Residual stress across a strip, over the stress along it, that counts as none, and that an equilibrium may keep
#: where the next step no longer lessens it.
_CLOSED, _KEPT = 1e-12, 1e-9


@dataclass(frozen=True)
class Frame:
    """The specimen's axes: rows (n, 3) that take S = (S11, S22, S12) to S:tt, S:nn, S:(tn + nt)."""

    tt: Array
    nn: Array
    tn: Array

    @classmethod
    def at(cls, angle_deg: ArrayLike) -> Frame:
        """Return the axes of specimens cut at angles (n,) [deg] from the warp."""
        angle = np.deg2rad(np.asarray(angle_deg, dtype=np.float64))
        c, s = np.cos(angle), np.sin(angle)
        # Quarter turns exactly: a specimen along the weft feels no rounding of the warp.
        c, s = np.where(np.abs(c) < 1e-15, 0.0, c), np.where(np.abs(s) < 1e-15, 0.0, s)
        return cls(
            np.stack([c * c, s * s, 2.0 * c * s], axis=-1),
            np.stack([s * s, c * c, -2.0 * c * s], axis=-1),
            np.stack([-2.0 * c * s, 2.0 * c * s, 2.0 * (c * c - s * s)], axis=-1),
        )

    @cached_property
    def axes(self) -> Array:
        """All three, (3, n, 3)."""
        return np.stack([self.tt, self.nn, self.tn])

    def strain(self, along: Array, across: Array, shear: Array) -> Array:
        """Return C11, C22, C12 (n, 3) of Ctt, Cnn, Ctn (n,)."""
        doubled = along[:, None] * self.tt + across[:, None] * self.nn + shear[:, None] * self.tn
        return doubled * np.array([1.0, 1.0, 0.5])


@dataclass(frozen=True)
class Strip:
    """A strip pulled along t, stress-free across: ``stretch`` (n,) along, nominal ``stress`` and its slope [MPa].

    ``frame`` holds its axes; ``width`` is the lateral stretch, ``shear`` the sine of the angle by which t and n leave
    the right one; ``strain`` (n, 3) and ``answer`` are the state in the sheet's axes; ``closed`` says where an
    equilibrium was found.
    """

    frame: Frame
    stretch: Array
    stress: Array
    slope: Array
    width: Array
    shear: Array
    strain: Array
    answer: Answer
    closed: Flags


def strip(law: Orthotropic, angle_deg: ArrayLike, stretch: ArrayLike, near: Strip | None = None) -> Strip:
    """Return the uniaxial test of strips cut at ``angle_deg`` from the warp, pulled to ``stretch`` (n,).

    The strip is uniform and free to contract and to shear (coupled shear of an off-axis pull); clamped ends are not
    followed. ``near`` is an equilibrium of strips cut alike, at about these stretches, to begin from.

    >>> law = Orthotropic.of({"C10_MPa": 0.5})
    >>> float(strip(law, 30.0, [4.0]).width[0].round(12))
    0.5
    """
    # One that may be written to, as the build has compiled the kernel for: for any other it would be compiled anew.
    lam = np.require(np.atleast_1d(stretch), np.float64, ["C", "W"])
    if near is not None:
        frame, y = near.frame, np.stack([near.width**2, near.shear * lam * near.width], axis=1)
    else:
        frame = Frame.at(np.broadcast_to(np.asarray(angle_deg, dtype=np.float64), lam.shape))
        y = np.stack([lam ** (-2.0 * law.parameters["nu"]), np.zeros_like(lam)], axis=1)

    found = Answer(np.zeros(len(lam)), np.zeros((len(lam), 3)), np.zeros((len(lam), 3, 3)))
    C, g = np.empty((len(lam), 3)), np.empty((len(lam), 2))
    _settle(lam, frame.axes, law.vector, y, C, found.energy, found.stress, found.stiffness, g)
    axes = frame.axes.transpose(1, 0, 2)
    along = np.einsum("nj,nj->n", frame.tt, found.stress)
    with np.errstate(all="ignore"):
        turned = axes @ found.stiffness @ axes.transpose(0, 2, 1)
        own, B, H = turned[:, 0, 0], turned[:, 1:, 0], turned[:, 1:, 1:]
        reduced = own - np.sum(B * solved(H, B), axis=1)
        closed = np.abs(g).max(axis=1) <= _KEPT * (np.abs(along) + 1e-3 * np.abs(own))
        shear = y[:, 1] / (lam * np.sqrt(y[:, 0]))
    return Strip(
        frame, lam, lam * along, along + lam**2 * reduced, np.sqrt(y[:, 0]), shear, C, found, np.asarray(closed)
    )


@dataclass(frozen=True)
class Along:
    """The law seen by strips cut at one angle [deg] from the warp."""

    law: Orthotropic
    angle_deg: float

    def uniaxial(self, stretch: ArrayLike) -> Uniaxial:
        """Return energy, nominal stress and its slope [MPa] of strips pulled to ``stretch``; nan where none is."""
        with np.errstate(all="ignore"):
            found = strip(self.law, self.angle_deg, stretch)
        there = np.where(found.closed, 1.0, np.nan)
        return Uniaxial(found.answer.energy * there, found.stress * there, found.slope * there)


def held(law: Orthotropic, angle_deg: ArrayLike, first: Array, second: Array) -> tuple[Array, Array, Array]:
    """Return both nominal stresses and the energy [MPa] (n,) of a square cut at an angle, ``first`` by ``second`` long.

    The edges stay at right angles: a wide strip (``second`` 1), an equal or general biaxial test.
    """
    frame = Frame.at(np.broadcast_to(np.asarray(angle_deg, dtype=np.float64), first.shape))
    found = law.answer(frame.strain(first**2, second**2, np.zeros_like(first)))
    along, across = (np.einsum("nj,nj->n", axis, found.stress) for axis in (frame.tt, frame.nn))
    return first * along, second * across, found.energy


@kernel
def _settle(
    lam: Array,
    axes: Array,
    constants: Array,
    y: Array,
    C: Array,
    energy: Array,
    stress: Array,
    stiffness: Array,
    g: Array,
) -> None:
    """Let strips at ``lam`` (n,) come to rest: ``y`` (n, 2), the strain across and in shear, by Newton's method.

    ``axes`` (3, n, 3) are the frame's. The rest is where they end: the strain (n, 3) in the sheet's axes, what the law
    answers, and what is left at the edges, ``g`` (n, 2).
    """
    room = make_room()
    trial_y, trial_C, trial_g = np.empty(2), np.empty(3), np.empty(2)
    trial_S, trial_K = np.empty(3), np.empty((3, 3))
    for i in range(len(lam)):
        frame = axes[:, i]
        energy[i] = _at(lam[i], frame, constants, room, y[i], C[i], stress[i], stiffness[i], g[i])
        for _ in range(_STEPS):
            S, K = stress[i], stiffness[i]
            scale = abs(frame[0, 0] * S[0] + frame[0, 1] * S[1] + frame[0, 2] * S[2]) + abs(K[0, 0]) * 1e-3
            residual = max(abs(g[i, 0]), abs(g[i, 1]))
            if residual <= _CLOSED * scale:
                break
            spent = residual <= _KEPT * scale
            one, other = _descent(frame, K, g[i])
            rounding = 1e-15 * np.abs(K).max()
            # The energy falls along a Newton step that is short enough; the width stays positive.
            length, fine = 1.0, False
            for _ in range(_HALVINGS):
                trial_y[0], trial_y[1] = y[i, 0] + length * one, y[i, 1] + length * other
                if trial_y[0] > 0.0 and trial_y[0] * lam[i] ** 2 > trial_y[1] ** 2:
                    there = _at(lam[i], frame, constants, room, trial_y, trial_C, trial_S, trial_K, trial_g)
                    # Near the minimum, and at rest, the energy is flat to rounding: less stress at the edges counts.
                    flat = abs(there - energy[i]) <= 1e-9 * abs(energy[i]) + rounding
                    left = max(abs(trial_g[0]), abs(trial_g[1])) / residual
                    fine = (there < energy[i] or (flat and left < 1.0)) and (left < 0.5 or not spent)
                if fine or spent:
                    break
                length *= 0.5
            if not fine:  # where no step helps, rounding has the last word
                break
            y[i], C[i], g[i] = trial_y, trial_C, trial_g
            energy[i], stress[i], stiffness[i] = there, trial_S, trial_K


@part
def _at(
    lam: float, frame: Array, constants: Array, room: Room, y: Array, C: Array, S: Array, K: Array, g: Array
) -> float:
    """Strain (3,), stress (3,), stiffness (3, 3) and what is left at the edges (2,) of a strip; its energy."""
    for k in range(3):
        C[k] = lam * lam * frame[0, k] + y[0] * frame[1, k] + y[1] * frame[2, k]
    C[2] *= 0.5
    energy = answer_at(C, constants, room, S, K)
    for k in range(2):
        g[k] = 0.5 * (frame[k + 1, 0] * S[0] + frame[k + 1, 1] * S[1] + frame[k + 1, 2] * S[2])
    return energy


@part
def _descent(frame: Array, K: Array, g: Array) -> tuple[float, float]:
    """Newton's step with a Hessian (2, 2) made positive definite where it is not."""
    a, b, d = 0.0, 0.0, 0.0
    for j in range(3):
        for k in range(3):
            a += 0.25 * frame[1, j] * K[j, k] * frame[1, k]
            b += 0.25 * frame[1, j] * K[j, k] * frame[2, k]
            d += 0.25 * frame[2, j] * K[j, k] * frame[2, k]
    mean = 0.5 * (a + d)
    radius = np.hypot(0.5 * (a - d), b)
    low = mean - radius
    if low < 1e-8 * (mean + radius):
        add = 1e-3 * (abs(mean) + radius) - low
        a, d = a + add, d + add
    det = a * d - b * b
    if det == 0.0:
        return 0.0, 0.0
    return -(g[0] * d - b * g[1]) / det, -(a * g[1] - g[0] * b) / det


def solved(H: Array, b: Array) -> Array:
    """Solve 2 x 2 systems (n, 2, 2), (n, 2); zero where one is singular."""
    det = H[:, 0, 0] * H[:, 1, 1] - H[:, 0, 1] * H[:, 1, 0]
    det = np.where(det == 0.0, np.inf, det)
    one = (b[:, 0] * H[:, 1, 1] - H[:, 0, 1] * b[:, 1]) / det
    two = (H[:, 0, 0] * b[:, 1] - b[:, 0] * H[:, 1, 0]) / det
    return np.stack([one, two], axis=1)


def stress(
    law: Orthotropic, mode: str, angle_deg: float, stretch: Array, stretch2: Array | None = None
) -> tuple[Array, Array | None, Array | None]:
    """Return the nominal stresses [MPa] along and across a test, and the lateral stretch where it is free.

    ``mode`` is uniaxial, shear (a wide strip), biaxial or biaxial-general, where ``stretch2`` is the second axis's.
    No number where the specimen has no equilibrium.
    """
    if mode == "uniaxial":
        pulled = strip(law, angle_deg, stretch)
        return (
            np.where(pulled.closed, pulled.stress, np.nan),
            None,
            np.where(pulled.closed, pulled.width, np.nan),
        )
    if mode == "shear":
        return held(law, angle_deg, stretch, np.ones_like(stretch))[0], None, None
    across = stretch if mode == "biaxial" or stretch2 is None else stretch2
    return (*held(law, angle_deg, stretch, across)[:2], None)


def stable_range(
    law: Orthotropic, mode: str, angle_deg: float, highest: float
) -> tuple[float, float, Literal["instability", "scan"]]:
    """Return the stretches from 1, at most ``highest``, over which a test is Drucker-stable, and what ends them.

    >>> stable_range(Orthotropic.of({"C10_MPa": 0.2}), "biaxial", 0.0, 3.0)
    (1.0, 3.0, 'scan')
    """
    lam = np.linspace(1.0, max(highest, 1.01), 200)
    if mode == "uniaxial":
        strain = strip(law, angle_deg, lam).strain
    else:
        across = np.ones_like(lam) if mode == "shear" else lam
        strain = Frame.at(np.full(len(lam), angle_deg)).strain(lam**2, across**2, np.zeros_like(lam))
    bad = ~(least_modulus(law.answer(strain), strain) > 0.0)
    if not bad.any():
        return 1.0, float(lam[-1]), "scan"
    return 1.0, float(lam[max(int(np.argmax(bad)) - 1, 0)]), "instability"
