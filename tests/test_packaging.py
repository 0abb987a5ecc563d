"""What the project promises about itself: licenses, pinned versions, arrows between packages."""

from __future__ import annotations

import re
import subprocess
import sys
import tomllib
from importlib import metadata
from pathlib import Path

import pytest
from packaging.requirements import Requirement

ROOT = Path(__file__).resolve().parent.parent
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]


def default_install() -> set[str]:
    """Return the names of everything that `pip install .` brings, with what these need in turn."""
    found: set[str] = set()
    waiting = [Requirement(text) for text in PROJECT["dependencies"]]
    while waiting:
        requirement = waiting.pop()
        if requirement.name.lower() in found:
            continue
        if requirement.marker is not None and not requirement.marker.evaluate({"extra": ""}):
            continue
        found.add(requirement.name.lower())
        waiting += [Requirement(text) for text in metadata.requires(requirement.name) or []]
    return found


def test_the_default_install_carries_no_gpl_or_agpl() -> None:
    for name in sorted(default_install()):
        about = metadata.metadata(name)
        said = [about.get("License-Expression") or "", *(about.get_all("Classifier") or [])]
        said += (about.get("License") or "").splitlines()[:3]
        # The LGPL allows use as a library; a runtime exception (libgfortran in wheels) allows linking.
        strong = [
            text
            for text in said
            if re.search(r"\bA?GPL|Affero|General Public License", text)
            and not re.search(r"LGPL|Lesser|Library General|GCC-exception", text)
        ]
        assert not strong, f"{name}: {strong}"


def test_every_dependency_is_pinned_without_an_address() -> None:
    text = (ROOT / "constraints.txt").read_text(encoding="utf-8")
    assert "://" not in text
    pins = dict(line.split("==", 1) for line in text.splitlines() if "==" in line)
    pinned = {name.lower().replace("_", "-"): version.strip() for name, version in pins.items()}
    install = default_install()
    others = [name for name in install if pinned.get(name.replace("_", "-"), "") != metadata.version(name)]
    direct = {Requirement(text).name.lower() for text in PROJECT["dependencies"]}
    if direct.intersection(others):
        pytest.skip(
            f"other versions than those of constraints.txt are installed: {', '.join(sorted(direct & {*others}))}"
        )
    missing = {name.replace("_", "-") for name in install} - set(pinned)
    assert not missing


def test_packages_named_by_the_project_are_all_used() -> None:
    modules = {"scikit-fem": "skfem", "netgen-mesher": "netgen", "tomli-w": "tomli_w", "pillow": "PIL"}
    source = "\n".join(path.read_text(encoding="utf-8") for path in (ROOT / "hyperfab").rglob("*.py"))
    for text in PROJECT["dependencies"]:
        name = Requirement(text).name
        module = modules.get(name, name)
        assert re.search(rf"^\s*(import|from) {module}\b", source, re.MULTILINE), f"{name} is never imported"


def test_import_arrows_point_one_way() -> None:
    pytest.importorskip("importlinter", reason="import-linter is not installed (make test installs it)")
    done = subprocess.run(
        [sys.executable, "-c", "from importlinter.cli import lint_imports_command as c; c()"],
        cwd=ROOT,
        capture_output=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout.decode()
