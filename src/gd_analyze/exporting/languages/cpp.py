"""C++: a header of templates on the scalar, so that types that differentiate themselves work; Eigen, too."""

from __future__ import annotations

from typing import ClassVar

from gd_analyze.exporting.language import Language

_RESERVED = """
alignas alignof and and_eq asm atomic_cancel atomic_commit atomic_noexcept auto bitand bitor bool break case
catch char char8_t char16_t char32_t class co_await co_return co_yield compl concept const const_cast
consteval constexpr constinit continue contract_assert decltype default delete do double dynamic_cast else
enum explicit export extern false final float for friend goto if import inline int long module mutable
namespace new noexcept not not_eq nullptr operator or or_eq override private protected public reflexpr
register reinterpret_cast requires restrict return short signed sizeof static static_assert static_cast
struct switch synchronized template this thread_local throw transaction_safe true try typedef typeid
typename typeof union unsigned using virtual void volatile wchar_t while xor xor_eq std model Eigen
"""


class Cpp(Language):
    """C++11 and later."""

    files: ClassVar = {".hpp": "cpp.hpp.jinja"}
    comment = ("/*\n", " *", " */\n")
    reserved = frozenset(_RESERVED.split())

    def number(self, value: float) -> str:
        """Write a number of the scalar's type."""
        return f"T({value!r})"


LANGUAGE = Cpp
