"""A table whose head stands again in mid-table, as printed page by page, is one; specimens are not."""

from __future__ import annotations

import numpy as np
import pytest

from hyperfab.io.csv_table import read_table
from hyperfab.io.csv_tests import read_tests

HEAD = "Time [s];Extension [mm];Force [N]\n"
SIZES = "# width: 50 mm\n# thickness: 0.5 mm\n# gauge length: 100 mm\n"


def rows(numbers: range, since: int = 0) -> str:
    return "".join(f"{k};{0.5 * (k - since)};{0.4 * (k - since)}\n" for k in numbers)


@pytest.mark.parametrize("titles", ["", "Page {}\n"])
def test_pages_of_one_test_are_one(titles: str) -> None:
    pages = [titles.format(k) + HEAD + rows(range(first, min(first + 8, 20))) for k, first in enumerate((0, 8, 16), 1)]
    [found] = read_tests((SIZES + "".join(pages)).encode(), "a.csv", test="uniaxial")
    assert found.stretch == pytest.approx(1.0 + 0.005 * np.arange(20.0))
    assert found.stress == pytest.approx(0.016 * np.arange(20.0))
    assert found.left_out == {"head repeated": 2}
    assert found.specimen is None


@pytest.mark.parametrize("title", ["", "Specimen {}\n"])
def test_specimens_one_under_another_stay_apart(title: str) -> None:
    """The clock of the machine goes on and each is pulled from rest; or all goes on, but a title tells."""
    since = 0 if title else 8
    parts = [title.format(1) + HEAD + rows(range(8)), title.format(2) + HEAD + rows(range(8, 16), since)]
    assert len(read_tests((SIZES + "".join(parts)).encode(), "a.csv", test="uniaxial")) == 2


def test_a_column_that_tells_tables_apart_keeps_them_so() -> None:
    text = SIZES + "".join(
        "Probe;Time [s];Strain [%];Force [N]\n"
        + "".join(f"{k};{10 * k + n};{(n * 3) % 5};{0.1 * ((n * 3) % 5):.1f}\n" for n in range(10))
        for k in (1, 2)
    )
    assert len(read_tests(text.encode(), "a.csv", test="uniaxial")) == 2


def test_pages_of_a_log_are_one_and_a_gap_of_the_logger_is_none() -> None:
    def log(*starts: int) -> bytes:
        return "".join(
            "time [s],cup [degC]\n" + "".join(f"{k},{20 + k}\n" for k in range(start, start + 10)) for start in starts
        ).encode()

    table = read_table(log(0, 10, 20), "a.csv", {"time": "time"}, rest="temperature")
    assert table["cup"].tolist() == [20.0 + k for k in range(30)]
    with pytest.raises(Exception, match="has 2 tables"):
        read_table(log(0, 500), "a.csv", {"time": "time"}, rest="temperature")
