"""Equations as text, LaTeX, MathML and SymPy; formatting only, no mechanics."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Any
from xml.sax.saxutils import escape

from gd_analyze.errors import UsageError
from gd_analyze.harmonics.equations import Equation, Term
from gd_analyze.harmonics.terms import Factor, Monomial

if TYPE_CHECKING:
    import sympy

_LETTERS = {"cos": "C", "sin": "S", "power": "d"}

# Powers of ten that are written out; beyond them 5.9e-5 reads better than 0.000059.
_EVERYDAY = range(-4, 6)


def to_text(equation: Equation, digits: int = 3, width: int | None = None) -> str:
    """Write D12 = -0.69 S2 - 0.139 C23; C23 is cos(q2 + q3), d3 a sliding joint's variable.

    Parameters
    ----------
    equation
        The element.
    digits
        Significant digits of the coefficients.
    width
        Break lines between terms so that none is longer, unless a term is; one line by default.
    """
    start = f"{equation.symbol} = "
    pieces = _signed(equation, lambda term: _plain_term(term, digits))
    if width is None:
        return start + " ".join(pieces)
    lines = [start + pieces[0]]
    for piece in pieces[1:]:
        if len(lines[-1]) + 1 + len(piece) <= width:
            lines[-1] += " " + piece
        else:
            lines.append(" " * len(start) + piece)
    return "\n".join(lines)


def to_latex(equation: Equation, digits: int = 3) -> str:
    r"""Write LaTeX, for mathematics mode: C_{23} is cos(q2 + q3)."""

    def one(term: Term) -> str:
        mantissa, exponent = rounded(abs(term.coefficient), digits)
        number = rf"{mantissa} \cdot 10^{{{exponent}}}" if exponent else mantissa
        return _times(number, (_latex_factor(*power) for power in powers(term.factors)), r" \, ")

    return f"{equation.symbol[0]}_{{{equation.symbol[1:]}}} = {' '.join(_signed(equation, one))}"


def to_mathml(equation: Equation, digits: int = 3) -> str:
    """Write presentation MathML, which browsers show without a script."""
    parts = [f"<msub><mi>{equation.symbol[0]}</mi><mn>{equation.symbol[1:]}</mn></msub>", "<mo>=</mo>"]
    if not equation.terms:
        parts.append("<mn>0</mn>")
    for place, term in enumerate(equation.terms):
        if place or term.coefficient < 0:
            parts.append(f"<mo>{'−' if term.coefficient < 0 else '+'}</mo>")
        mantissa, exponent = rounded(abs(term.coefficient), digits)
        number = f"<mn>{mantissa}</mn>"
        if exponent:
            number += f"<mo>·</mo><msup><mn>10</mn>{mathml_number(exponent)}</msup>"
        elif mantissa == "1" and term.factors:
            number = ""
        parts += [number, *(mathml_factor(*power) for power in powers(term.factors))]
    return f"<math><mrow>{''.join(parts)}</mrow></math>"


def to_sympy(equation: Equation) -> sympy.Expr:
    """Build the right-hand side in real symbols q1, q2, ..., with every digit of the coefficients.

    Raises
    ------
    UsageError
        If SymPy is not installed.
    """
    try:
        import sympy
    except ImportError:
        raise UsageError(
            "SymPy is not installed", next_step="install it: pip install 'gd-analyze[symbolic]'"
        ) from None

    functions: dict[str, Callable[[Any], Any]] = {"cos": sympy.cos, "sin": sympy.sin, "power": lambda x: x}
    summands = []
    for term in equation.terms:
        product: Any = sympy.Float(term.coefficient, 17)
        for factor in term.factors:
            argument = sum(factor.multiples[j] * sympy.Symbol(f"q{j + 1}", real=True) for j in factor.joints)
            product *= functions[factor.kind](argument)
        summands.append(product)
    return sympy.Add(*summands)


def powers(monomial: Monomial) -> list[tuple[Factor, int]]:
    """Distinct factors with their exponents, in the order of their joints."""
    distinct = sorted(set(monomial), key=lambda factor: (factor.joints, factor.kind))
    return [(factor, monomial.count(factor)) for factor in distinct]


def factors_text(factors: Monomial) -> str:
    """Write the factors of a term: C2 S23²; 1 where there is none."""
    return " ".join(_text_factor(*power) for power in powers(factors)) or "1"


def legend(equations: Iterable[Equation]) -> tuple[str, ...]:
    """Say what the abbreviations in use mean: one C, one S and every sliding joint's variable."""
    return meanings({factor for equation in equations for term in equation.terms for factor in term.factors})


def meanings(factors: Iterable[Factor]) -> tuple[str, ...]:
    """Say what the abbreviations of these factors mean, as `legend` does."""
    factors = set(factors)
    out = []
    for kind in ("cos", "sin"):
        # The longest sum explains the shorter ones.
        named = sorted((f for f in factors if f.kind == kind and f.is_plain), key=lambda f: f.multiples)
        if named:
            longest = max(named, key=lambda f: len(f.joints))
            argument = " + ".join(f"q{j + 1}" for j in longest.joints)
            out.append(f"{_LETTERS[kind]}{_index(longest)} = {kind}({argument})")
    slides = sorted({factor.joints[0] for factor in factors if factor.kind == "power"})
    out += [f"d{j + 1} = q{j + 1} in m" for j in slides]
    return tuple(out)


