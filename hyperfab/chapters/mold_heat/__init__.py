"""``hf mold-heat``: the warm-up of a heated mold."""

from hyperfab.cases.mold import MoldCase
from hyperfab.chapters.job import Job
from hyperfab.thermal import netgen_process


def run(job: Job, case: MoldCase) -> int:
    """Heat the mold of the case; 0, or 4 where the account of heat does not close."""
    netgen_process.begin()  # it imports while this process does
    try:
        from hyperfab.chapters.mold_heat import recipe

        return recipe.run(job, case)
    finally:
        netgen_process.end()
