"""Reading ends, whatever is read."""

from __future__ import annotations

import pytest

from gd_analyze.files import megabytes, read_at_most


@pytest.mark.parametrize("size", [0, 1, 2**20 - 1, 2**20, 2**20 + 1, 3 * 2**20])
def test_reading_ends_at_the_largest_size(tmp_path, size):
    path = tmp_path / "text"
    path.write_bytes(b"x" * size)
    assert read_at_most(path, size) == b"x" * size
    assert read_at_most(path, size + 1) == b"x" * size
    if size:
        assert read_at_most(path, size - 1) is None


def test_reading_of_what_is_no_text_ends_early():
    assert read_at_most("/dev/zero", 10**12) == bytes(2**20)
    assert (megabytes(10_000), megabytes(10**9)) == ("0.01 MB", "1000 MB")
