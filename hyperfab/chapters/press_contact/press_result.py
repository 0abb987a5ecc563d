"""All that the outputs of ``hf press-contact`` tell of."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hyperfab.arrays import Array
from hyperfab.chapters.press_contact.formed import Formed, Wanted
from hyperfab.chapters.press_contact.heat import ThermalDisplacement
from hyperfab.chapters.press_contact.model import Foam, Model
from hyperfab.chapters.press_contact.warmth import Warmed
from hyperfab.documents.press import CompensationPart, DesignPart, WantedPart
from hyperfab.pressing.closing import Closed
from hyperfab.pressing.growth import Expansion
from hyperfab.pressing.mold import PressFrame


@dataclass(frozen=True)
class PressResult:
    """All that the outputs tell: the model, the closed press, its ``curve``, what the dwell does and the design."""

    model: Model
    closed: Closed
    curve: Array
    warmed: Warmed | None = None
    design: DesignPart | None = None
    formed: Formed | None = None
    wanted: Wanted | None = None
    compensation: CompensationPart | None = None

    @property
    def beside(self) -> WantedPart | None:
        """By how much what is formed misses what is wanted."""
        if self.formed is None or self.wanted is None:
            return None
        return self.wanted.beside(self.formed, self.closed, self.frame)

    @property
    def frame(self) -> PressFrame:
        """How the molds close."""
        return self.model.files.frame

    @property
    def reference(self) -> float:
        """Temperature [degC] at which the drawing holds."""
        return self.model.files.document.expansion.reference

    @property
    def expansions(self) -> tuple[Expansion, Expansion]:
        """Of the male and the female."""
        return self.model.files.expansions

    @property
    def grown(self) -> tuple[ThermalDisplacement, ThermalDisplacement]:
        """How the male and the female have grown."""
        return self.model.grown

    @property
    def foam(self) -> Foam:
        """What of the foam is lost and given back."""
        return self.model.foam

    @property
    def final_thickness(self) -> Array | None:
        """Thickness (n,) [mm] of the sandwich when the press has opened: foam springs back by its recovery."""
        if self.foam.recovery is None:
            return None
        sandwich, gap = self.closed.press.sandwich, self.closed.contact.gap
        foam = np.broadcast_to(np.asarray(sandwich.foam), gap.shape)
        pressed, _ = sandwich.pressed(gap)
        return np.asarray(sandwich.fabric + pressed + self.foam.recovery * (foam - pressed))
