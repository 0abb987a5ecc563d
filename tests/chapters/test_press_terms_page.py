"""docs/press-contact-terms.md is what its benchmark prints."""

import subprocess
import sys

import pytest
from conftest import ROOT

PAGE = ROOT / "docs" / "press-contact-terms.md"
BENCHMARK = ROOT / "benchmarks" / "press_terms.py"


def test_the_page_has_every_term_of_the_benchmark():
    sys.path.insert(0, str(BENCHMARK.parent))
    try:
        import press_terms
    finally:
        sys.path.pop(0)
    head = press_terms.HEAD.format(gap="3mm", dwell="5s").splitlines()
    lines = PAGE.read_text(encoding="utf-8").splitlines()
    assert lines[: len(head)] == head
    rows = [line.split("|")[1].strip() for line in lines[len(head) :]]
    assert rows == [words for words, _ in press_terms.TERMS] + ["all together"]


@pytest.mark.slow
def test_the_page_is_what_the_benchmark_prints():
    made = subprocess.run([sys.executable, str(BENCHMARK)], cwd=ROOT, capture_output=True, check=True)
    assert made.stdout.decode() == PAGE.read_text(encoding="utf-8")
