"""The program as a process: exit codes, streams, signals, and what it imports."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import pytest

import gd_analyze as gd

SLOW = ("numpy", "scipy", "pandas", "xarray", "h5py", "matplotlib", "pinocchio", "plotly", "typst", "jinja2")
SLOW = (*SLOW, "pydantic", "rich")


@pytest.mark.parametrize("words", ["['-h']", "['plan', '--help']", "['--version']"])
def test_help_imports_nothing_slow(process, words):
    result = process(
        before=f"""
import sys
sys.argv[1:] = {words}
import atexit
atexit.register(lambda: print(*sorted({set(SLOW)!r} & set(sys.modules)), file=sys.stderr))"""
    )
    assert result.code == 0
    assert result.out
    assert result.err == "\n"


def test_no_arguments_show_the_help(process):
    result = process()
    assert (result.code, result.out) == (2, "")
    assert result.err.startswith("Usage: gd-analyze ROBOT TRAJECTORY")


def test_the_version_and_where_the_cache_is(run, monkeypatch):
    from gd_analyze import __version__
    from gd_analyze.simplification.cache import VARIABLE

    for named, told in (("/some/place", "/some/place"), ("off", "off"), ("", "off")):
        monkeypatch.setenv(VARIABLE, named)
        assert run("--version").out == f"gd-analyze {__version__}\ncache {told}\n"


@pytest.mark.parametrize(
    "words", [("--no-cache", "two_link", "two-link-swing"), ("simplify", "two_link", "--no-cache")]
)
def test_without_the_cache_nothing_is_kept_and_all_is_the_same(run, monkeypatch, tmp_path, words):
    from gd_analyze.simplification.cache import VARIABLE
    from gd_analyze.simplification.program_cache import kept_programs

    def told(*given: str) -> dict:
        kept_programs.cache_clear()
        result = run(*given, "--json")
        assert result.code == 0, result.err
        return {key: value for key, value in result.json.items() if key not in ("provenance", "seconds")}

    monkeypatch.setenv(VARIABLE, str(tmp_path / "cache"))
    without = told(*words)
    assert not (tmp_path / "cache").exists()
    with_it = [word for word in words if word != "--no-cache"]
    cold = told(*with_it)
    assert any((tmp_path / "cache").iterdir())
    warm = told(*with_it)
    assert without == cold == warm


@pytest.mark.parametrize("words", [("two_link", "nowhere.csv"), ("pln",)])
def test_debug_adds_the_traceback(run, words):
    plain, debug = run(*words), run(*words, "--debug")
    assert plain.code == debug.code == 2
    assert "Traceback" not in plain.err
    assert "Traceback" in debug.err


def test_a_bug_is_called_a_bug(process, motion):
    before = """
import gd_analyze as gd
def load_arm(name, **picked): raise ZeroDivisionError('oh')
gd.load_arm = load_arm"""
    result = process("two_link", motion, before=before)
    assert (result.code, result.out) == (1, "")
    assert result.err.startswith("error: ZeroDivisionError: oh\n  where: ")
    assert "this is a bug in gd-analyze" in result.err
    assert "Traceback" not in result.err
    debug = process("two_link", motion, "--debug", before=before)
    assert debug.code == 1
    assert "Traceback" in debug.err


def test_out_of_memory_is_no_bug(process, motion):
    before = "import gd_analyze as gd\ndef find(*a, **k): raise MemoryError('7 TiB')\ngd.find = find"
    result = process("two_link", motion, before=before)
    assert result.code == 1
    assert "out of memory" in result.err
    assert "--no-christoffel" in result.err


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="/dev/full plays the full disk, and is not there")
def test_a_full_disk_behind_standard_output(here):
    code = "from gd_analyze.cli import main; main()"
    with Path("/dev/full").open("w") as full:
        done = subprocess.run(
            [sys.executable, "-c", code, "arms"], stdout=full, stderr=subprocess.PIPE, text=True, check=False
        )
    assert done.returncode == 1
    assert "error: the system refused" in done.stderr
    assert "Traceback" not in done.stderr


@pytest.mark.skipif(not hasattr(signal, "SIGPIPE"), reason="without SIGPIPE no reader can leave early")
def test_a_reader_that_leaves_early_is_no_error(here):
    code = "from gd_analyze.cli import main; main()"
    words = [sys.executable, "-c", code, "arms", "puma560", "--to", "toml"]
    read, write = os.pipe()
    os.close(read)
    done = subprocess.run(words, stdout=write, stderr=subprocess.PIPE, text=True, check=False)
    os.close(write)
    assert done.returncode == -signal.SIGPIPE
    assert done.stderr == ""


@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_an_interrupted_run_cleans_up(process, motion, listing, number, code):
    """The signal comes while the HDF5 file is half written: nothing of it stays."""
    result = process("two_link", motion, "--out", "r", before=dying(number))
    assert result.code == code
    assert result.out == ""
    assert "Traceback" not in result.err
    assert listing() == {"gentle.csv", "r"}


def dying(number: int) -> str:
    """Code that makes the process send itself a signal in the middle of writing.

    A run in the background of a shell ignores interrupts, and so would its children.
    """
    return f"""
