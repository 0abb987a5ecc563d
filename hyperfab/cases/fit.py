"""What is asked of ``hf fit``."""

from __future__ import annotations

from dataclasses import dataclass

from hyperfab.cases.field import amount, choice, flag, text
from hyperfab.cases.field import files as several
from hyperfab.cases.reading import ReadingCase

#: The laws by name; the registry holds them, and its numbers take too long to load for a help page.
LAWS = (
    "alexander, arruda-boyce, arruda-boyce-langevin, arruda-boyce-lni2, blatz-ko, blatz-ko-general, carroll, "
    "extended-tube, fabric-fibres, gent, gent-gent, mooney-rivlin-2, mooney-rivlin-3, mooney-rivlin-5, "
    "mooney-rivlin-9, neo-hookean, ogden-1, ogden-2, ogden-3, yeoh-1, yeoh-2, yeoh-3, yeoh-3-lni2, "
    "orthotropic, hyperfoam-1, hyperfoam-2, hyperfoam-3."
)


@dataclass(frozen=True, kw_only=True)
class FitCase(ReadingCase):
    """Identify the constants of a strain-energy law from fabric tests (CSV).

    \b
    Example:
      hf fit --uniaxial specimens/treloar-1944/uniaxial.csv \\
             --biaxial specimens/treloar-1944/biaxial.csv --model yeoh-3 -o fabric.json
    """

    COMMAND = "fit"
    KIND = "material"

    files: tuple[str, ...] = several(
        "[FILE]...", "Tests that say themselves what they are (CSV, .xlsx).", argument=True
    )
    uniaxial: tuple[str, ...] = several("CSV", "Uniaxial test; repeat for more files.")
    shear: tuple[str, ...] = several("CSV", "Planar shear (planar tension) test.")
    biaxial: tuple[str, ...] = several("CSV", "Equibiaxial or general biaxial test.")
    volumetric: tuple[str, ...] = several("CSV", "Volumetric test.")
    model: str = text("NAME", "A strain-energy law, or all. " + LAWS, "all")
    fit_on: str | None = text("TESTS", "Tests that take part, as uniaxial,shear; the others are predicted.")
    objective: str = choice(
        "KIND", "relative (the default) or absolute least squares.", ("relative", "absolute"), "relative"
    )
    stable: bool = flag("Only constants that are Drucker-stable over the data.")
    plane: bool = flag("Check stability over all pairs of stretches too.")
    accept: float = amount(
        "dimensionless",
        "R",
        "Largest relative rms (absolute fit: NRMSE) accepted, as 0.05 or 5%.",
        "0.30",
        above=0.0,
    )
    noise: str | None = text("STRESS", "Standard deviation of a reading, as 0.002MPa.")
