"""Tables of one that was printed page by page: its head stands again, and its readings go on."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from hyperfab.io.cells import plain_values
from hyperfab.io.settings import Entry
from hyperfab.io.tables import Block, is_data, is_label

#: By how many of its largest steps what counts on may go on from one page to the next.
_STEPS = 2.0
#: What stands above each page, with its number.
_RUNNING = ("title", "page")


def one_of_pages(blocks: Sequence[Block]) -> list[Block]:
    """Return tables with those in one that are pages of a table: each has the same head and states the same, and every
    column that runs one way in all of them, one at least, goes on where the page before ended.

    Of specimens one under another the way, or a column that numbers them, begins anew, and phases of a test begin a
    clock anew. Heads repeated are counted as left out.

    >>> head = dict(headings=(), metadata={})
    >>> first = Block(1, rows=[(2, ["0", "5"]), (3, ["1", "7"])], **head)
    >>> len(one_of_pages([first, Block(4, rows=[(5, ["2", "8"])], **head)]))
    1
    >>> len(one_of_pages([first, Block(4, rows=[(5, ["0", "8"])], **head)]))
    2
    """
    found: list[Block] = []
    for block in blocks:
        if found and _goes_on(found[-1], block):
            again = Counter({"head repeated": 1})
            found[-1] = replace(
                found[-1], rows=[*found[-1].rows, *block.rows], left_out=found[-1].left_out + block.left_out + again
            )
        else:
            found.append(block)
    return found


def _goes_on(table: Block, page: Block) -> bool:
    if [one.title for one in table.headings] != [one.title for one in page.headings]:
        return False
    titles = [entry.value for entry in page.metadata.get("title", [])]
    if any(is_label([title]) for title in titles) or _stated(table.metadata) != _stated(page.metadata):
        return False
    before, after = (_columns(one) for one in (table, page))
    told = False
    for one, two in zip(before, after, strict=False):
        if len({*one}) == 1 == len({*two}) and one[0] != two[0]:
            return False  # it tells them apart
        values, more = plain_values(one), plain_values(two)
        if len(values) < len(one) or len(more) < len(two):
            continue
        way = np.sign(values[-1] - values[0])
        steps, ahead = way * np.diff(values), way * np.diff(more)
        if way and np.all(steps >= 0.0) and np.all(ahead >= 0.0):
            if not 0.0 <= way * (more[0] - values[-1]) <= _STEPS * steps.max():
                return False
            told = True
    return told


def _columns(block: Block) -> list[tuple[str, ...]]:
    """Return the cells of a block's readings by column."""
    return list(zip(*(cells for _, cells in block.rows if is_data(cells)), strict=False))


def _stated(metadata: Mapping[str, Sequence[Entry]]) -> dict[str, list[str]]:
    """Return what stands above a table; of running titles without their numbers."""
    return {
        key: [re.sub(r"\d+", "", one.value) if key in _RUNNING else one.value for one in entries]
        for key, entries in metadata.items()
    }
