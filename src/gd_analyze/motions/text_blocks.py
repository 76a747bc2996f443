"""Some rows of a text table at a time: their bytes, and the numbers in them."""

from __future__ import annotations

import io
import re
import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

from gd_analyze.motions.text_layout import EMPTY, Layout

_NEEDS_LOOK = re.compile(rb"(?m)^[ \t]*(?:#|$)")
_NOT_GIVEN = sorted({word for empty in EMPTY for word in (empty, empty.upper(), empty.capitalize(), "NaN")})


@dataclass(frozen=True, eq=False)
class Block:
    """Some rows: their bytes without comments and blank lines, and where they stand in the file."""

    data: bytes
    numbers: Sequence[int]

    @property
    def lines(self) -> list[str]:
        """Its lines as text."""
        return self.data.decode("utf-8", errors="replace").removesuffix("\n").split("\n")


def block_of(data: bytes, number: int, begin: int) -> tuple[Block, int]:
    """The rows among some lines, the first of which is line `number`; rows begin on line `begin`."""
    if not data.endswith(b"\n"):
        data += b"\n"
    count = data.count(b"\n")
    following = number + count
    if number >= begin and not _NEEDS_LOOK.search(data[:-1]):
        return Block(data, range(number, following)), following
    kept = [
        (k, line)
        for k, line in enumerate(data[:-1].split(b"\n"), number)
        if k >= begin and line.strip() and not line.lstrip().startswith(b"#")
    ]
    return Block(b"".join(line + b"\n" for _, line in kept), [k for k, _ in kept]), following


def frame_of(block: Block, columns: Sequence[int], as_text: frozenset[int], layout: Layout) -> Any:
    """Columns of a block, and the last one, as a frame; None where pandas cannot read it."""
    import pandas as pd

    last = layout.width - 1
    asked = sorted({*columns, last})
    text = as_text | ({last} - set(columns))
    white = layout.delimiter == " "
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error", pd.errors.ParserWarning)
            return pd.read_csv(
                io.BytesIO(block.data),
                header=None,
                names=range(layout.width),
                index_col=False,
                usecols=asked,
                sep=r"\s+" if white else layout.delimiter,
                decimal=layout.decimal,
                dtype={column: object if column in text else float for column in asked},
                skipinitialspace=True,
                keep_default_na=False,
                na_values=_NOT_GIVEN,
                skip_blank_lines=False,
                encoding_errors="replace",
                **_exact(),
                low_memory=False,
            )
    except (ValueError, OverflowError, pd.errors.ParserWarning):
        return None


@cache
def _exact() -> dict[str, Any]:
    """What makes pandas read every digit; since version 3.1 it does, and says so of the word."""
    import pandas as pd

    release = tuple(int(part) for part in pd.__version__.split(".")[:2])
    return {} if release >= (3, 1) else {"float_precision": "round_trip"}
