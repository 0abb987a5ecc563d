"""Bad input: each its exit status and one message with place and remedy, at once, without a traceback."""

from __future__ import annotations

import json
import math
import os
import signal
import subprocess
import sys
import time
from dataclasses import dataclass, field
from pathlib import Path

import pytest
from builders import FILM, PLATE
from warm import Warm

ROOT = Path(__file__).resolve().parents[2]
#: A refusal takes less than this share of what it costs to load all that the commands load, here and now: 2 s where
#: that is 3.2 s; with the imports of its own command it takes 0.2 to 1.4 s there.
SHARE, MEGABYTES = 0.625, 400.0

TRELOAR = ROOT / "specimens/treloar-1944"
MALE, FEMALE = ROOT / "molds/cup-male.stl", ROOT / "molds/cup-female.stl"
FOAM = """
format = "hyperfab.foam/1"
thickness = "3.5 mm"
compression = { table = "foam.csv" }
fabric = { above = "0.5 mm", below = "0.5 mm" }
"""
CURVE = b"strain [-],stress [MPa]\n0,0\n0.2,0.01\n0.5,0.02\n0.8,0.1\n"
TANGLED = b"0.1,0.2\n0.9,0.3\n0.2,0.4\n0.95,0.5\n"
FABRIC = {
    "format": "hyperfab.material/1",
    "model": "yeoh-3",
    "parameters": {"C10_MPa": 0.18, "C20_MPa": -0.004, "C30_MPa": 0.0008},
    "thickness_mm": 1.0,
}
FABRIC_JSON = json.dumps(FABRIC).encode()
STL = MALE.read_bytes()
ROWS = b"stretch,stress [MPa]\n1.1,0.1\n1.2,0.2\n1.3,0.25\n"

FIT = ("fit", "--model", "neo-hookean", "--uniaxial")
CONTACT = ("fabric-contact", "fabric.json")
DRAPE = ("drape", "fabric.json", "--mold", "m.stl", "--grid", "20x20")
HEAT = ("mold-heat", "mold.toml")
PRESS = (
    "press-contact",
    "--male",
    "m.stl",
    "--female",
    "f.stl",
    "--foam",
    "foam.toml",
    "--temperature",
    "20degC",
)
LOOP = ("close-loop", "fabric.json", "--measured")
SOUND: dict[str, bytes] = {
    "fabric.json": FABRIC_JSON,
    "m.stl": STL,
    "f.stl": FEMALE.read_bytes(),
    "foam.toml": FOAM.encode(),
    "foam.csv": CURVE,
    "film.csv": FILM,
    "mold.toml": PLATE.encode(),
}


@dataclass(frozen=True)
class Bad:
    """One bad call: what differs from sound input, how it must end, and what its message must say."""

    name: str
    arguments: tuple[str, ...]
    status: int
    said: tuple[str, ...]
    files: dict[str, bytes] = field(default_factory=dict)
    stdin: bytes = b""


def csv(name: str, data: bytes, *said: str, options: tuple[str, ...] = ()) -> Bad:
    return Bad(f"csv {name}", (*FIT, "a.csv", *options), 3, ("a.csv", *said), {"a.csv": data})


def document(name: str, data: bytes, *said: str) -> Bad:
    return Bad(f"json {name}", CONTACT, 3, ("fabric.json", *said), {"fabric.json": data})


def stl(name: str, data: bytes, *said: str) -> Bad:
    return Bad(f"stl {name}", DRAPE, 3, ("m.stl", *said), {"m.stl": data})


def mold(name: str, old: str, new: str, *said: str) -> Bad:
    assert old in PLATE
    return Bad(f"mold {name}", HEAT, 3, said, {"mold.toml": PLATE.replace(old, new, 1).encode()})


def foam(name: str, old: str, new: str, *said: str) -> Bad:
    assert old in FOAM
    return Bad(f"foam {name}", (*PRESS, "--gap", "3mm"), 3, said, {"foam.toml": FOAM.replace(old, new, 1).encode()})


def usage(name: str, *arguments: str, said: tuple[str, ...], status: int = 2) -> Bad:
    return Bad(f"usage {name}", arguments, status, said, {"a.csv": ROWS})