import os, signal, time
signal.signal(signal.SIGINT, signal.default_int_handler)
from gd_analyze.results import store
def half(path, *rest):
    path.write_bytes(b"half")
    os.kill(os.getpid(), {int(number)})
    time.sleep(30)
store.write_tables = half"""


def test_signs_a_stream_cannot_show_break_nothing(process, motion, monkeypatch):
    monkeypatch.setenv("PYTHONIOENCODING", "ascii:strict")
    result = process("two_link", motion, "--format", "csv")
    assert (result.code, result.err) == (0, "")


@pytest.mark.skipif(sys.platform != "linux", reason="on Linux only may a name be no text")
def test_a_name_that_is_no_text_is_refused(here):
    code = "from gd_analyze.cli import main; main()"
    done = subprocess.run(
        [os.fsencode(sys.executable), b"-c", code.encode(), b"two_link", b"\xff.csv"],
        capture_output=True,
        check=False,
    )
    assert done.returncode == 2
    assert done.stderr.startswith(b"error: a word of the command is not text")


@pytest.mark.skipif(sys.platform == "win32", reason="pty plays the terminal; Windows has none")
@pytest.mark.parametrize("flags", [(), ("--quiet",)])
def test_progress_on_a_terminal_only_and_not_when_quiet(here, motion, flags, monkeypatch):
    import pty

    monkeypatch.setenv("TERM", "xterm-256color")
    terminal, far_end = pty.openpty()
    code = "from gd_analyze.cli import main; main()"
    done = subprocess.run(
        [sys.executable, "-c", code, "two_link", str(motion), "--format", "json", "--json", *flags],
        stdout=subprocess.PIPE,
        stderr=far_end,
        check=False,
    )
    os.close(far_end)
    shown = b""
    try:
        while chunk := os.read(terminal, 65536):
            shown += chunk
    except OSError:  # Linux: the far end is closed
        pass
    os.close(terminal)
    assert done.returncode == 0
    assert done.stdout.startswith(b"{")
    assert (b"reading" in shown) == (not flags)


VERBS = ["report", "arms", "columns", "plan", "simplify", "rank", "trade-off", "evaluate", "validate"]
VERBS += ["equations", "compare", "certify", "control", "export", "completion"]


@pytest.mark.parametrize(
    ("words", "offered"),
    [
        ([""], [*gd.builtin_arms(), *VERBS]),
        (["pu"], ["puma560"]),
        (["puma560", "pick-and-place", "--no-c"], ["--no-christoffel", "--no-cache"]),
        (["plan", "two_link", "--profile", "c"], ["cubic"]),
        (["evaluate", "model.json", "wr"], ["wrist-move"]),
        (["two_link", "x.csv", "--format", "h5,h"], ["h5,html"]),
    ],
)
def test_completion(process, monkeypatch, words, offered):
    """What the program offers for the last word, by the protocol of the fish script."""
    *before, last = words
    monkeypatch.setenv("_GD_ANALYZE_COMPLETE", "fish_complete")
    monkeypatch.setenv("COMP_WORDS", " ".join(["gd-analyze", *before]))
    monkeypatch.setenv("COMP_CWORD", last)
    result = process()
    assert result.err == ""
    kinds = [entry.split(",", 1) for entry in result.out.split("\n") if "," in entry]
    assert [value.split("\t")[0] for kind, value in kinds if kind == "plain"] == offered


@pytest.mark.skipif(shutil.which("bash") is None, reason="runs the script in bash, which is not installed")
def test_the_completion_script_works_in_bash(here):
    program = here / "bin" / "gd-analyze"
    program.parent.mkdir()
    program.write_text(f"#!{sys.executable}\nfrom gd_analyze.cli import main\nmain()\n")
    program.chmod(0o755)
    script = """
eval "$(gd-analyze completion bash)"
compopt() { :; }  # works during a completion only
COMP_WORDS=(gd-analyze puma560 pi) COMP_CWORD=2 COMPREPLY=()
_gd_analyze_completion gd-analyze
echo "${COMPREPLY[*]}"
"""
    path = {"PATH": f"{program.parent}:{os.environ['PATH']}"}
    done = subprocess.run(
        ["bash", "-euc", script], capture_output=True, text=True, check=False, env=os.environ | path
    )
    assert (done.stdout, done.stderr) == ("pick-and-place\n", "")
