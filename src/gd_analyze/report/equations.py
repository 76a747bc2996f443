"""The text's equations and the simplified model, written out in mathematics."""

from __future__ import annotations

from dataclasses import dataclass

from markupsafe import Markup

from gd_analyze.report import mathml as m
from gd_analyze.report.context import Context


@dataclass(frozen=True)
class Equation:
    """A formula, its source and what it says."""

    formula: Markup
    source: str
    meaning: str


@dataclass(frozen=True)
class JointEquation:
    """Torque of one joint from the kept parts: terms that may wrap between lines."""

    left: Markup
    terms: tuple[Markup, ...]


def torque_equations(context: Context, drives: bool) -> tuple[JointEquation, ...]:
    """Every joint's torque with only what the model keeps; [FGL87] Eq. (3.4-24)."""
    n = len(context.coriolis_kept)
    equations = []
    for i in range(n):
        terms = []
        for j in range(n):
            kept = context.inertia_kept[i][j]
            drive = drives and i == j
            factors = [] if kept == "neither" else [m.element(_label(n, i, j), kept)]
            if drive:
                factors.append(m.sub(m.name("J"), m.num(i + 1)))
            if len(factors) == 2:
                factors = [m.op("("), factors[0], m.op("+"), factors[1], m.op(")")]
            if factors:
                terms.append(m.row(*factors, m.acceleration(j + 1)))
        for symbol, keeps in (("h", context.coriolis_kept), ("c", context.gravity_kept)):
            if keeps[i] != "neither":
                terms.append(m.element(f"{symbol}{i + 1}", keeps[i]))
        signed = [m.math(*((m.op("+"), term) if k else (term,))) for k, term in enumerate(terms)]
        equations.append(
            JointEquation(
                m.math(m.sub(m.name("τ"), m.num(i + 1)), m.op("=")), tuple(signed) or (m.math(m.num(0)),)
            )
        )
    return tuple(equations)


def inertia_matrix(context: Context) -> Markup:
    """D with only what the model keeps."""
    n = len(context.coriolis_kept)
    cells = [
        [m.num(0) if kept == "neither" else m.element(_label(n, i, j), kept) for j, kept in enumerate(line)]
        for i, line in enumerate(context.inertia_kept)
    ]
    return m.math(m.name("D"), m.op("="), m.table(cells), block=True)


def model_equation() -> Markup:
    """Write tau = D qdd + h + c in one line."""
    q = m.name("q")
    return m.math(
        m.name("τ"),
        m.op("="),
        m.row(m.name("D"), m.op("("), q, m.op(")"), m.over(q, "¨")),
        m.op("+"),
        m.row(m.name("h"), m.op("("), q, m.op(","), m.over(q, "˙"), m.op(")")),
        m.op("+"),
        m.row(m.name("c"), m.op("("), q, m.op(")")),
    )


