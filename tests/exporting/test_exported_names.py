"""Names from outside stay in their comments: what is printed around them is what is always printed."""

from __future__ import annotations

import re
import shutil
import subprocess

import pytest
from compiled import STRICT, called, needs_gcc, needs_gpp
from exported_cases import subject
from hostile import HOSTILE, NAMES, hostile, renamed
from hypothesis import given
from hypothesis import strategies as st

from gd_analyze.exporting.export import printed
from gd_analyze.exporting.export_input import ExportInput
from gd_analyze.exporting.foreign import comment, tex
from gd_analyze.exporting.identifiers import LONGEST, RESERVED, identifier, identifiers
from gd_analyze.exporting.languages import LANGUAGES
from strategies import examples

CODE = tuple(language for language in LANGUAGES if language != "latex")


def subjects() -> list[ExportInput]:
    return [hostile(*place) for place in HOSTILE]


def code_of(what: ExportInput, language: str) -> list[str]:
    """What is printed, without comments, joints by number."""
    texts = []
    for name, text in printed(what, language).files.items():
        if name.endswith(".py"):
            # The first string is the module's text; what follows is ours.
            _, _, text = text.removeprefix('"""').partition('"""\n')
        elif name.endswith(".m"):
            text = re.sub(r"^%.*$", "", text, flags=re.MULTILINE)
        else:
            text = re.sub(r"/\*.*?\*/", "", text, flags=re.DOTALL)
        for k, word in sorted(enumerate(what.joints), key=lambda pair: -len(pair[1])):
            text = re.sub(rf"(joint_|'){word}(?=[ ,']|$)", rf"\g<1>number {k}", text, flags=re.MULTILINE)
        texts.append(text.replace(what.name, "NAME").replace(what.name.upper(), "NAME"))
    return texts


@pytest.mark.parametrize("language", CODE)
@pytest.mark.parametrize("case", ["two_link energy", "puma560", "two_link decomposition"])
def test_the_code_is_the_same_whatever_the_names(case, language):
    plain = subject(case)
    expected = code_of(plain, language)
    for k in range(len(NAMES)):
        assert code_of(renamed(plain, NAMES[k:] + NAMES[:k]), language) == expected


@examples(25)
@given(st.lists(st.text(max_size=40), min_size=9, max_size=9), st.sampled_from(CODE))
def test_so_it_is_with_any_names(names, language):
    plain = subject("two_link energy")
    assert code_of(renamed(plain, names), language) == code_of(plain, language)


@examples(300)
@given(st.text())
def test_a_comment_holds_nothing_that_acts(text):
    for said in (comment(text), comment(f"{text}*/"), comment("x" * 300 + text)):
        assert re.fullmatch(r"[ -~]*", said)
        assert not re.search(r'[*\\?"`]', said)
        assert len(said) <= 120 * len("<U+10FFFF>")
    # Backslashes and braces that stand for a sign are all there are; every brace that opens is closed.
    plain = re.sub(r"\\text(asciitilde|asciicircum|less|greater|bar)\{\}|\\[#$%&_{}]", "", tex(text))
    assert not re.search(r"[\\{}#$%&_^~<>|]", plain)


@examples(300)
@given(st.lists(st.text() | st.sampled_from(sorted(RESERVED)) | st.sampled_from(NAMES), max_size=8))
def test_identifiers_are_safe_and_unique(names):
    words = identifiers(names)
    assert len({word.lower() for word in words}) == len(names)
    for name, word in zip(names, words, strict=True):
        assert re.fullmatch(r"[A-Za-z][A-Za-z0-9]*(_[A-Za-z0-9]+)*", word)
        assert word not in RESERVED
        # Two words that are alike get a number behind.
        assert len(word) <= LONGEST + 2
        again = identifier(name)
        assert len(again) <= LONGEST
        assert identifier(again) == again


@pytest.mark.parametrize(("case", "first"), HOSTILE)
def test_the_header_lists_what_became_what(case, first):
    what = hostile(case, first)
    text = next(iter(printed(what, "c").files.values()))
    listed = re.findall(r"^ \*   (\d): (\w+)(?: \(named (.*)\))? (?:turns|slides): ", text, re.MULTILINE)
    assert [(int(k), word) for k, word, _ in listed] == list(enumerate(what.joints, start=1))
    for (_, word, told), joint in zip(listed, what.arm.joints, strict=True):
        assert told == ("" if word == joint.name else comment(joint.name))


@needs_gcc
def test_c_compiles_and_trigraphs_are_none(tmp_path):
    for what in subjects():
        printed(what, "c").save(tmp_path)
    sources = sorted(tmp_path.glob("*.c"))
    called("gcc", "-std=c99", *STRICT, "-fsyntax-only", *sources)


@needs_gpp
def test_cpp_compiles(tmp_path):
    for what in subjects():
        printed(what, "cpp").save(tmp_path)
    lines = [f'#include "{what.name}.hpp"\n' for what in subjects()]
    (tmp_path / "main.cpp").write_text("".join(lines))
    called("g++", "-std=c++11", *STRICT, "-fsyntax-only", tmp_path / "main.cpp")


@pytest.mark.parametrize("language", ["python", "jax", "casadi"])
def test_python_runs(language, tmp_path, monkeypatch):
    pytest.importorskip({"python": "numpy"}.get(language, language))
    monkeypatch.chdir(tmp_path)
    for what in subjects()[::3]:
        (text,) = printed(what, language).files.values()
        names: dict[str, object] = {}
        exec(compile(text, what.name, "exec"), names)
        assert names["JOINTS"] == what.joints
    assert not list(tmp_path.iterdir())


@pytest.mark.skipif(
    shutil.which("octave") is None, reason="octave, which is too large to be installed for this, is not there"
)
def test_octave_runs(tmp_path):
    lines = []
    for what in subjects():
        printed(what, "matlab").save(tmp_path)
        zeros = ", ".join([f"zeros({what.n}, 1)"] * (3 if what.torque else 2))
        lines.append(f"{what.name}({zeros});")
    (tmp_path / "every_name.m").write_text("\n".join([*lines, "printf('done');"]))
    before = sorted(tmp_path.iterdir())
    done = subprocess.run(
        ["octave", "--no-gui", "--no-init-file", "--quiet", "every_name.m"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.stdout.endswith("done")
    assert "warning: " not in done.stderr
    assert sorted(tmp_path.iterdir()) == before
