"""The sphere on the disc by FElupe: linear hexahedra, one thin layer on a quarter of the disc.

    python with_felupe.py CELLS SOLVER

The sheet is a tenth as thick and ten times as stiff as the one meant, so that bending and the height of the face that
touches count for little. SOLVER is scipy or pardiso. Prints one line of JSON: seconds of CPU after import.
"""

from __future__ import annotations

import json
import sys
import time

import felupe
import numpy as np
from scipy.sparse.linalg import spsolve

THICKNESS, MU, RADIUS, SPHERE, DEPTH, STEPS = 0.1, 4.0, 100.0, 40.0, 60.0, 8
#: Bulk over shear modulus: plane stress hardly notices more.
BULK = 500.0
#: Largest part of a load step taken at once before it is halved, and the least one.
MOST_HALVINGS = 8


class Sphere(felupe.mechanics.ContactRigidBase):
    """Nodes against a rigid sphere, by a penalty."""

    def __init__(self, field, points, centerpoint, radius, **settings):
        self.radius = radius
        super().__init__(field, points, centerpoint, **settings)

    def _kinematics(self, dx):
        distance = np.linalg.norm(dx, axis=1)
        normal = dx / distance[:, None]
        turning = (np.eye(3) - normal[:, :, None] * normal[:, None, :]) / distance[:, None, None]
        return distance - self.radius, normal, turning


def quarter(cells: int) -> felupe.Mesh:
    """Return hexahedra on a quarter of the disc: a square grid drawn out to the circle."""
    square = felupe.Rectangle(b=(1.0, 1.0), n=cells + 1)
    x, y = square.points.T
    reach = np.maximum(x, y)
    share = np.divide(np.minimum(x, y), reach, out=np.zeros_like(x), where=reach > 0)
    angle = np.where(x >= y, np.pi / 4 * share, np.pi / 2 - np.pi / 4 * share)
    points = RADIUS * reach[:, None] * np.column_stack([np.cos(angle), np.sin(angle)])
    return felupe.mesh.expand(felupe.Mesh(points, square.cells, "quad"), n=2, z=THICKNESS)


def main() -> None:
    """Push the sphere in and print what came out."""
    cells, name = int(sys.argv[1]), sys.argv[2]
    if name == "pardiso":
        from pypardiso import spsolve as solver
    else:
        solver = spsolve
    began = time.process_time()
    mesh = quarter(cells)
    mesh.add_points([0.0, 0.0, -SPHERE])
    field = felupe.FieldContainer([felupe.Field(felupe.RegionHexahedron(mesh), dim=3)])
    solid = felupe.SolidBodyNearlyIncompressible(felupe.NeoHooke(mu=MU), field, bulk=BULK * MU)
    x, y, z = mesh.points.T
    inside = np.arange(mesh.npoints) < mesh.npoints - 1
    below = np.flatnonzero(inside & (z == 0) & (np.hypot(x, y) < 1.2 * SPHERE))
    contact = Sphere(field, below, -1, SPHERE, items=[solid], multiplier=1e-3)
    rim = inside & (np.hypot(x, y) > RADIUS * (1 - 1e-9))
    centre = ~inside
    displacement = field[0]
    bounds = {
        "rim": felupe.Boundary(displacement, mask=rim),
        "x": felupe.Boundary(displacement, mask=inside & (x < 1e-9) & ~rim, skip=(0, 1, 1)),
        "y": felupe.Boundary(displacement, mask=inside & (y < 1e-9) & ~rim, skip=(1, 0, 1)),
        "centre": felupe.Boundary(displacement, mask=centre, skip=(0, 0, 1)),
        "push": felupe.Boundary(displacement, mask=centre, skip=(1, 1, 0)),
    }
    iterations, here, step = 0, 0.0, DEPTH / STEPS
    dof0, dof1 = felupe.dof.partition(field, bounds)
    while here < DEPTH - 1e-9:
        bounds["push"].update(min(here + step, DEPTH))
        ext0 = felupe.dof.apply(field, bounds, dof0)
        saved = displacement.values.copy()
        points = solid.checkpoint(), contact.checkpoint()
        try:
            found = felupe.newtonraphson(
                items=[solid, contact], dof0=dof0, dof1=dof1, ext0=ext0, solver=solver, tol=1e-6, verbose=0,
                maxiter=30,
            )  # fmt: skip
        except (ValueError, np.linalg.LinAlgError):
            displacement.values[:] = saved
            solid.restore(points[0])
            contact.restore(points[1])
            step *= 0.5
            if step < DEPTH / STEPS / 2**MOST_HALVINGS:
                raise
            continue
        iterations += found.iterations
        here = min(here + step, DEPTH)
        step = min(2 * step, DEPTH / STEPS)
    # The rim's reaction: the contact's own vector is evaluated anew, with another penalty.
    force = 4 * abs(float(solid.assemble.vector(field).toarray().reshape(-1, 3)[rim, 2].sum()))
    print(
        json.dumps(
            {
                "force_N": force,
                "seconds": time.process_time() - began,
                "unknowns": len(dof1),
                "iterations": iterations,
                "version": felupe.__version__,
            }
        )
    )


if __name__ == "__main__":
    main()
