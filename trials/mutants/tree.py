"""A copy of the program and its tests in which defects are planted, with what numba has compiled kept beside it."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
#: Every file of the copy is of this time, and a planted defect of a later one: compiled code of neither passes for
#: the other's.
EPOCH = 1_700_000_000

_START = """import os

if "HF_REACH_TOLD" in os.environ:
    from trials.mutants import reach

    reach.watch()
"""


def copy(tree: Path) -> None:
    """Make ``tree`` hold the files of this checkout as they are now; what was compiled for unchanged ones stays."""
    listed = subprocess.run(
        ["git", "ls-files", "--cached", "--others", "--exclude-standard"],
        cwd=ROOT,
        capture_output=True,
        check=True,
    )
    names = {name for name in listed.stdout.decode().splitlines() if (ROOT / name).is_file()}
    for old in tree.rglob("*"):
        inside = old.relative_to(tree).as_posix()
        if (
            old.is_file()
            and "__pycache__" not in inside
            and inside not in names
            and inside != "sitecustomize.py"
        ):
            old.unlink()
    changed = False
    for name in sorted(names):
        target = tree / name
        content = (ROOT / name).read_bytes()
        if target.exists() and target.read_bytes() == content:
            continue
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(ROOT / name, target)
        os.utime(target, (EPOCH, EPOCH))
        changed = changed or name.startswith("hyperfab/")
    if changed:  # a kernel holds what it calls in other files: all of it is compiled anew
        for folder in tree.glob("hyperfab/**/__pycache__"):
            shutil.rmtree(folder)
    (tree / "sitecustomize.py").write_text(_START, encoding="utf-8")


def pytest(
    tree: Path, arguments: list[str], environment: dict[str, str], **more: object
) -> subprocess.Popen[bytes]:
    """Start the tests named, in the copy, one process, in a group of their own."""
    command = [sys.executable, "-m", "pytest", "-p", "no:xdist", "-p", "no:cacheprovider", *arguments]
    own = {
        **os.environ,
        "PYTHONPATH": str(tree),
        "HYPERFAB_DATA": os.environ.get("HYPERFAB_DATA", str(ROOT.parent / "shared" / "data")),
        "OMP_NUM_THREADS": "1",
        **environment,
    }
    return subprocess.Popen(command, cwd=tree, env=own, start_new_session=True, **more)  # type: ignore[call-overload]
