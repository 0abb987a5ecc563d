"""What is asked of ``hf close-loop``."""

from __future__ import annotations

from dataclasses import dataclass

from hyperfab.cases.field import amount, file, flag, setting, text, texts
from hyperfab.cases.field import files as several
from hyperfab.cases.kinds import File, Many
from hyperfab.cases.reading import ReadingCase

#: In the place of a file of --hold-out: each test in turn.
AUTO = "auto"


@dataclass(frozen=True, kw_only=True)
class LoopCase(ReadingCase):
    """Compare a model with measured data, find the effect it lacks, and add it where the data are sure.

    \b
    Example:
      hf close-loop fabric.json specimens/lycra/warp-23C.csv specimens/lycra/weft-23C.csv -o loop.json
    """

    COMMAND = "close-loop"
    KIND = "loop"

    model: str = file(
        "MODEL",
        "A material, contact, drape or press document, a mold.toml, or -.",
        argument=True,
        required=True,
    )
    files: tuple[str, ...] = several(
        "[FILE]...", "Measured data that say themselves what they are (CSV, .xlsx).", argument=True
    )
    measured: tuple[str, ...] = several("CSV", "Measured data; repeat for more files.")
    uniaxial: tuple[str, ...] = several("CSV", "Uniaxial test of a fabric that does not say so.")
    shear: tuple[str, ...] = several("CSV", "Planar shear test of a fabric.")
    biaxial: tuple[str, ...] = several("CSV", "Biaxial test of a fabric.")
    hold_out: tuple[str, ...] = setting(
        Many(File((AUTO,))),
        "CSV",
        "Data that take no part and are predicted; auto leaves out test by test.",
        [AUTO],
    )
    noise: str | None = text(
        "SIZE", "Standard deviation of a reading, as 0.002MPa, 0.5N or 0.2mm; estimated where not given."
    )
    fix: tuple[str, ...] = texts("KEY", "Hold a constant of the model.")
    prior: float | None = amount(
        "dimensionless", "SHARE", "Standard deviation of the model's own constants, as 10%; else they are free.",
        example="10%, at most 100%", above=0.0, most=1.0,
    )  # fmt: skip

    upstream: bool = flag(
        "Also trace the misfit of a press or a drape to the documents behind it: which is off, and put right."
    )

    @property
    def readings(self) -> list[str]:
        """All measured files that take part."""
        return [*self.files, *self.measured, *self.uniaxial, *self.shear, *self.biaxial]

    @property
    def held(self) -> list[str]:
        """The files of ``--hold-out``; ``auto`` is none."""
        return [name for name in self.hold_out if name != AUTO]
