"""docs/uncertainty-story.md: what the budget foretells of the next test, and what the test then brings."""

import subprocess
import sys
from itertools import pairwise

import pytest
from conftest import ROOT

PAGE = ROOT / "docs" / "uncertainty-story.md"
SCRIPT = ROOT / "benchmarks" / "next_test.py"


def test_the_test_that_was_done_brought_what_was_foretold():
    lines = PAGE.read_text(encoding="utf-8").splitlines()
    rows = [[cell.strip() for cell in line.split("|")[1:-1]] for line in lines if line.startswith("| 3 of warp")]
    truth = float(next(line for line in lines if "true force" in line).split("true force is ")[1].split(" N")[0])
    assert len(rows) >= 2
    for row in rows:
        low, high = map(float, row[2].split(" to "))
        assert low < truth < high
    for row, after in pairwise(rows):
        foretold, then = float(row[5]), float(row[6])
        assert then == pytest.approx(foretold, rel=0.2)
        assert then < 0.5 * float(row[1].split(" ± ")[1])
        assert row[4].startswith("10 readings") == row[3].startswith("thickness")
        assert after[0] != row[0]


@pytest.mark.slow
def test_the_page_is_what_the_script_prints():
    made = subprocess.run([sys.executable, str(SCRIPT)], cwd=ROOT, capture_output=True, check=True)
    assert made.stdout.decode() == PAGE.read_text(encoding="utf-8")
