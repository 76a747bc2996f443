"""Every language through its class: names from outside, operations counted in the text, whole texts."""

from __future__ import annotations

import os
import re
import subprocess
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from exported_cases import CASES, HOSTILE, NAMES, hostile, proven, renamed, round_model, subject
from gd_analyze import __version__
from gd_analyze.exporting.export import CLASSES, written
from gd_analyze.exporting.export_input import ExportInput
from gd_analyze.exporting.names import (
    ALL_RESERVED,
    LANGUAGES,
    LONGEST_NAME,
    RESERVED,
    identifier,
    identifiers,
)
from gd_analyze.operations.program import OperationCount
from long_cases import long
from running import STRICT, called, needs_gcc, needs_gpp
from strategies import examples

CODE = tuple(language for language in LANGUAGES if language != "latex")
GOLDEN = Path(__file__).parent / "golden"
UPDATE = "GD_ANALYZE_UPDATE_GOLDEN"
# How a function begins and ends; its body is what stands between.
BODIES = {
    "c": r"^void {1}_{0}\([^;]*?\)\n\{{(.*?)^\}}",
    "cpp": r"^void {}\([^;]*?\)\n\{{(.*?)^\}}",
    "python": r"^def {}\((.*?)^    return ",
    "jax": r"^def {}\((.*?)^    return ",
    "casadi": r"^def _{}\((.*?)^    return ",
    "sympy": r"^def {}\((.*?)^    return ",
    "matlab": r"^function [^\n]* = {1}_{0}\((.*?)^end",
}


def is_quick(case: str, language: str) -> bool:
    """C and Python of all but further functions, whose programs of six joints take long to write."""
    return language in ("c", "python") and not case.endswith("further")


def code_of(what: ExportInput, language: str) -> list[str]:
    """The texts without their header and comments, joints by number."""
    opening, prefix, closing = (part.strip() for part in CLASSES[language].comment)
    comment = rf"{re.escape(opening)}.*?{re.escape(closing)}" if closing else rf"^{re.escape(prefix)}[^\n]*$"
    texts = []
    for text in written(what, language).files.values():
        # Functions have strings of their own in Python; the first is what holds names.
        code = re.sub(comment, "", text, count=closing == '"""', flags=re.DOTALL | re.MULTILINE)
        for k, word in sorted(enumerate(what.joints), key=lambda pair: -len(pair[1])):
            code = re.sub(rf"(joint_|'){word}(?=[ ,']|$)", rf"\g<1>number {k}", code, flags=re.MULTILINE)
        texts.append(code.replace(what.name, "NAME").replace(what.name.upper(), "NAME"))
    return texts


@pytest.mark.parametrize("language", CODE)
@pytest.mark.parametrize("case", ["two_link energy", "puma560", "two_link decomposition"])
def test_the_code_is_the_same_whatever_the_names(case, language):
    plain = subject(case)
    expected = code_of(plain, language)
    for k in range(0, len(NAMES), 5):
        assert code_of(renamed(plain, NAMES[k:] + NAMES[:k]), language) == expected


@needs_gcc
@needs_gpp
@pytest.mark.parametrize(("language", "compiler"), [("c", "gcc"), ("cpp", "g++")])
def test_what_a_compiler_refuses_as_a_name_is_reserved(language, compiler):
    """Of the words of all languages: `int WORD;` line by line, whose errors name their lines."""
    words = sorted(ALL_RESERVED)
    kind = ["-std=c2x", "-xc"] if language == "c" else ["-std=c++20", "-xc++"]
    text = "".join(f"void f{k}(void) {{ int {word} = 0; (void){word}; }}\n" for k, word in enumerate(words))
    options = [compiler, *kind, "-fsyntax-only", "-fmax-errors=0", "-"]
    done = subprocess.run(options, input=text, capture_output=True, text=True, check=False)
    lines = {int(line) for line in re.findall(r"<stdin>:(\d+):\d+: error", done.stderr)}
    assert {words[line - 1] for line in lines} <= set(RESERVED[language].lower().split())
    assert len(lines) > 30


@examples(200)
@given(st.text(), st.sampled_from(LANGUAGES))
def test_a_comment_holds_nothing_that_acts(text, name):
    language = CLASSES[name]()
    for said in (language.foreign(text), language.foreign(f"{text}*/"), language.foreign("x" * 300 + text)):
        assert re.fullmatch(r"[ -~]*", said)
        assert not re.search(r'[*\\?"`]', said)
        assert len(said) <= 120 * len("<U+10FFFF>")
    # Backslashes and braces that stand for a sign are all there are; every brace that opens is closed.
    tex = CLASSES["latex"]().tex(text)
    plain = re.sub(r"\\text(asciitilde|asciicircum|less|greater|bar)\{\}|\\[#$%&_{}]", "", tex)
    assert not re.search(r"[\\{}#$%&_^~<>|]", plain)


