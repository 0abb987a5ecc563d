"""`hf sample`: write the specimens and molds that the repository ships."""

from __future__ import annotations

from pathlib import Path

from hyperfab.cases.about import SampleCase
from hyperfab.chapters.job import Job
from hyperfab.errors import OutputError, UsageError
from hyperfab.io.atomic import write_files
from hyperfab.samples import sample_files


def run(job: Job, case: SampleCase) -> int:
    """Write every sample below the folder.

    A file that is there with the same bytes is left alone. One that differs is somebody's work: it is
    overwritten only with ``--force``, and otherwise nothing at all is written.
    """
    folder, force = case.folder, case.force
    root = Path(folder)
    if root.exists() and not root.is_dir():
        raise UsageError(f"{folder} is a file; name the folder that should take the samples")
    samples = {root / path: data for path, data in sample_files().items()}
    different = [path for path, data in samples.items() if _differs(path, data)]
    if different and not force:
        names = ", ".join(str(path) for path in different[:3]) + (", ..." if len(different) > 3 else "")
        raise UsageError(f"not the sample: {names}; choose another folder, or overwrite with --force")
    missing = [(path, data) for path, data in samples.items() if path in different or not path.exists()]
    try:
        for place in sorted({path.parent for path, _ in missing}):
            place.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise OutputError(f"{error.filename}: {error.strerror}; choose another folder") from error
    write_files(missing)
    job.console.note(f"{folder}: {len(samples)} sample files, {len(missing)} written")
    return 0


def _differs(path: Path, data: bytes) -> bool:
    """Whether there is something else at ``path``; what cannot be read counts as something else."""
    if not path.exists() and not path.is_symlink():
        return False
    try:
        return path.read_bytes() != data
    except OSError:
        return True
