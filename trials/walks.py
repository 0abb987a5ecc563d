"""Which modules a value meets on its way through the program: those of hyperfab in which a function is called.

Run as ``python -m trials.walks``: three walks over the samples, each command in a process of its own under
``sys.setprofile``. The body of a module, which an import runs, does not count; a compiled kernel counts as the function
that calls it. ``of every command``: modules that each of the commands calls (the command line, cases, documents).
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from pathlib import Path

from tests.builders import FILM, PLATE

ROOT = Path(__file__).parent.parent
WALKS = {
    "one stretch, from a CSV to a stress of a drape": (
        "fit specimens/lycra/warp-23C.csv specimens/lycra/weft-23C.csv --model yeoh-3 -o {0}/fabric.json",
        "drape {0}/fabric.json --mold molds/cup-male.stl --grid 21x21 --size 220mmx220mm --depth 30mm "
        "-o {0}/drape.json",
    ),
    "one temperature, from a TOML to a gap of a press": (
        "mold-heat {0}/plate.toml -o {0}/heat.json",
        "press-contact --male molds/plate-male.stl --female molds/plate-female.stl --axis z --foam specimens/foam.toml "
        "--gap 3mm --male-heat {0}/heat.json:plate -o {0}/press.json",
    ),
    "one reading, through the loop": (
        "close-loop {0}/warp.json --measured specimens/lycra/warp-23C.csv --measured specimens/lycra/weft-23C.csv "
        "-o {0}/loop.json",
    ),
}
#: What the walks need and do not count.
BEFORE = "fit specimens/lycra/warp-23C.csv --model yeoh-3 -o {0}/warp.json"
TRACED = """
import sys, threading
met = set()
def called(frame, event, argument):
    code = frame.f_code
    if event == "call" and code.co_flags & 1 and not code.co_name.startswith("<"):
        met.add(code.co_filename)
sys.setprofile(called), threading.setprofile(called)
from hyperfab.__main__ import main
sys.argv = sys.argv[1:]
try:
    status = main()
except SystemExit as end:
    status = end.code
sys.setprofile(None)
with open({out!r}, "w") as file:
    file.write("\\n".join(sorted(one for one in met if {root!r} in one)))
sys.exit(status)
"""


def met(line: str, folder: Path) -> set[str]:
    """Return the modules that a command calls."""
    out = folder / "met.txt"
    script = TRACED.format(out=str(out), root=str(ROOT / "hyperfab"))
    words = line.format(folder).split()
    done = subprocess.run([sys.executable, "-c", script, "hf", *words], cwd=ROOT, capture_output=True, text=True)
    if done.returncode > 1:
        raise SystemExit(f"hf {' '.join(words)}: {done.stderr}")
    return {os.path.relpath(one, ROOT / "hyperfab") for one in out.read_text().splitlines()}


def main() -> None:
    """Print the count of each walk, and with ``--list`` the modules."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "plate.toml").write_text(PLATE)
        (folder / "film.csv").write_bytes(FILM)
        met(BEFORE, folder)
        found = {walk: [met(line, folder) for line in lines] for walk, lines in WALKS.items()}
    common = set.intersection(*(one for parts in found.values() for one in parts))
    for walk, parts in found.items():
        every = set.union(*parts)
        counts = " + ".join(str(len(one)) for one in parts)
        print(
            f"{walk}: {len(every)} modules ({counts}), {len(every - common)} without the {len(common)} of every command"
        )
        if "--list" in sys.argv:
            print(*(f"    {one}" for one in sorted(every - common)), sep="\n")


if __name__ == "__main__":
    main()