@examples(200)
@given(st.lists(st.text() | st.sampled_from(sorted(ALL_RESERVED)) | st.sampled_from(NAMES), max_size=8))
def test_identifiers_are_safe_and_unique(names):
    words = identifiers(names)
    assert len({word.lower() for word in words}) == len(names)
    for name, word in zip(names, words, strict=True):
        assert re.fullmatch(r"[A-Za-z][A-Za-z0-9]*(_[A-Za-z0-9]+)*", word)
        assert word.lower() not in ALL_RESERVED
        # Two words that are alike get a number behind.
        assert len(word) <= LONGEST_NAME + 2
        again = identifier(name)
        assert len(again) <= LONGEST_NAME
        assert identifier(again) == again


@pytest.mark.parametrize(("case", "first"), HOSTILE[::4])
def test_the_header_lists_what_became_what(case, first):
    what = hostile(case, first)
    text = next(iter(written(what, "c").files.values()))
    listed = re.findall(r"^ \*   (\d): (\w+)(?: \(named (.*)\))?, \w+: q in", text, re.MULTILINE)
    assert [(int(k), word) for k, word, _ in listed] == list(enumerate(what.joints, start=1))
    for (_, word, said), joint in zip(listed, what.arm.joints, strict=True):
        assert said == ("" if word == joint.name else CLASSES["c"]().foreign(joint.name))


@needs_gcc
@needs_gpp
def test_compilers_take_any_names(tmp_path):
    subjects = [hostile(*place) for place in HOSTILE if place[0] != "two_link decomposition"]
    for what in subjects:
        written(what, ["c", "cpp"]).save(tmp_path)
    called("gcc", "-std=c99", *STRICT, "-fsyntax-only", *sorted(tmp_path.glob("*.c")))
    lines = [f'#include "{what.name}.hpp"\n' for what in subjects]
    (tmp_path / "main.cpp").write_text("".join(lines))
    called("g++", "-std=c++11", *STRICT, "-fsyntax-only", tmp_path / "main.cpp")


@pytest.mark.parametrize("language", ["python", "jax", "casadi", "sympy"])
def test_python_takes_any_names(language, tmp_path, monkeypatch):
    pytest.importorskip({"python": "numpy"}.get(language, language))
    monkeypatch.chdir(tmp_path)
    for place in HOSTILE[::6]:
        what = hostile(*place)
        (text,) = written(what, language).files.values()
        names: dict[str, object] = {}
        exec(compile(text, what.name, "exec"), names)
        assert names["JOINTS"] == what.joints
    assert not list(tmp_path.iterdir())


# Every language of the two-link arm's cases, every other case in two languages.
COUNTED = [
    (case, language) if case.startswith("two_link") or is_quick(case, language) else long(case, language)
    for case in CASES
    for language in CODE
]


@pytest.mark.parametrize(("case", "language"), COUNTED)
def test_operations_that_stand_there_are_those_that_are_stated(case, language):
    what = subject(case)
    *_, text = written(what, language).files.values()
    for function in what.functions:
        # MATLAB's file is a function, too, which calls the others.
        *_, body = re.findall(
            BODIES[language].format(function.name, what.name), text, re.DOTALL | re.MULTILINE
        )
        code = re.sub(r'""".*?"""|^%.*?$', "", body, flags=re.DOTALL | re.MULTILINE)
        compiled = language in ("c", "cpp")
        sines = r" = (?:co)?sine\[" if compiled else r"\b(?:sin|cos)\("
        counts = (len(re.findall(pattern, code)) for pattern in (r" \.?[*/] ", r" [+-] ", sines))
        counts = OperationCount(*counts)
        if compiled:  # with sines of sums where that saves a block
            angles, rest, *_ = CLASSES[language]().one_by_one(function)
            used = [x for x in rest.inputs if x.kind in ("sin", "cos")]
            programs = [rest.program, *(each.program for _, each, _ in angles)]
            assert counts.sines_cosines == len(used)
            assert counts.total == sum(program.count.total for program in programs), function.name
        else:
            assert counts == function.count, function.name


def test_texts_are_as_they_were(two_link):
    """Of languages that few machines run here, and C; `GD_ANALYZE_UPDATE_GOLDEN=1` writes them anew."""
    found = {}
    for name, text in written(proven(round_model(two_link)), LANGUAGES).files.items():
        assert not re.search(r"20\d\d-\d\d|/home|/tmp|/work|[^\n -~]| \n|[^\n]\Z", text)
        # Our version, and the hash of the file, which holds it.
        text = text.replace(f"gd-analyze {__version__}", "gd-analyze VERSION")
        if Path(name).suffix in (".c", ".h", ".m", ".tex"):
            found[name] = re.sub(r"(model file:\n\W*)[0-9a-f]{64}", r"\1HASH", text)
    if os.environ.get(UPDATE):
        for name, text in found.items():
            (GOLDEN / name).write_text(text, encoding="ascii")
        pytest.skip("written anew: look at what git says has changed")
    stored = {path.name: path.read_text(encoding="ascii") for path in GOLDEN.glob("*")}
    assert sorted(stored) == sorted(found)
    for name, text in found.items():
        assert text == stored[name], f"{name} has changed; if it should, set {UPDATE}=1 and look at it"
