"""`hf fabric-contact`, a sphere pushed into a clamped sheet: read, check, press, judge, write."""

from __future__ import annotations

import os
from collections.abc import Sequence

import numpy as np

from hyperfab.cases.contact import ContactCase
from hyperfab.chapters.fabric import per_width
from hyperfab.chapters.fabric_contact import nearby
from hyperfab.chapters.fabric_contact.fields import picture, vtu
from hyperfab.chapters.fabric_contact.result import Tested, compared, document, mounted_row, row
from hyperfab.chapters.fabric_contact.setup import Setup, read_geometry, setup_of
from hyperfab.chapters.job import Job
from hyperfab.chapters.sheet import Fabric, read_fabric
from hyperfab.chapters.uncertainty.carry import Sure, carry
from hyperfab.errors import InputError, NotConverged
from hyperfab.io.csv_write import csv_bytes
from hyperfab.io.output import Output
from hyperfab.membrane.equilibrium import State
from hyperfab.membrane.frame import run_on_frame
from hyperfab.membrane.friction_path import LOAD_STEPS, run_with_friction
from hyperfab.membrane.path import Path
from hyperfab.membrane.sphere_contact import Outcome
from hyperfab.membrane.sphere_contact import run as press
from hyperfab.membrane.verdict import first_instability, stress_difference
from hyperfab.numerics.threads import side_by_side


def run(job: Job, case: ContactCase) -> int:
    """Press the sphere into the sheet; return 0, or 4 where the depth was not reached or the constants are unstable."""
    out = job.opened(".vtu", ".csv", ".png")
    fabrics = _read_fabrics(job, case)
    geometry = read_geometry(job, case)
    setup = setup_of(case, geometry, fabrics[0])
    out.refuse_inputs(job.inputs)
    if case.thickness is None and fabrics[0].thickness is None:
        job.console.note(f"{case.material} states no thickness: 1 mm is taken (--thickness sets it)")
    elif fabrics[0].per_width:
        job.console.note(per_width(case.material))
    outcomes = _pressed(job, setup, fabrics)
    tested = [
        Tested(fabric, outcome, first_instability(outcome)) for fabric, outcome in zip(fabrics, outcomes, strict=True)
    ]
    found = document(setup, tested)
    if not outcomes[0].solved:
        limit = outcomes[0].path.limit
        gathers = limit is not None and limit.bands is not None
        remedy = "fit the fabric again with --stable" if gathers else "try a larger first --depth"
        raise NotConverged(tested[0].status or "no equilibrium", remedy=remedy)
    for letter, one in zip("AB", tested, strict=False):
        if one.outcome.solved:
            # A sheet that hangs slack carries nothing: its law is not asked below 1.
            fields, known = one.outcome.solved[-1].fields, one.fabric.tested
            met = np.maximum(fields.stretch, 1.0)
            stress = None if known is None else (float(fields.nominal.max()), one.fabric.strip_stress(known[1]))
            job.ranges.used("stretch", met, known=known, source=one.fabric.name, then="extrapolated", stress=stress)
        if one.status:
            job.console.warn(f"{one.fabric.name}: {one.status}")
        _table(job, letter, one)
    if found.force_error_relative and found.force_error_relative > case.tolerance:
        why, round_them = f"more than the {100.0 * case.tolerance:.2g} % asked for", ""
        if found.cut_max_mm:
            why = f"elements cut up to {found.cut_max_mm:.2g} mm into sharp edges of the punch"
            round_them = "round the edges with --edge-radius, or "
        sure_to = f"the force is sure to {100.0 * found.force_error_relative:.2g} % only"
        job.console.warn(f"{sure_to}, {why}: {round_them}choose a smaller --mesh-size")
    sure = Sure()
    if found.converged:
        sure = carry(
            job,
            case,
            found,
            lambda: nearby.origins_of(job, case),
            lambda origins: nearby.beside(job, case, geometry, outcomes[0], origins),
        )
    if out.wants_files:
        _draw(out, tested, sure)
    job.write(out, found, case)
    return NotConverged.exit_status if any(one.failed for one in tested) else 0


def _read_fabrics(job: Job, case: ContactCase) -> list[Fabric]:
    first = read_fabric(job, case.material, case.temperature, case.thickness)
    if case.against is None:
        return [first]
    thickness = case.thickness or (None if first.per_width else first.thickness)
    second = read_fabric(job, case.against, case.temperature, thickness)
    if first.per_width != second.per_width:
        one, other = (first, second) if first.per_width else (second, first)
        raise InputError(
            f"has constants per width, {other.name} those of stresses over a thickness",
            file=one.name,
            key="thickness_nominal",
            remedy="give --thickness",
        )
    return [first, second]


def _pressed(job: Job, setup: Setup, fabrics: list[Fabric]) -> list[Outcome]:
    tests = [setup.test(fabric) for fabric in fabrics]
    seen = [0]
    expected = 2 * len(tests) * (max(len(setup.depths), LOAD_STEPS) if setup.friction.remembers else len(setup.depths))
    with job.console.progress("Pressing the punch in" if setup.case.punch else "Pressing the sphere in") as advance:

        def watch(state: State) -> None:
            seen[0] += 1
            advance(min(1.0, seen[0] / expected), f"{state.depth:.3g} mm, {state.force:.3g} N")

        def followed(paths: list[Path]) -> None:
            for fabric, path in zip(fabrics, paths, strict=True):
                if path.states:
                    last = path.states[-1]
                    reached = f"force {last.force:.3g} N at {last.depth:g} mm"
                    job.console.passing(f"{fabric.name}: {reached}, before meshes fitted to the contact")

        def pressed(depths: Sequence[float]) -> list[Outcome]:
            if setup.friction.remembers:
                return run_with_friction(tests, depths, watch, followed)
            return press(tests, depths, setup.case.tolerance, watch, followed)

        if tests[0].frame:
            return run_on_frame(tests[0], setup.depths, pressed)
        return pressed(setup.depths)


def _draw(out: Output, tested: list[Tested], sure: Sure) -> None:
    outcomes = [one.outcome for one in tested]
    solved = outcomes[0].solved
    last, pair = solved[-1], compared(tested)
    difference = None if pair is None else (pair[0], stress_difference(*pair)[1])
    shown = None if difference is None or difference[0] is not last else difference[1]
    rows = [mounted_row(last), *map(row, solved)]
    field, drawn = side_by_side(
        [
            lambda: vtu(last, shown, sure.twins),
            lambda: picture(_names(tested), outcomes, difference, sure.interval("force_N")),
        ]
    )
    out.add(".vtu", field)
    out.add(".csv", csv_bytes(list(rows[0]), [[float(one[name]) for name in rows[0]] for one in rows]))
    out.add(".png", drawn)


def _names(tested: list[Tested]) -> list[str]:
    # The name alone: where a file lies on a machine has no place in a picture.
    names = [os.path.basename(one.fabric.name) for one in tested]
    return ["A: " + names[0], "B: " + names[1]] if len(names) > 1 else names


def _table(job: Job, letter: str, one: Tested) -> None:
    rows = []
    for solved in one.outcome.solved:
        found = solved.fields
        rows.append(
            [
                f"{solved.read:.4g}", f"{solved.state.force:.6g}", f"{1e-3 * solved.state.energy:.5g}",
                f"{np.max(found.stretch):.4f}", f"{np.max(found.cauchy):.4g}",
            ]
        )  # fmt: skip
    columns = ("depth [mm]", "force [N]", "energy [J]", "stretch", "stress [MPa]")
    job.console.table(f"{letter}: {one.fabric.model}, {one.fabric.name}", columns, rows)
