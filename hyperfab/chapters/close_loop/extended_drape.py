"""The extended drape: a fabric, or laws of threads, with refitted constants, and the command that drapes it with the
terms."""

from __future__ import annotations

from hyperfab.chapters.close_loop.closing import Extension
from hyperfab.chapters.close_loop.extended_contact import FABRIC, refitted
from hyperfab.chapters.close_loop.recall import Recalled, reworded
from hyperfab.chapters.drape.effects import Effects
from hyperfab.cloth import Sheet
from hyperfab.cloth.law import SpringLaw
from hyperfab.documents.material import MaterialDocument
from hyperfab.io.json_io import dump_json
from hyperfab.io.output import Output
from hyperfab.io.units import quantity
from hyperfab.loop.drape import DrapeProblem
from hyperfab.loop.engine import Finding

#: Where the tests that are taken as laws are written.
THREADS = (".model.warp.csv", ".model.weft.csv")


def extend(
    out: Output,
    recalled: Recalled,
    material: MaterialDocument | None,
    effects: Effects,
    sheet: Sheet,
    problem: DrapeProblem,
    found: Finding,
) -> Extension:
    """Return the command of the extended drape, and the fabric it reads."""
    fit = found.after.fit
    own = {one.name: float(v) for one, v in zip(problem.own, fit.x, strict=False)}
    terms = {key: [float(v) for v in values] for key, (_, values) in fit.terms.items()}
    words: dict[str, str | None] = {}
    notes: list[str] = []
    if own["depth"] and not recalled.options.get("depths"):
        words["--depth"] = f"{quantity(recalled.options['depth'], 'length') + own['depth']!r}mm"
    if "pretension" in terms:
        warp, weft = effects.prestretch
        added = terms["pretension"]
        more = added[1] if len(added) > 1 else 0.0
        words["--prestretch"] = f"{warp + added[0]!r}x{weft + added[0] + more!r}"
    if "friction" in terms:
        words["--friction"] = repr(effects.friction + terms["friction"][0])
    if "gravity" in terms:
        words["--mass"] = f"{effects.mass + terms['gravity'][0]!r}g/m^2"
    if "shear-stiffness" in terms:
        words["--shear-modulus"] = f"{(effects.shear_modulus or 0.0) + terms['shear-stiffness'][0]!r}MPa"
        words["--shear-law"] = None
        if effects.bias is not None:
            notes.append("shear-stiffness: a modulus takes the place of the measured law of the diagonals")
    if material is None:
        laws = (_thread(sheet.warp, own["warp"]), _thread(sheet.weft, own["weft"]))
        files = dict(zip(THREADS, laws, strict=True))
        words |= {"--warp": str(out.path(THREADS[0])), "--weft": str(out.path(THREADS[1]))}
        words["--thickness"] = f"{sheet.thickness!r}mm"
        return Extension(reworded(recalled.words, words), files, notes)
    fabric = refitted(material, {name: own[name] for name in problem.draped.names})
    renamed = [
        str(out.path(FABRIC)) if word == recalled.options["material"] else word for word in recalled.words
    ]
    return Extension(reworded(renamed, words), {FABRIC: dump_json(fabric.to_json())}, notes)


def _thread(law: SpringLaw, factor: float) -> bytes:
    """Return a measured law with its stress times ``factor``, as a uniaxial test."""
    rows = ["strain [-],stress [MPa]"]
    rows += [f"{float(stretch) - 1.0!r},{factor * float(stress)!r}"
             for stretch, stress in zip(law.knots, law.pieces[:, 1], strict=True)]  # fmt: skip
    return ("\n".join(rows) + "\n").encode()
