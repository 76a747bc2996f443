"""Lines cut out of a text are those that splitting it gives."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from gd_analyze.motions.csv_lines import Lines
from strategies import examples

texts = st.lists(st.sampled_from(["", "a", "1,2", "é,3", "# gap", "\n", "\r", "\r\n", "\u2028", "\x0b"])).map(
    "".join
)


@examples(100)
@given(texts, st.booleans(), st.data())
def test_lines_are_those_of_the_text(text, marked, data):
    wanted = text.replace("\r\n", "\n").replace("\r", "\n").split("\n")
    lines = Lines(text.encode("utf-8-sig" if marked else "utf-8"))
    assert [*lines] == wanted
    assert len(lines) == len(wanted)
    assert [lines[k] for k in range(-len(lines), len(lines))] == wanted * 2
    assert [*lines[1:]] == wanted[1:]
    some = data.draw(st.lists(st.integers(0, len(lines) - 1)))
    assert [*lines.at(some)] == [wanted[k] for k in some]