CASES = [
    csv("empty", b"", "is empty"),
    csv("truncated", ROWS[:-6], "line 4", "header has 2", "complete the row"),
    csv("cut in a cell", b"stretch,stress [MPa]\n1.1,0.1\n1.2,\n", "line 3", 'column "stress [MPa]"', "is empty"),
    csv("NaN", ROWS.replace(b"0.2", b"NaN", 1), "line 3", 'column "stress [MPa]"', "correct the cell"),
    csv("infinite", ROWS.replace(b"0.2", b"1e999", 1), "line 3", "larger than any double"),
    csv("text in a cell", ROWS.replace(b"0.2", b"slip", 1), "line 3", "slip is no number"),
    csv("wrong unit", ROWS.replace(b"MPa", b"degC"), "line 1", "no unit of stress", "[MPa]"),
    csv("no unit", ROWS.replace(b" [MPa]", b""), "line 1", "has no unit", "stress [MPa]"),
    csv("missing column", ROWS.replace(b"stretch", b"strecth"), "line 1", "no column gives a stretch", "strecth"),
    csv("no header", ROWS.split(b"\n", 1)[1], "line 1", "there is no header"),
    csv("one row", ROWS[:28], "line 2", "has one row"),
    Bad(
        "csv time goes back where times are used",
        (*LOOP, "a.csv"), 3, ("a.csv", "line 5", "the time goes back", "aside"),
        {"a.csv": b"# test: uniaxial\ntime [s],stretch,stress [MPa]\n0,1,0\n2,1.1,1\n1,1.2,2\n"},
    ),
    csv("stretch never changes", b"stretch,stress [MPa]\n1.1,0.1\n1.1,0.2\n", "in all 2 rows"),
    csv("columns swapped", b"stretch,stress [MPa]\n0.03,1.01\n0.4,1.6\n", "line 2", "swapped"),
    csv("both decimal marks", ROWS.replace(b",", b";").replace(b"0.2", b"0,2", 1), "line 3", "one decimal mark"),
    csv("readable both ways", b"stretch;stress [MPa]\n1,234;2,345\n1,345;3,456\n", "line 2", "--decimal"),
    csv("ragged", ROWS.replace(b"1.2,0.2", b"1.2,0.2,7"), "line 3", "has 3 cells"),
    csv("another test", b"# test: shear\n" + ROWS, "line 1", "--shear"),
    csv("no geometry", b"extension [mm],force [N]\n1,1\n2,2\n", "extension", "--gauge-length"),
    csv("no text", STL[:5000], "is no text"),
    csv("half UTF-16", b"\xff\xfe" + ROWS.decode().encode("utf-16-le")[:-1], "UTF-16"),
    csv("no line ends", b"1," * 4_000_000, "line 1", "line ends"),
    csv("half a million rows", b"stretch,stress [MPa]\n" + b"1.1,2\n" * 500_000, "thin the recording out"),
    Bad("csv missing", (*FIT, "none.csv"), 3, ("none.csv", "no such file")),
    Bad("csv is a folder", (*FIT, "."), 3, ("is a folder",)),
    Bad("csv is endless", (*FIT, "/dev/zero"), 3, ("/dev/zero", "larger than")),
    Bad("csv is no file but empty", (*FIT, "/dev/null"), 3, ("/dev/null", "is empty")),
    document("empty", b"", "is empty"),
    document("truncated", FABRIC_JSON[:-20], "line 1", "not valid JSON"),
    document("100,000 levels deep", b'{"a":' * 100_000, "line 1", "nested deeper"),
    document("duplicate keys", FABRIC_JSON[:-1] + b', "model": "gent"}', "key model", "stands twice"),
    document("NaN", FABRIC_JSON.replace(b"0.18", b"NaN"), "key parameters.C10_MPa", "NaN"),
    document("too large a number", FABRIC_JSON.replace(b"0.18", b"1e999"), "key parameters.C10_MPa"),
    document("another kind", FABRIC_JSON.replace(b"material", b"drape"), "is a drape document"),
    document("newer version", FABRIC_JSON.replace(b"/1", b"/2"), "version 2"),
    document("no format", b'{"model": "gent"}', "key format"),
    document("a list", b"[1, 2]", "not an object"),
    document("unknown law", FABRIC_JSON.replace(b"yeoh-3", b"yeoh-9"), "yeoh-9"),
    document("missing constant", FABRIC_JSON.replace(b"C30_MPa", b"C31_MPa"), "C3"),
    document("text for a number", FABRIC_JSON.replace(b"0.18", b'"0.18"'), "C10_MPa"),
    document("not UTF-8", FABRIC_JSON.replace(b"yeoh", b"y\xb0oh"), "is not UTF-8"),
    document("a table in its place", ROWS, "is no document", "hf fit"),
    document("a surface in its place", STL, "is no text, so no document"),
    csv("a document in its place", FABRIC_JSON, "hyperfab.material/1", "no table of readings"),
    csv("a mold in its place", PLATE.encode(), "hyperfab.mold/1", "no table of readings"),
    stl("a document in its place", FABRIC_JSON * 2, "is text, no STL"),
    Bad("json on an empty pipe", ("fabric-contact", "-"), 3, ("standard input", "is empty")),
    stl("empty", b"", "is empty"),
    stl("bomb of 134 bytes", STL[:80] + b"\xff\xff\xff\x7f" + STL[84:134], "claims 2147483647 facets", "room for 1"),
    stl("truncated", STL[:-100], "claims", "truncated"),
    stl("ASCII, truncated", b"solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\n", "line 2", "truncated"),
    stl("NaN", STL[:96] + b"\x00\x00\xc0\x7f" + STL[100:], "facet 1", "not finite"),
    stl("no facets", bytes(84), "has no facets"),
    stl("no STL", b"<svg></svg>" * 20, "no STL"),
    mold("syntax", '"200 degC"', "200 degC", "line", "quotes"),
    mold("bare number", '"3000 W"', '"3000"', "power", "3000 W"),
    mold("number without quotes", '"3000 W"', "3000", "power", "W"),
    mold("wrong kind of unit", '"3000 W"', '"3000 K"', "power", "no unit of power"),
    mold("hanging unit", '"3000 W"', '"3000 W**(9**9**9)"', "power", "no unit"),
    mold("one bracket", "[[heater]]", "[heater]", "key heater", "write [[heater]]"),
    mold("one bracket twice", "[[heater]]", "[heater]\n[heater]", "line", "[[heater]]"),
    mold("unknown key", "density", "densty", "densty"),
    mold("unknown material", 'material = "aluminium"', 'material = "unobtainium"', "unobtainium"),
    mold("unknown face", '"plate.z-"', '"plate.q-"', "plate.q-"),
    mold("unknown part", '"plate.z-"', '"plat.z-"', "plat"),
    mold("nan", '"20 mm"\n', "nan\n", "line", "nan"),
    mold("key twice", "[run]\n", '[run]\nstart = "20 degC"\n', "line"),
    mold("missing table", '"film.csv"', '"none.csv"', "none.csv", "no such file"),
    Bad("mold table goes back", HEAT, 3, ("film.csv", "line 5", "increase"), {"film.csv": FILM + b"20,7\n"}),
    mold("element of a nanometre", '"20 mm"\n', '"1 nm"\n', "mesh_size"),
    mold("below absolute zero", '"25 degC"\ntarget', '"-300 degC"\ntarget', "start", "absolute zero"),
    foam("bare number", '"3.5 mm"', '"3.5"', "thickness", "mm"),
    foam("unknown key", "thickness", "thicknes", "thicknes"),
    foam("missing table", "foam.csv", "none.csv", "none.csv"),
    Bad("foam curve goes back", (*PRESS, "--gap", "3mm"), 3, ("foam.csv", "line"), {"foam.csv": CURVE + TANGLED}),
    usage("unknown command", "fitt", said=("fitt",)),
    usage("unknown option", *FIT, "a.csv", "--modle", "gent", said=("--modle",)),
    usage("unknown law", "fit", "--uniaxial", "a.csv", "--model", "yeoh-9", said=("yeoh-9", "yeoh-3")),
    usage("unknown law, no file", "fit", "--uniaxial", "no.csv", "--model", "yeoh-9", said=("no model 'yeoh-9'",)),
    usage("bare noise, no file", *FIT, "no.csv", "--noise", "5", said=("--noise 5: a stress", "5 MPa")),
    usage("no test", "fit", "--model", "gent", said=("--uniaxial",)),
    usage("bare length", *CONTACT, "--depth", "60", said=("--depth", "60mm")),
    usage("negative depth", *CONTACT, "--depth", "-60mm", said=("--depth",)),
    usage("no sphere", *CONTACT, "--sphere-radius", "0mm", said=("--sphere-radius",)),
    usage("unknown shape", *CONTACT, "--shape", "star", said=("--shape", "disc")),
    usage("one node", *DRAPE, "--grid", "1x1", said=("--grid",)),
    usage("no grid", *DRAPE, "--grid", "many", said=("--grid", "100x100")),
    usage("ten billion nodes", *DRAPE, "--grid", "100000x100000", said=("--grid",)),
    usage("bare size", *DRAPE, "--size", "220x220", said=("--size", "mm")),
    usage("STL unit", *DRAPE, "--stl-unit", "spoon", said=("--stl-unit",)),
    usage("two ways to close", *PRESS, "--gap", "3mm", "--force", "5N", said=("--gap", "--force")),
    usage("no way to close", *PRESS, said=("--gap", "--force")),
    usage("unknown axis", *PRESS, "--gap", "3mm", "--axis", "q", said=("--axis",)),
    usage("schema of nothing", "schema", "spoon", said=("spoon", "material")),
    usage("output is input", "fabric-contact", "fabric.json", "-o", "fabric.json", said=("fabric.json", "input")),
    usage("output through a link is input", "fabric-contact", "fabric.json", "-o", "link.json", said=("input",)),
    usage("output is no document", *FIT, "a.csv", "-o", "a.txt", said=("a.txt", ".json")),
    usage("no such folder", *FIT, "a.csv", "-o", "none/a.json", said=("none", "does not exist"), status=5),
    usage("folder is a file", *FIT, "a.csv", "-o", "a.csv/a.json", said=("a.csv is a file, not a folder",), status=5),
    usage("output is a folder", *FIT, "a.csv", "-o", "folder.json", said=("folder.json",), status=5),
    usage("folder not writable", *FIT, "a.csv", "-o", "/proc/a.json", said=("/proc/a.", "unchanged"), status=5),
]  # fmt: skip


