"""The workers: killed while they start, on a cluster behind certificates, of another program."""

from __future__ import annotations

import contextlib
import json
import os
import shutil
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from conftest import ROOT

from hyperfab.studies.plan import program

pytest.importorskip("distributed", reason="Dask is not installed (pip install . brings it)")

STUDY = """
format = "hyperfab.study/1"
name = "Sums"
[axis.a]
range = { from = 1, to = 4, count = 4 }
[[step]]
name = "one"
command = "add"
arguments = ["{a}", "1"]
[figures]
sum = "one.sum"
"""

DRIVER = """
import sys
from hyperfab.cases.sweep import SweepCase
from hyperfab.chapters import sweep
import studies.trivial
from hyperfab.chapters.job import Job
from hyperfab.console import Console, run_guarded
if __name__ == "__main__":
    address = sys.argv[1] if len(sys.argv) > 1 else None
    sys.exit(run_guarded(lambda: sweep.run(
        Job("sweep", ["study.toml"], Console()),
        SweepCase(study="study.toml", out="out", jobs=None if address else 2, scheduler=address),
        commands=studies.trivial), False))
"""

ENVIRONMENT = {**os.environ, "PYTHONPATH": os.pathsep.join([str(ROOT), str(ROOT / "tests")])}


@pytest.fixture
def shop(tmp_path: Path) -> Path:
    (tmp_path / "study.toml").write_text(STUDY)
    (tmp_path / "driver.py").write_text(DRIVER)
    return tmp_path


@pytest.mark.slow
def test_workers_killed_while_they_start_are_replaced(shop: Path) -> None:
    psutil = pytest.importorskip("psutil", reason="comes with distributed")
    driver = subprocess.Popen(
        [sys.executable, "driver.py"], cwd=shop, env=ENVIRONMENT, stderr=subprocess.PIPE, text=True
    )
    killed: set[int] = set()
    while len(killed) < 2 and driver.poll() is None:
        for child in psutil.Process(driver.pid).children():
            # A child may end between the listing and the look at it.
            with contextlib.suppress(psutil.NoSuchProcess):
                if child.pid not in killed and "spawn_main" in " ".join(child.cmdline()):
                    child.kill()
                    killed.add(child.pid)
        time.sleep(0.01)
    said = driver.communicate(timeout=120)[1]
    assert len(killed) == 2
    assert driver.returncode == 0, said
    assert "4 cases: 4 steps run" in said
    assert (shop / "out" / "sweep.csv").read_text().count("\n") == 5


# ---- a cluster behind certificates ------------------------------------------------------------------------------


@pytest.fixture
def certificates(tmp_path: Path) -> dict[str, str]:
    """Dask's settings, as the docs tell them, with a certificate made for this test."""
    openssl = shutil.which("openssl")
    if openssl is None:
        pytest.skip("openssl is not installed")
    folder = tmp_path / "certificates"
    folder.mkdir()
    for line in (
        "req -x509 -newkey rsa:2048 -nodes -keyout ca.key -out ca.pem -days 2 -subj /CN=shop",
        "req -newkey rsa:2048 -nodes -keyout key.pem -out request.pem -subj /CN=hf",
        "x509 -req -in request.pem -CA ca.pem -CAkey ca.key -CAcreateserial -days 2 -out cert.pem",
    ):
        subprocess.run([openssl, *line.split()], cwd=folder, check=True, capture_output=True)
    prefix = "DASK_DISTRIBUTED__COMM__"
    settings = {f"{prefix}REQUIRE_ENCRYPTION": "True", f"{prefix}TLS__CA_FILE": str(folder / "ca.pem")}
    for role in ("SCHEDULER", "WORKER", "CLIENT"):
        settings[f"{prefix}TLS__{role}__CERT"] = str(folder / "cert.pem")
        settings[f"{prefix}TLS__{role}__KEY"] = str(folder / "key.pem")
    return settings


@pytest.fixture
def cluster(shop: Path, certificates: dict[str, str]) -> Iterator[str]:
    """Address of a scheduler with one worker, both behind TLS."""
    env = {**ENVIRONMENT, **certificates}
    dask = [sys.executable, "-m", "dask"]
    quiet = {"cwd": shop, "env": env, "stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    scheduler = subprocess.Popen(
        [*dask, "scheduler", "--protocol", "tls", "--host", "127.0.0.1", "--port", "0", "--no-dashboard",
         "--scheduler-file", "scheduler.json"],
        **quiet,
    )  # fmt: skip
    worker = subprocess.Popen(
        [*dask, "worker", "--scheduler-file", "scheduler.json", "--nthreads", "1", "--no-nanny", "--no-dashboard",
         "--host", "127.0.0.1"],
        **quiet,
    )  # fmt: skip
    try:
        for _ in range(600):
            if (shop / "scheduler.json").exists():
                break
            time.sleep(0.1)
        yield json.loads((shop / "scheduler.json").read_text())["address"]
    finally:
        for process in (worker, scheduler):
            process.kill()
            process.wait()


@pytest.mark.slow
def test_a_study_runs_on_a_cluster_behind_tls_and_not_without_certificates(
    shop: Path, cluster: str, certificates: dict[str, str]
) -> None:
    assert cluster.startswith("tls://127.0.0.1:")
    command = [sys.executable, "driver.py", cluster]

    def sweep(env: dict[str, str], *words: str) -> subprocess.CompletedProcess[str]:
        return subprocess.run(
            [*command[:2], *words],
            cwd=shop,
            env=env,
            capture_output=True,
            text=True,
            timeout=120,
            check=False,
        )

    without = sweep(ENVIRONMENT, cluster)
    assert without.returncode == 3
    assert "no certificates are set for TLS" in without.stderr
    plain = sweep(ENVIRONMENT, cluster.replace("tls:", "tcp:"))
    assert plain.returncode == 3
    assert "no scheduler answers" in plain.stderr
    assert not list((shop / "out").glob("steps/*/*"))
    for _ in range(10):  # the worker may still be on its way
        done = sweep({**ENVIRONMENT, **certificates}, cluster)
        if done.returncode == 0:
            break
        time.sleep(1.0)
    assert done.returncode == 0, done.stderr
    assert "4 cases: 4 steps run" in done.stderr


# ---- which program ----------------------------------------------------------------------------------------------


def test_steps_of_another_program_are_other_steps(shop: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from hyperfab.documents.base import read_document
    from hyperfab.documents.study import StudyDocument
    from hyperfab.io.inputs import Inputs
    from hyperfab.studies.plan import Plan

    monkeypatch.chdir(shop)

    def keys() -> list[str]:
        inputs = Inputs()
        return [
            case.steps[0].key for case in Plan(read_document(inputs, "study.toml", StudyDocument), "study.toml", inputs)
        ]

    here = keys()
    assert keys() == here
    assert program().startswith("0.")
    assert "+" in program()
    monkeypatch.setattr("hyperfab.studies.plan.program", lambda: "0.1.0+0123456789abcdef")
    assert not set(keys()) & set(here)
