"""Whether a sheet's equations of equilibrium are elliptic: a disturbance as short as one likes costs energy.

Where they are not, the sheet gathers its stretch in bands as narrow as its mesh allows, and no solution holds under
refinement. With the direction N in the undeformed plane, F the deformation and D the stiffness, the acoustic tensor

    Q_ij(N) = F_iA D_ABCD N_B N_D F_jC + (N . S N) delta_ij

has positive eigenvalues for all N (strong ellipticity; Knowles and Sternberg, J. Elasticity 8 (1978) 329).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hyperfab.arrays import Array, Flags
from hyperfab.membrane.sheet import Sheet
from hyperfab.membrane.tension_field import Response, SheetLaw
from hyperfab.numerics.kernels import kernel

#: Directions in half a turn that are looked at.
_DIRECTIONS = 36
#: Rounding and wrinkles leave values of this part of the modulus with either sign.
_ROUNDING = 1e-9
#: Stretches at which a law is looked at up to the furthest.
_LOOKED_AT = 400


@dataclass(frozen=True)
class Weakest:
    """Where a sheet is nearest to losing ellipticity: undeformed place [mm], principal stretches, and how near.

    ``left``: least eigenvalue of the acoustic tensor over that of the unstretched sheet; negative where it is lost.
    """

    at: tuple[float, float]
    stretches: tuple[float, float]
    left: float

    @property
    def lost(self) -> bool:
        """Whether ellipticity is lost there."""
        return self.left < -_ROUNDING


def acoustic(found: Response, strain: Array) -> Array:
    """Return the least eigenvalue (n,) [MPa] of the acoustic tensor over all directions of the plane.

    ``found`` is the law's response to the right Cauchy-Green tensors ``strain`` (n, 3): C11, C22, C12.
    """
    angle = np.pi * np.arange(_DIRECTIONS) / _DIRECTIONS
    return np.asarray(_least(found.stress, found.stiffness, strain, np.column_stack([np.cos(angle), np.sin(angle)])))


@kernel
def _least(stress: Array, stiffness: Array, strain: Array, directions: Array) -> Array:
    result = np.empty(len(strain))
    for n in range(len(strain)):
        c11, c22, c12 = strain[n, 0], strain[n, 1], strain[n, 2]
        d11, d22, d33, d12, d13, d23 = stiffness[n]
        # The root of C stands for F: a rotation of the sheet turns Q alone.
        area = np.sqrt(max(c11 * c22 - c12 * c12, 0.0))
        size = np.sqrt(c11 + c22 + 2.0 * area)
        u1, u2, u3 = (c11 + area) / size, (c22 + area) / size, c12 / size
        least = np.inf
        for k in range(len(directions)):
            c, s = directions[k, 0], directions[k, 1]
            m11 = d11 * c * c + 2.0 * d13 * c * s + d33 * s * s
            m22 = d33 * c * c + 2.0 * d23 * c * s + d22 * s * s
            m12 = d13 * c * c + (d12 + d33) * c * s + d23 * s * s
            pull = stress[n, 0] * c * c + stress[n, 1] * s * s + 2.0 * stress[n, 2] * c * s
            a1, b1 = u1 * m11 + u3 * m12, u1 * m12 + u3 * m22
            a2, b2 = u3 * m11 + u2 * m12, u3 * m12 + u2 * m22
            q11, q22, q12 = a1 * u1 + b1 * u3, a2 * u3 + b2 * u2, a1 * u3 + b1 * u2
            lower = 0.5 * (q11 + q22) - np.sqrt(0.25 * (q11 - q22) ** 2 + q12 * q12) + pull
            least = min(least, lower)
        result[n] = least
    return result


def left(law: SheetLaw, strain: Array) -> Array:
    """Return the least eigenvalue (n,) of the acoustic tensor over that of the unstretched sheet; below zero: lost."""
    flat = np.array([[1.0001, 1.0001, 0.0]])
    rest = float(acoustic(law(flat), flat)[0])
    return np.asarray(acoustic(law(strain), strain)) / rest


def lost(law: SheetLaw, strain: Array) -> Flags:
    """Return whether ellipticity is lost at each of ``strain`` (n, 3)."""
    return left(law, strain) < -_ROUNDING


def lost_from(law: SheetLaw, furthest: float) -> float | None:
    """Return the least stretch, of strips and of sheets drawn in one or both directions, at which ellipticity is lost.

    None where it is kept up to a stretch of ``furthest``.

    >>> from hyperfab.materials import bind
    >>> from hyperfab.membrane.tension_field import IsotropicSheet
    >>> foam = IsotropicSheet(bind("blatz-ko", {"mu_MPa": 0.3, "f": 0.0, "nu": 0.25}))
    >>> lost_from(foam, 3.0), lost_from(IsotropicSheet(bind("neo-hookean", {"C10_MPa": 0.3})), 3.0)
    (1.935, None)
    """
    way = np.linspace(1.0, furthest, _LOOKED_AT + 1)[1:]
    held, free = np.ones_like(way), way**-2  # so narrow that nothing is borne across
    gone = np.zeros(len(way), np.bool_)
    for one, other in ((way, held), (held, way), (way, way), (way, free), (free, way)):
        with np.errstate(all="ignore"):
            gone |= lost(law, np.column_stack([one**2, other**2, np.zeros_like(way)]))
    return float(way[np.argmax(gone)]) if gone.any() else None


def weakest(sheet: Sheet, places: Array) -> Weakest:
    """Return where a sheet at nodal ``places`` (n, 3) is nearest to losing ellipticity."""
    strain = sheet.strain(places)
    least = left(sheet.law, strain)
    point = int(np.nanargmin(least))
    stretch = sheet.law.principal(strain[[point]]).stretch[0]
    element = point // sheet.mesh.weights.shape[1]
    middle = sheet.mesh.nodes[sheet.mesh.elements[element, :3]].mean(axis=0)
    return Weakest((float(middle[0]), float(middle[1])), (float(stretch[0]), float(stretch[1])), float(least[point]))