@dataclass(frozen=True)
class Outcome:
    """How a process ended, and what it took."""

    status: int
    stdout: bytes
    stderr: str
    cpu_s: float
    wall_s: float
    megabytes: float


#: Runs the command and writes down what it took. A small process of its own: Linux counts the memory of the process
#: that forks, which is this whole test run, to the peak of its child.
METER = """
import resource, subprocess, sys
status = subprocess.call(sys.argv[2:])
used = resource.getrusage(resource.RUSAGE_CHILDREN)
with open(sys.argv[1], "w") as record:
    record.write(f"{status} {used.ru_utime + used.ru_stime} {used.ru_maxrss / 1024}")
"""


def run(arguments: tuple[str, ...], folder: Path, stdin: bytes = b"") -> Outcome:
    """Run ``hf`` in ``folder`` and measure that one process and its children."""
    command = [sys.executable, "-c", METER, ".record", sys.executable, "-m", "hyperfab", *arguments]
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    (folder / ".record").unlink(missing_ok=True)
    start = time.perf_counter()
    with subprocess.Popen(
        command,
        cwd=folder,
        env=environment,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        start_new_session=True,
    ) as process:
        try:
            stdout, stderr = process.communicate(stdin, timeout=60.0)
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            raise
    wall = time.perf_counter() - start
    status, cpu, megabytes = (folder / ".record").read_text().split()
    return Outcome(int(status), stdout, stderr.decode(), float(cpu), wall, float(megabytes))


