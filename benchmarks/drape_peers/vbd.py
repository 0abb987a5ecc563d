"""Newton's vertex block descent on the same sheet: ``vbd.py PROBLEM.npz FOUND.npz DT ITERATIONS DAMPING SECONDS``.

Springs are linear and push as well as pull; the mold is met by a penalty (``KE``, the stiffest that still settles);
single precision. Velocities are damped by a factor a step, so that the sheet comes to rest instead of swinging on.
"""

import sys
import time

import newton
import numpy as np
import warp as wp

KE = 1000.0  # N/mm, a thousand times a spring's stiffness
MASS = 1.0


def model_of(problem):
    """Particles, springs and the mold as a static mesh; two colours, as on a chessboard (color() knows no springs)."""
    builder = newton.ModelBuilder(gravity=(0.0, 0.0, 0.0))
    x, fixed, springs = problem["x"], problem["fixed"], problem["springs"]
    builder.add_particles(
        [tuple(p) for p in x],
        [(0.0, 0.0, 0.0)] * len(x),
        [0.0 if held else MASS for held in fixed],
        [0.0] * len(x),
    )
    builder.spring_indices.extend(springs.ravel().tolist())
    builder.spring_stiffness.extend(problem["stiffness"].tolist())
    builder.spring_damping.extend([0.0] * len(springs))
    builder.spring_control.extend([0.0] * len(springs))
    builder.spring_rest_length.extend(problem["rest"].tolist())
    mesh = newton.Mesh(problem["vertices"].astype(np.float32), problem["faces"].astype(np.int32).ravel())
    builder.add_shape_mesh(-1, mesh=mesh, cfg=newton.ModelBuilder.ShapeConfig(ke=KE, kd=0.0, mu=0.0))
    i, j = np.divmod(np.arange(len(x)), int(problem["n"]))
    builder.set_coloring([np.flatnonzero((i + j) % 2 == k) for k in range(2)])
    model = builder.finalize(device="cpu")
    model.soft_contact_ke, model.soft_contact_kd, model.soft_contact_mu = KE, 0.0, 0.0
    return model


def main():
    path, out, *numbers = sys.argv[1:]
    dt, iterations, damping, seconds = (float(text) for text in numbers)
    problem = np.load(path)
    model = model_of(problem)
    solver = newton.solvers.SolverVBD(model, iterations=int(iterations), particle_enable_tile_solve=False)
    pipeline = newton.CollisionPipeline(model, soft_contact_gap=1.0)
    contacts, control = pipeline.contacts(), model.control()
    now, after = model.state(), model.state()

    def step():
        nonlocal now, after
        now.clear_forces()
        pipeline.collide(now, contacts)
        solver.step(now, after, control, contacts, dt)
        now, after = after, now
        now.particle_qd.numpy()[:] *= damping  # shares its memory on the CPU

    step()  # compiles
    now.particle_q.assign(problem["x"].astype(np.float32))
    now.particle_qd.zero_()
    spent, line, best, kept = 0.0, [], np.inf, None
    while spent < seconds:
        start = time.process_time()
        for _ in range(10):
            step()
        spent += time.process_time() - start
        x = now.particle_q.numpy().astype(float)
        error = np.sqrt(((x - problem["reference"]) ** 2).sum(1).mean())
        line.append((spent, error))
        if error < best:
            best, kept = error, x
    np.savez(out, line=line, x=kept)
    print(f"Newton {newton.__version__}, Warp {wp.__version__}")


if __name__ == "__main__":
    wp.config.quiet = True
    main()
