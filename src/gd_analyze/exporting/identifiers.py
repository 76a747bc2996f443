"""Names from outside made into identifiers: safe in every language, unique, and told which became what."""

from __future__ import annotations

import re
import sys
import unicodedata
from collections.abc import Sequence

# Signs of an identifier: MATLAB takes 63, and what is put behind needs some.
LONGEST = 40

_C_AND_CPP = """
alignas alignof and and_eq asm atomic_cancel atomic_commit atomic_noexcept auto bitand bitor bool break case
catch char char8_t char16_t char32_t class co_await co_return co_yield compl concept const const_cast
consteval constexpr constinit continue decltype default delete do double dynamic_cast else enum explicit
export extern false final float for friend goto if import inline int long module mutable namespace new
noexcept not not_eq nullptr operator or or_eq override private protected public reflexpr register
reinterpret_cast requires restrict return short signed sizeof static static_assert static_cast struct switch
synchronized template this thread_local throw transaction_safe true try typedef typeid typename typeof union
unsigned using virtual void volatile wchar_t while xor xor_eq linux unix errno main std stdin stdout
NULL INFINITY NAN size_t
"""
_PYTHON_AND_MATLAB = """
False None True as assert async await class def del elif except finally from global in is lambda nonlocal
pass raise with yield match type end endfunction endif endwhile function otherwise parfor persistent spmd
unwind_protect until np jax jnp casadi numpy print len pi eye zeros ones reshape size nargin nargout
"""
_FUNCTIONS = """
acos asin atan atan2 ceil cos cosh exp fabs floor fmod frexp ldexp log log10 modf pow sin sinh sqrt tan tanh
gamma lgamma tgamma j0 j1 jn y0 y1 yn erf erfc cbrt hypot abs labs div exit abort system remove rename
index signal time clock rand select sine cosine model Eigen
"""
# Names of arguments and results, which stand beside the name of a file's function.
_OURS = "q qd qdd tau D h c stated"
# Python's own modules, which a file of the same name would hide, and files that Windows has no place for.
_DEVICES = {"con", "prn", "aux", "nul", *(f"{port}{k}" for port in ("com", "lpt") for k in range(10))}
_FILES = sys.stdlib_module_names | _DEVICES
RESERVED = frozenset(f"{_C_AND_CPP} {_PYTHON_AND_MATLAB} {_FUNCTIONS} {_OURS}".split()) | _FILES


def identifier(name: str, otherwise: str = "arm") -> str:
    """Make a name a word of ASCII letters, digits and underscores that no language has use for.

    Parameters
    ----------
    name
        Any text.
    otherwise
        What it becomes where nothing is left of it, and what is put in front of digits and words with a use.

    Examples
    --------
    >>> identifier("Überarm 3000*/"), identifier("double"), identifier("7-bot"), identifier("腕")
    ('Uberarm_3000', 'arm_double', 'arm_7_bot', 'arm')
    """
    plain = unicodedata.normalize("NFKD", name).encode("ascii", "ignore").decode("ascii")
    word = re.sub(r"[^A-Za-z0-9]+", "_", plain).strip("_")
    if not word:
        return otherwise
    if not word[0].isalpha() or word in RESERVED or word.lower() in _FILES:
        word = f"{otherwise}_{word}"
    return word[:LONGEST].rstrip("_")


def identifiers(names: Sequence[str], otherwise: str = "joint") -> tuple[str, ...]:
    """Make identifiers of names, no two alike, not even to those who do not look at capitals.

    Examples
    --------
    >>> identifiers(["a b", "A-b", "a_b_2", ""])
    ('a_b', 'A_b_2', 'a_b_2_2', 'joint')
    """
    taken: set[str] = set()
    made = []
    for name in names:
        base = word = identifier(name, otherwise)
        number = 1
        while word.lower() in taken:
            number += 1
            word = f"{base}_{number}"
        taken.add(word.lower())
        made.append(word)
    return tuple(made)
