"""What a run has gone through."""

from __future__ import annotations

from dataclasses import dataclass, field

from hyperfab.thermal.ledger import Ledger
from hyperfab.thermal.trail import Trail


@dataclass(frozen=True)
class Reduced:
    """How much of a run was followed on a reduced mold, and how far that may be off.

    ``error`` [K] is an upper estimate at any watched place and time: what the checked stretches were off by at their
    ends, anywhere in the mold, summed over all stretches, and what they were off by on the way at watched places.
    """

    unknowns: int
    begun: float
    stretches: int
    checks: int
    error: float
    returns: int


@dataclass
class History:
    """All accepted states, the largest residual of a stage on the way [K], and the account of heat.

    ``jumps`` are the states at which a power, a schedule or a part jumped; ``reduced`` tells of a reduced mold where
    one was tried.
    """

    states: Trail
    ledger: Ledger
    residual: float = 0.0
    reached: int | None = None
    rejected: int = 0
    settled: bool = False
    switches: list[float] = field(default_factory=list)
    jumps: list[int] = field(default_factory=list)
    reduced: Reduced | None = None

    @property
    def reached_time(self) -> float | None:
        """Time at which the target was reached [s]."""
        return None if self.reached is None else self.states[self.reached].time

    def cut(self, count: int, switches: int) -> None:
        """Forget all but the first ``count`` states and what they had, the first ``switches`` among it."""
        del self.switches[switches:]
        self.jumps = [jump for jump in self.jumps if jump < count]
        self.states.cut(count)
        self.ledger.cut(count - 1)
        if self.reached is not None and self.reached >= count:
            self.reached = None
