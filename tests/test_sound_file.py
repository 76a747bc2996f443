"""A file that takes every write and remembers the first that failed: HDF5 reads and closes it as any."""

from __future__ import annotations

import errno

import h5py
import numpy as np
import pytest

from gd_analyze.results.sound_file import sound_file

resource = pytest.importorskip("resource", reason="limits on file size are a matter of POSIX")


@pytest.fixture
def limited():
    """Files end at a size, as on a disk that is full."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    yield lambda size: resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
    resource.setrlimit(resource.RLIMIT_FSIZE, before)


def test_what_is_written_can_be_read_whether_it_fits_or_not(tmp_path, limited, rng):
    """Writes and reads anywhere, as on a file in memory."""
    limited(100_000)
    size = 400_000
    expected = np.zeros(size, np.uint8)
    with pytest.raises(OSError, match="File too large") as caught, sound_file(tmp_path / "x") as file:  # noqa: PT012 - the block is the test
        for _ in range(300):
            start, stop = sorted(rng.integers(0, size, 2).tolist())
            data = rng.integers(0, 256, stop - start, dtype=np.uint8)
            file.seek(start)
            assert file.write(data) == len(data)
            assert file.tell() == stop
            expected[start:stop] = data
            start, stop = sorted(rng.integers(0, size, 2).tolist())
            if file.failure is not None:
                read = bytearray(stop - start)
                file.seek(start)
                assert file.readinto(read) == stop - start
                assert bytes(read) == expected[start:stop].tobytes()
        assert file.failure is not None
    assert caught.value.errno == errno.EFBIG


@pytest.mark.parametrize("size", [0, 100, 100_000, 1_000_000, 3_000_000])
def test_hdf5_closes_a_file_that_did_not_fit(tmp_path, limited, rng, size):
    """Larger than the cache of HDF5, which reads again what it wrote; noise, so that it stays large."""
    limited(size)
    numbers = rng.normal(size=20_000)
    with (  # noqa: PT012 - the block is the test
        pytest.raises(OSError, match="File too large"),
        sound_file(tmp_path / "x.h5") as file,
        h5py.File(file, "w") as written,
    ):
        for k in range(30):
            written.create_dataset(f"group/of/{k}", data=numbers, chunks=(500,), compression=1)
        assert (written["group/of/3"][:] == numbers).all()
    assert (tmp_path / "x.h5").stat().st_size <= size


def test_a_file_that_fits_is_as_any_other(tmp_path):
    with sound_file(tmp_path / "x.h5") as file, h5py.File(file, "w") as written:
        written["numbers"] = np.arange(1_000_000.0)
    with h5py.File(tmp_path / "x.h5") as read:
        assert (read["numbers"][:] == np.arange(1_000_000.0)).all()
