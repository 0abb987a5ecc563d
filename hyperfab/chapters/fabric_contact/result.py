"""From equilibria to the contact document."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass

from hyperfab.chapters.fabric_contact.fields import pressure
from hyperfab.chapters.fabric_contact.outline import is_file
from hyperfab.chapters.fabric_contact.setup import Setup
from hyperfab.chapters.sheet import Fabric
from hyperfab.documents.contact import BalancePart, ContactDocument, OtherPart, SetupPart, StabilityPart
from hyperfab.membrane.contact import Coulomb
from hyperfab.membrane.contact_edge import contact_edge
from hyperfab.membrane.measures import cut, fields, mounted_energy, wrinkled_fraction
from hyperfab.membrane.sphere_contact import Outcome, Solved
from hyperfab.membrane.verdict import Instability, stress_difference, work

#: N mm in a joule.
_JOULE = 1e-3


@dataclass(frozen=True)
class Tested:
    """A fabric, what came of its test, and where its constants are first unstable on the way; None where nowhere."""

    fabric: Fabric
    outcome: Outcome
    unstable: Instability | None

    @property
    def failed(self) -> bool:
        """Whether the depth was not reached, or the constants are unstable on the way."""
        return self.outcome.path.limit is not None or self.unstable is not None

    @property
    def status(self) -> str | None:
        """In words what stood in the way, or None."""
        words, unstable, path = [], self.unstable, self.outcome.path
        if unstable:
            words.append(
                f"the constants lose Drucker stability at {unstable.depth:.2f} mm "
                f"(stretches {unstable.stretches[0]:.3f} and {unstable.stretches[1]:.3f})"
            )
        if path.jumps:
            words.append(", ".join(f"the sheet snaps between {a:.2f} and {b:.2f} mm" for a, b in path.jumps))
        if path.limit:
            words.append(path.limit.reason)
        return "; ".join(words) or None

    @property
    def reached(self) -> float:
        """How deep the path came [mm], as the machine reads it."""
        limit, states = self.outcome.path.limit, self.outcome.path.states
        if limit is None:
            return self.outcome.solved[-1].read
        return limit.depth + (self.outcome.rough.frame * states[-1].force if states else 0.0)

    @property
    def force_depth(self) -> list[tuple[float, float]]:
        """Depths [mm] and forces [N], from none on."""
        return [(0.0, 0.0), *((solved.read, solved.state.force) for solved in self.outcome.solved)]

    @property
    def stability(self) -> StabilityPart:
        """Where the law is unstable, and where it bands."""
        unstable, limit = self.unstable, self.outcome.path.limit
        part = StabilityPart(stable=unstable is None)
        if unstable is not None:
            part.first_unstable_depth_mm = unstable.depth
            part.at_mm, part.stretches = unstable.at, unstable.stretches
        if limit is not None and limit.bands is not None:
            part.bands_depth_mm = limit.depth
            part.bands_at_mm, part.bands_stretches = limit.bands.at, limit.bands.stretches
        return part


def compared(tested: Sequence[Tested]) -> tuple[Solved, Solved] | None:
    """Return the deepest equilibria of two fabrics on one mesh; None where there are none."""
    if len(tested) < 2:
        return None
    one, other = (each.outcome.solved for each in tested)
    return next(((a, b) for a in one[::-1] for b in other[::-1] if a.press.sheet.mesh is b.press.sheet.mesh), None)


def document(setup: Setup, tested: Sequence[Tested]) -> ContactDocument:
    """Return the document of one test, or of two that are compared."""
    one, *others = tested
    outcome, limit, status = one.outcome, one.outcome.path.limit, one.status
    for other in others:
        if other.failed:  # the command ends with 4 for that alone
            beside = f"{other.fabric.name}: {other.status}"
            status = f"{status}; {beside}" if status else beside
    total = outcome.path.iterations
    presses = [outcome.rough, *(solved.press for solved in outcome.solved)]
    if not setup.friction.remembers:
        total += sum(solved.state.iterations for solved in outcome.solved)
    found = ContactDocument(
        converged=limit is None,
        status=status,
        depth_reached_mm=one.reached if any(each.failed for each in tested) else None,
        turning_point_mm=limit.turning_point if limit else None,
        newton_iterations=outcome.solved[-1].state.iterations if outcome.solved else 0,
        newton_iterations_total=total,
        unknowns=(outcome.solved[-1].press if outcome.solved else outcome.rough).sheet.mesh.unknowns,
        linear_solver=", ".join(sorted(set().union(*(press.sheet.pattern.solver.used for press in presses)))),
        force_depth=one.force_depth,
        stability=one.stability,
        setup=_setup(setup, one.fabric),
        left_out=[
            *one.fabric.left_out,
            *(f"{os.path.basename(each.fabric.name)}: {why}" for each in others for why in each.fabric.left_out),
            "weight of the sheet",
            "bending stiffness of the fabric",
            *_half_thickness(setup),
        ],
    )
    if outcome.solved:
        _add_last(found, outcome)
    for other in others:
        found.against = _against(other)
    pair = compared(tested)
    if pair is not None:
        a, b = pair
        found.compared_at_depth_mm = a.state.depth
        found.stress_difference_percent, _ = stress_difference(a, b)
        found.force_ratio = a.state.force / b.state.force if b.state.force > 0.0 else None
    return found


def _half_thickness(setup: Setup) -> list[str]:
    if setup.case.punch is not None or setup.lift > 0.0:
        return []
    half = 0.5 * setup.thickness
    share = 100.0 * half / setup.radius
    return [f"half the sheet's thickness on the sphere: {half:g} mm, {share:.2g} % of its radius (--middle-surface)"]


def mounted_row(solved: Solved) -> dict[str, float]:
    """Return the first line of the CSV: the mounted sheet of an equilibrium, before the punch."""
    sheet = solved.press.sheet
    energy = stress = 0.0
    if sheet.prestretch > 1.0:
        energy = _JOULE * mounted_energy(solved.press)
        stress = float(fields(sheet, sheet.flat).cauchy.max())
    return {
        "depth_mm": 0.0, "force_N": 0.0, "energy_J": energy, "contact_radius_mm": 0.0,
        "stretch_max": sheet.prestretch, "stress_max_MPa": stress,
    }  # fmt: skip


def row(solved: Solved) -> dict[str, float]:
    """Return one line of the CSV."""
    smooth = solved.fields
    edge = contact_edge(solved.press, solved.state, deformed=True)
    return {
        "depth_mm": solved.read,
        "force_N": solved.state.force,
        "energy_J": _JOULE * solved.state.energy,
        "contact_radius_mm": edge.mean if edge else 0.0,
        "stretch_max": float(smooth.stretch.max()),
        "stress_max_MPa": float(smooth.cauchy.max()),
    }


def _add_last(found: ContactDocument, outcome: Outcome) -> None:
    """Fill in what is known at the last depth."""
    last = outcome.solved[-1]
    sheet, state = last.press.sheet, last.state
    smooth = last.fields
    for name, value in row(last).items():
        if name != "depth_mm":
            setattr(found, name, value)
    found.punch_depth_mm = state.depth if last.press.frame else None
    found.force_error_relative = last.error
    found.pressure_max_MPa = float(pressure(last, smooth.cauchy, smooth.thickness).max())
    found.stress_nominal_max_MPa = float(smooth.nominal.max())
    found.wrinkled_area_fraction = wrinkled_fraction(sheet, state.places)
    edge = contact_edge(last.press, state, deformed=False)
    found.contact_radius_undeformed_mm = edge.mean if edge else 0.0
    stored = state.energy - mounted_energy(last.press)
    done = work(outcome)
    lost = sheet.mesh.copies * state.memory.dissipated
    found.force_extrapolated_N = outcome.extrapolated
    # A sheet that is slack to the end stores and costs nothing but rounding.
    pulls = state.force > 0.0
    found.balance = BalancePart(
        work_J=_JOULE * done,
        stored_J=_JOULE * stored,
        dissipated_J=_JOULE * lost,
        imbalance_relative=(done - stored - lost) / stored if pulls and stored > 0.0 else 0.0,
        reaction_N=state.reaction,
        force_imbalance_relative=(state.reaction - state.force) / state.force if pulls else 0.0,
    )
    deep = cut(last.press, state)
    if deep > 0.0 and pulls:
        # Two meshes may cut alike: the force is no surer than its balance, and than three times the part of the
        # depth that is cut off (it grows as the third power at first).
        found.cut_max_mm = deep
        found.force_error_relative = max(
            last.error or 0.0, abs(found.balance.imbalance_relative), 3.0 * deep / state.depth
        )


def _against(other: Tested) -> OtherPart:
    part = OtherPart(
        model=other.fabric.model,
        converged=other.outcome.path.limit is None,
        status=other.status,
        depth_reached_mm=other.reached if other.failed else None,
        force_depth=other.force_depth,
        stability=other.stability,
    )
    if other.outcome.solved:
        last = other.outcome.solved[-1]
        smooth = last.fields
        part.force_N = last.state.force
        part.stretch_max, part.stress_max_MPa = float(smooth.stretch.max()), float(smooth.cauchy.max())
    return part


def _setup(setup: Setup, fabric: Fabric) -> SetupPart:
    case, law, punch = setup.case, setup.friction, setup.geometry.facets
    coulomb = f"Coulomb {law.coefficient:g}" if isinstance(law, Coulomb) else "stick"
    return SetupPart(
        model=fabric.model,
        fabric=fabric.words,
        shape=os.path.basename(case.shape),
        size_mm=setup.geometry.width,
        thickness_mm=setup.thickness,
        area_mm2=setup.outline.area if is_file(case.shape) else None,
        sphere_radius_mm=None if punch else setup.radius,
        punch=None if case.punch is None else os.path.basename(case.punch),
        punch_facets=len(punch.surface.faces) if punch else None,
        depth_mm=setup.depths[-1],
        prestretch=case.prestretch,
        rim_slip_mm2_N=case.rim_slip or None,
        frame_stiffness_N_mm=case.frame_stiffness,
        temperature_degC=fabric.temperature,
        constants_degC=fabric.held_at,
        effects=fabric.obeyed or None,
        friction=coulomb if law.remembers else "frictionless",
        mesh_size_mm=setup.mesh_size,
        elements=case.element + (", a quarter of the sheet" if setup.outline.quarter else ""),
    )
