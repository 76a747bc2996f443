"""Search for programs of few operations, compiled by Numba."""