def rounded(value: float, digits: int) -> tuple[str, int]:
    """Mantissa and power of ten of a positive number; power 0 for everyday numbers, written out.

    Examples
    --------
    >>> rounded(0.0712, 2), rounded(1234.0, 2), rounded(5.85e-5, 2)
    (('0.071', 0), ('1200', 0), ('5.8', -5))
    """
    shown, _, power = f"{value:.{digits - 1}e}".partition("e")
    exponent = int(power)
    if exponent not in _EVERYDAY:
        return _trimmed(shown), exponent
    return _trimmed(f"{float(f'{shown}e{power}'):.{max(digits - 1 - exponent, 0)}f}"), 0


def number(value: float, digits: int) -> str:
    """Write a number as text: -0.69, 5.85e-5."""
    mantissa, exponent = rounded(abs(value), digits)
    return f"{'-' if value < 0 else ''}{mantissa}" + (f"e{exponent}" if exponent else "")


def _trimmed(text: str) -> str:
    return text.rstrip("0").rstrip(".") if "." in text else text


def _signed(equation: Equation, one: Callable[[Term], str]) -> list[str]:
    """Every term with its sign in front, the first one's only where it is negative."""
    pieces = []
    for place, term in enumerate(equation.terms):
        between = "- " if term.coefficient < 0 else "+ "
        first = "-" if term.coefficient < 0 else ""
        pieces.append((between if place else first) + one(term))
    return pieces or ["0"]


def _times(shown: str, factors: Iterable[str], sign: str) -> str:
    written = list(factors)
    return sign.join(written if shown == "1" and written else [shown, *written])


def _plain_term(term: Term, digits: int) -> str:
    return _times(
        number(abs(term.coefficient), digits), (_text_factor(*power) for power in powers(term.factors)), " "
    )


def _index(factor: Factor) -> str:
    """23 for q2 + q3, and 9,10 for q9 + q10."""
    joints = factor.joints
    return ("," if joints[-1] >= 9 and len(joints) > 1 else "").join(str(j + 1) for j in joints)


def _argument(factor: Factor, one: Callable[[int], str]) -> str:
    """2 q2 + q3; the first multiple of a mode is positive."""
    pieces = []
    for j in factor.joints:
        multiple = factor.multiples[j]
        sign = "-" if multiple < 0 else "+"
        pieces += [sign, (f"{abs(multiple)} " if abs(multiple) > 1 else "") + one(j)]
    return " ".join(pieces[1:] if pieces[0] == "+" else pieces)


def _text_factor(factor: Factor, exponent: int) -> str:
    square = "²" if exponent == 2 else ""
    if factor.is_plain:
        return f"{_LETTERS[factor.kind]}{_index(factor)}{square}"
    return f"{factor.kind}{square}({_argument(factor, lambda j: f'q{j + 1}')})"


def _latex_factor(factor: Factor, exponent: int) -> str:
    square = "^{2}" if exponent == 2 else ""
    if factor.is_plain:
        return f"{_LETTERS[factor.kind]}_{{{_index(factor)}}}{square}"
    return rf"\{factor.kind}{square}({_argument(factor, lambda j: f'q_{{{j + 1}}}')})"


def mathml_factor(factor: Factor, exponent: int) -> str:
    """Write one factor as MathML."""
    square = "<mn>2</mn>" if exponent == 2 else ""
    if factor.is_plain:
        body = f"<mi>{_LETTERS[factor.kind]}</mi><mn>{escape(_index(factor))}</mn>"
        return f"<msubsup>{body}{square}</msubsup>" if square else f"<msub>{body}</msub>"
    function = f"<mi>{factor.kind}</mi>"
    argument = "".join(_mathml_summand(factor, j, j == factor.joints[0]) for j in factor.joints)
    head = f"<msup>{function}{square}</msup>" if square else function
    return f"{head}<mo>&#x2061;</mo><mrow><mo>(</mo>{argument}<mo>)</mo></mrow>"


def _mathml_summand(factor: Factor, joint: int, first: bool) -> str:
    multiple = factor.multiples[joint]
    sign = "" if first and multiple > 0 else f"<mo>{'−' if multiple < 0 else '+'}</mo>"
    times = f"<mn>{abs(multiple)}</mn>" if abs(multiple) > 1 else ""
    return f"{sign}{times}<msub><mi>q</mi><mn>{joint + 1}</mn></msub>"


def mathml_number(value: int) -> str:
    """Write a whole number, with its sign, as MathML."""
    return f"<mrow><mo>−</mo><mn>{-value}</mn></mrow>" if value < 0 else f"<mn>{value}</mn>"
