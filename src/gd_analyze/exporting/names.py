"""Names of languages, and identifiers from names: unique, and reserved in no language."""

from __future__ import annotations

import keyword
import re
import sys
import unicodedata
from collections.abc import Sequence

LANGUAGES = ("c", "casadi", "cpp", "jax", "latex", "matlab", "python", "sympy")
# Other spellings of these.
SPELLINGS = {"c++": "cpp"}

# MATLAB allows 63 characters, including those appended to a name.
LONGEST_NAME = 40

# Words by language that cannot be names, regardless of capitals.
RESERVED = {
    "c": """
alignas alignof auto bool break case char const constexpr continue default do double else enum extern false
float for goto if inline int long nullptr register restrict return short signed sizeof static static_assert
struct switch thread_local true typedef typeof typeof_unqual union unsigned void volatile while asm linux
unix errno main stdin stdout NULL INFINITY NAN size_t acos asin atan atan2 ceil cos cosh exp fabs floor fmod
frexp ldexp log log10 modf pow sin sinh sqrt tan tanh gamma lgamma tgamma j0 j1 jn y0 y1 yn erf erfc cbrt
hypot abs labs div exit abort system remove rename index signal time clock rand select sine cosine
""",
    "cpp": """
alignas alignof and and_eq asm atomic_cancel atomic_commit atomic_noexcept auto bitand bitor bool break case
catch char char8_t char16_t char32_t class co_await co_return co_yield compl concept const const_cast
consteval constexpr constinit continue contract_assert decltype default delete do double dynamic_cast else
enum explicit export extern false final float for friend goto if import inline int long module mutable
namespace new noexcept not not_eq nullptr operator or or_eq override private protected public reflexpr
register reinterpret_cast requires restrict return short signed sizeof static static_assert static_cast
struct switch synchronized template this thread_local throw transaction_safe true try typedef typeid
typename typeof union unsigned using virtual void volatile wchar_t while xor xor_eq std model Eigen
""",
    "matlab": """
break case catch classdef continue else elseif end for function global if otherwise parfor persistent return
spmd switch try while arguments enumeration events methods properties do until endfunction endif endfor
endwhile endswitch end_try_catch end_unwind_protect unwind_protect unwind_protect_cleanup pi eye zeros ones
reshape size nargin nargout
""",
    # A file named like one of Python's own modules would hide it.
    "python": " ".join(
        [*keyword.kwlist, *keyword.softkwlist, *sys.stdlib_module_names, "numpy np print len"]
    ),
    "casadi": "casadi",
    "jax": "jax jnp",
    "sympy": "sympy",
    "arguments and outputs": "q qd qdd tau d h c stated",
    "files of Windows": " ".join(["con prn aux nul", *(f"com{k} lpt{k}" for k in range(10))]),
}
# One model has one name in all languages.
ALL_RESERVED = frozenset(" ".join(RESERVED.values()).lower().split())


def identifier(name: str, otherwise: str = "arm") -> str:
    """Turn a name into a word of ASCII letters, digits and underscores that is reserved in no language.

    `otherwise` replaces an empty result, and is the prefix of digits and reserved words.
    """
    plain = unicodedata.normalize("NFKD", name).encode("ascii", "ignore").decode("ascii")
    word = re.sub(r"[^A-Za-z0-9]+", "_", plain).strip("_") or otherwise
    if not word[0].isalpha() or word.lower() in ALL_RESERVED:
        word = f"{otherwise}_{word}"
    return word[:LONGEST_NAME].rstrip("_")


def identifiers(names: Sequence[str], otherwise: str = "joint") -> tuple[str, ...]:
    """Turn names into identifiers that differ even without regard to capitals."""
    words: dict[str, str] = {}
    for name in names:
        base = word = identifier(name, otherwise)
        number = 1
        while word.lower() in words:
            number += 1
            word = f"{base}_{number}"
        words[word.lower()] = word
    return tuple(words.values())
