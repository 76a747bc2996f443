"""Benchmarks run one thread, each figure as a ratio against a named peer of the same run."""

import os

# Before NumPy loads: a library that spreads over cores would make the ratio depend on the machine.
for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(variable, "1")
