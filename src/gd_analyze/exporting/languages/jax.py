"""Python with JAX: functions to compile, differentiate and map."""

from __future__ import annotations

from typing import ClassVar

from gd_analyze.exporting.languages.python import Python


class Jax(Python):
    """The module of NumPy, for JAX."""

    files: ClassVar = {"_jax.py": "python.py.jinja"}
    module = "jax.numpy"
    short = "jnp"


LANGUAGE = Jax
