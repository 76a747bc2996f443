"""Python: one module that needs NumPy alone; one of JAX, and one of CasADi's functions."""

from __future__ import annotations

from gd_analyze.exporting.export_input import ExportInput
from gd_analyze.exporting.statements import Notation, body
from gd_analyze.exporting.templating import filled
from gd_analyze.exporting.told import told


def python_texts(subject: ExportInput, scalar: str) -> tuple[str, ...]:
    """Print a module for NumPy; its functions take any number of states."""
    return _module(subject, "numpy.py.jinja", {"module": "numpy", "short": "np"})


def jax_texts(subject: ExportInput, scalar: str) -> tuple[str, ...]:
    """Print a module for JAX, to be compiled, differentiated and mapped."""
    return _module(subject, "numpy.py.jinja", {"module": "jax.numpy", "short": "jnp"})


def casadi_texts(subject: ExportInput, scalar: str) -> tuple[str, ...]:
    """Print a module that makes a casadi.Function of each."""
    return _module(subject, "casadi.py.jinja", {"short": "casadi"})


def _module(subject: ExportInput, template: str, words: dict[str, str]) -> tuple[str, ...]:
    notation = Notation(sin=f"{words['short']}.sin", cos=f"{words['short']}.cos")
    text = filled(
        template,
        subject=subject,
        lines=told(subject),
        functions=[(each, body(each, notation)) for each in subject.functions],
        listed=lambda values: ", ".join(map(repr, values)),
        **words,
    )
    return (text,)
