"""What to change first: how the gap answers to each setting of the job."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hyperfab.arrays import Array


@dataclass(frozen=True)
class Lever:
    """One thing that could be changed.

    ``unit`` is the unit its ``rms`` and ``at_closest`` [mm per unit] are for: how much the gap changes over the
    molding surface, and where the molds are closest (negative: the gap closes). ``step`` is a change as shops make
    or suffer it, in that unit; levers are ranked by what such a step does.
    """

    name: str
    unit: str
    step: float
    rms: float
    at_closest: float

    @property
    def step_rms(self) -> float:
        """Change of the gap [mm] by the typical step."""
        return self.rms * self.step


@dataclass(frozen=True)
class Tooling:
    """What the levers act on, at n points of the hot male: ``points``, their ``gap`` (n,) [mm] and ``direction``
    (n, 3), the gap's gradient; ``area`` (n,) [mm^2]; ``closest``, the point with the least gap; ``pivot`` (3,) [mm] of
    tilt; for each mold its ``fixed`` point (3,) [mm], expansion per kelvin ``rate`` [1/K] and present thermal
    ``strain``."""

    points: Array
    gap: Array
    direction: Array
    area: Array
    closest: int
    pivot: Array
    male_fixed: Array
    female_fixed: Array
    male_rate: float
    female_rate: float
    male_strain: float
    female_strain: float


def levers(tool: Tooling) -> list[Lever]:
    """Return the levers, the strongest first.

    All follow from the gradient of the nearest gap: where the male's point moves by u against the point of the female
    that is nearest, the gap changes by direction . u; so no gap is measured again.
    """
    along_x, along_y, up = np.eye(3)
    arm = tool.points - tool.pivot
    degree = np.radians(1.0)
    from_male = tool.points - tool.male_fixed
    from_female = tool.points - tool.gap[:, None] * tool.direction - tool.female_fixed
    moves: list[tuple[str, str, float, Array]] = [
        ("stroke", "mm", 0.1, np.broadcast_to(up, arm.shape)),
        ("shift of the female across, first axis", "mm", 0.1, np.broadcast_to(-along_x, arm.shape)),
        ("shift of the female across, second axis", "mm", 0.1, np.broadcast_to(-along_y, arm.shape)),
        ("tilt of the female about the first axis", "deg", 0.05, -degree * np.cross(along_x, arm)),
        ("tilt of the female about the second axis", "deg", 0.05, -degree * np.cross(along_y, arm)),
        ("temperature of the female alone", "K", 10.0, -tool.female_rate * from_female),
        ("temperature of the male alone", "K", 10.0, tool.male_rate * from_male),
        (
            "height of the male's mounting face",
            "mm",
            10.0,
            -tool.male_strain * np.broadcast_to(up, arm.shape),
        ),
        (
            "height of the female's mounting face",
            "mm",
            10.0,
            tool.female_strain * np.broadcast_to(up, arm.shape),
        ),
    ]
    found = [_lever(name, unit, step, (tool.direction * move).sum(axis=1), tool) for name, unit, step, move in moves]
    # Foam does not move the molds; what it changes is the room left in the gap.
    found.append(Lever("foam thickness", "mm", 0.1, 1.0, -1.0))
    return sorted(found, key=lambda lever: -lever.step_rms)


def _lever(name: str, unit: str, step: float, change: Array, tool: Tooling) -> Lever:
    rms = float(np.sqrt(np.average(change**2, weights=tool.area)))
    return Lever(name, unit, step, rms, float(change[tool.closest]))
