"""``hf mold-heat``: the warm-up of a heated mold."""

from hyperfab.cases.mold import MoldCase
from hyperfab.chapters.job import Job
from hyperfab.thermal import netgen_process


def run(job: Job, case: MoldCase) -> int:
    """Heat the mold of the case; 0, or 4 where the account of heat does not close."""
    netgen_process.begin()  # it imports while this process reads
    try:
        from hyperfab.chapters.mold_heat.meshing import geometry_of
        from hyperfab.documents.base import read_document
        from hyperfab.documents.mold import MoldDocument
        from hyperfab.thermal.mesher import begin_mesh

        document = read_document(job.inputs, case.mold, MoldDocument)
        if not document.surfaces():  # these are judged, mended and made coarser first
            begin_mesh(geometry_of(document, case.mold, job.inputs, "mm", []), document.run.mesh_size)
        from hyperfab.chapters.mold_heat import recipe  # a second to load: the mesher is at work meanwhile

        return recipe.run(job, case, document)
    finally:
        netgen_process.end()