def warm_run(warm: Warm, arguments: tuple[str, ...], folder: Path, stdin: bytes) -> Outcome:
    """Run ``hf`` where its imports are done; what it weighs is not known."""
    done = warm.run(list(arguments), stdin, folder, 60.0)
    return Outcome(done.returncode, done.stdout, done.stderr.decode(), done.cpu_s, math.nan, math.nan)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    prepare(tmp_path)
    return tmp_path


def prepare(folder: Path) -> None:
    for name, data in SOUND.items():
        (folder / name).write_bytes(data)
    (folder / "link.json").symlink_to("fabric.json")
    (folder / "folder.json").mkdir()


def everything(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.iterdir() if path.is_file() and path.name != ".record"}


#: Each command's first case, and those that could fill the memory, are measured from the start of the interpreter on.
COLD = {bad.name for bad in {bad.arguments[:1]: bad for bad in reversed(CASES)}.values()} | {
    bad.name for bad in CASES if sum(map(len, bad.files.values())) + len(bad.stdin) > 10_000
}


@pytest.mark.parametrize("bad", CASES, ids=lambda bad: bad.name)
def test_bad_input_is_refused_at_once_with_place_and_remedy(bad: Bad, folder: Path, warm: Warm) -> None:
    for name, data in bad.files.items():
        (folder / name).write_bytes(data)
    before = everything(folder)
    if bad.name in COLD:
        found = run(bad.arguments, folder, bad.stdin)
        assert found.megabytes < MEGABYTES
    else:
        found = warm_run(warm, bad.arguments, folder, bad.stdin)
    assert found.status == bad.status, found.stderr
    for words in bad.said:
        assert words in found.stderr
    assert "Traceback" not in found.stderr
    assert found.stdout == b""
    assert everything(folder) == before
    # Of the processor: the wall clock is the machine's, which runs other tests beside this one.
    assert found.cpu_s < SHARE * warm.imports_s


def test_a_full_disk_behind_standard_output_is_status_5() -> None:
    for arguments in (["schema", "material"], ["--help"], ["--version"], ["fit", "--help"]):
        with open("/dev/full", "wb") as full:
            done = subprocess.run(
                [sys.executable, "-m", "hyperfab", *arguments],
                stdout=full,
                stderr=subprocess.PIPE,
                cwd=ROOT,
                check=False,
            )
        assert done.returncode == 5, arguments
        assert b"No space left on device" in done.stderr
        assert b"Traceback" not in done.stderr
        assert done.stderr.count(b"\n") == 1


def test_memory_is_that_of_the_command_alone(folder: Path) -> None:
    ballast = bytearray(os.urandom(1)) * (450 * 2**20)
    found = run(("--version",), folder)
    assert len(ballast) > MEGABYTES
    assert found.status == 0
    assert 5.0 < found.megabytes < 200.0