def source_equations() -> tuple[Equation, ...]:
    """The generalized d'Alembert equations this page is computed from, for rotary joints."""
    i, j, k, s, n = (m.name(letter) for letter in "ijksn")
    one, two = m.num(1), m.num(2)
    z, body, omega, rates = m.name("z"), m.name("I"), m.name("ω"), m.name("b")
    tran, rot, transpose = m.words("tran"), m.words("rot"), m.name("T")
    equals, plus, cross, dot = m.op("="), m.op("+"), m.op("×"), m.op("·")

    def less(index: Markup) -> Markup:
        return m.row(index, m.op("−"), one)

    def brackets(*content: Markup) -> Markup:
        return m.row(m.op("["), *content, m.op("]"))

    def in_link(vector: Markup) -> Markup:
        frame = Markup(
            "<mmultiscripts><mi>R</mi><mn>0</mn><mrow></mrow><mprescripts/><mrow></mrow><mi>s</mi></mmultiscripts>"
        )
        return m.row(frame, vector)

    def axis(index: Markup) -> Markup:
        return m.sub(z, less(index))

    def start(index: Markup, first: Markup) -> Markup:
        return m.row(index, m.op("="), first)

    r_s, c_s = m.sub(m.over(m.name("r"), "¯"), s), m.sub(m.over(m.name("c"), "¯"), s)
    m_s, I_s = m.sub(m.name("m"), s), m.sub(body, s)

    def arm_of(index: Markup) -> Markup:
        return brackets(
            axis(index), cross, m.op("("), r_s, m.op("−"), m.sub(m.name("p"), less(index)), m.op(")")
        )

    from_both = start(s, m.row(m.words("max"), m.op("("), i, m.op(","), j, m.op(")")))
    p_k = m.subsup(m.name("p"), k, m.op("*"))

    def element_sum(effect: Markup, *summand: Markup) -> Markup:
        return m.math(m.subsup(m.name("D"), m.row(i, j), effect), equals, m.total(from_both, n), *summand)

    def spin(letter: str) -> Markup:
        index = m.name(letter)
        return m.row(m.total(start(index, one), s), m.rate(letter), in_link(axis(index)))

    numbered = [m.sub(m.name("T"), m.num(number)) for number in (1, 2, 3, 4)]
    w_k, w_s, b_k, b_s = m.sub(omega, k), m.sub(omega, s), m.sub(rates, k), m.sub(rates, s)
    terms = m.math(
        numbered[0], equals, m.total(start(k, one), less(s)),
        w_k, cross, m.op("("), w_k, cross, p_k, m.op(")"), m.op(","),
        Markup('<mspace width="1em"/>'),
        numbered[1], equals, m.total(start(k, two), less(s)), b_k, cross, p_k, m.op(","),
        Markup('<mspace width="1em"/>'),
        numbered[2], equals, w_s, cross, m.op("("), w_s, cross, c_s, m.op(")"), m.op(","),
        Markup('<mspace width="1em"/>'),
        numbered[3], equals, b_s, cross, c_s,
    )  # fmt: skip
    return (
        Equation(
            m.math(
                m.sub(m.name("τ"), i),
                equals,
                m.total(start(j, one), n),
                m.sub(m.name("D"), m.row(i, j)),
                m.acceleration("j"),
                plus,
                m.subsup(m.name("h"), i, tran),
                plus,
                m.subsup(m.name("h"), i, rot),
                plus,
                m.sub(m.name("c"), i),
            ),
            "3.4-24",
            "generalized torque of joint i",
        ),
        Equation(
            element_sum(tran, m_s, arm_of(j), dot, arm_of(i)),
            "3.4-25",
            "inertia from moving each link's mass",
        ),
        Equation(
            element_sum(
                rot,
                m.sup(m.row(m.op("("), in_link(axis(i)), m.op(")")), transpose),
                I_s,
                m.op("("),
                in_link(axis(j)),
                m.op(")"),
            ),
            "3.4-25",
            "inertia from turning each link about its centre of mass",
        ),
        Equation(
            m.math(
                m.subsup(m.name("h"), i, tran),
                equals,
                m.total(start(s, i), n),
                m_s,
                m.op("("),
                numbered[0],
                plus,
                numbered[1],
                plus,
                numbered[2],
                plus,
                numbered[3],
                m.op(")"),
                dot,
                arm_of(i),
            ),
            "3.4-26",
            "velocity torque from the links' masses",
        ),
        Equation(terms, "3.4-26", "its four terms; ω adds up the joint rates, b their Coriolis products"),
        Equation(
            m.math(
                m.subsup(m.name("h"), i, rot),
                equals,
                m.total(start(s, i), n),
                m.op("{"),
                m.sup(m.row(m.op("("), in_link(axis(i)), m.op(")")), transpose),
                I_s,
                brackets(
                    m.total(start(j, one), s),
                    m.rate("j"),
                    in_link(axis(j)),
                    cross,
                    m.op("("),
                    m.total(start(k, m.row(j, plus, one)), s),
                    m.rate("k"),
                    in_link(axis(k)),
                    m.op(")"),
                ),
                plus,
                m.sup(brackets(in_link(axis(i)), cross, spin("p")), transpose),
                I_s,
                brackets(spin("q")),
                m.op("}"),
            ),
            "3.4-27",
            "velocity torque from the links' rotational inertia",
        ),
        Equation(
            m.math(
                m.sub(m.name("c"), i),
                equals,
                m.op("−"),
                m.name("g"),
                dot,
                brackets(
                    axis(i),
                    cross,
                    m.total(start(j, i), n),
                    m.sub(m.name("m"), j),
                    m.op("("),
                    m.sub(m.over(m.name("r"), "¯"), j),
                    m.op("−"),
                    m.sub(m.name("p"), less(i)),
                    m.op(")"),
                ),
            ),
            "3.4-28",
            "gravity loading",
        ),
    )


def _label(n: int, i: int, j: int) -> str:
    low, high = min(i, j) + 1, max(i, j) + 1
    return f"D{low}{',' if high >= 10 else ''}{high}"
