"""The program as a process: exit codes, streams, signals, completion, and what it imports."""

from __future__ import annotations

import errno
import os
import re
import shlex
import shutil
import signal
import subprocess
import sys
import time
from contextlib import suppress
from pathlib import Path
from threading import Thread

import pytest

import gd_analyze as gd
from gd_analyze.cache import VARIABLE
from gd_analyze.cli.app import app
from gd_analyze.simplification.kept_program import kept_programs
from long_cases import long
from program import PROGRAM

SLOW = {"numpy", "scipy", "pandas", "xarray", "h5py", "matplotlib", "pinocchio"}
SLOW |= {"typst", "jinja2", "pydantic", "rich"}
POSIX = pytest.mark.skipif(sys.platform == "win32", reason="needs POSIX signals, terminals, streams")


@pytest.mark.parametrize("words", ["-h", "plan --help", long("simplify --help"), "--version"])
def test_help_imports_nothing_slow(process, words):
    before = f"""
import atexit, sys
atexit.register(lambda: print(*sorted({SLOW!r} & set(sys.modules)), file=sys.stderr))"""
    result = process(words, before=before)
    assert (result.code, result.err) == (0, "\n")
    assert result.out


@pytest.mark.parametrize(
    "words",
    [
        "simplify two_link",
        long("equations two_link"),
        long("export two_link --to c"),
        "plan two_link --from 0,0 --to 1,1 --duration 1",
    ],
)
def test_a_verb_without_tables_loads_no_library_of_tables(process, words):
    before = """
import atexit, sys
slow = {"xarray", "pandas", "dask", "matplotlib", "h5py"}
atexit.register(lambda: print("loaded:", *sorted(slow & set(sys.modules)), file=sys.stderr))"""
    result = process(words, before=before)
    assert result.code == 0
    assert result.err.splitlines()[-1].split() == ["loaded:"]


def test_tables_and_numbers_load_no_plots_and_no_pages(process):
    before = """
import atexit, sys
sys.modules |= {"dask": None, "pint": None}  # which xarray loads where they are installed, with SciPy
slow = {"matplotlib", "scipy", "jinja2", "typst", "h5py"}
atexit.register(lambda: print("loaded:", *sorted(slow & set(sys.modules)), file=sys.stderr))"""
    result = process("two_link two-link-swing --level element --format csv,json --quiet", before=before)
    assert result.code == 0
    assert result.err.splitlines()[-1].split() == ["loaded:"]


def test_no_arguments_show_the_help(process):
    result = process("")
    assert (result.code, result.out) == (2, "")
    assert result.err.startswith("Usage: gd-analyze ROBOT ")


def test_the_version_and_where_the_cache_is(run, monkeypatch):
    for named, told in (("/some/place", "/some/place"), ("off", "off"), ("", "off")):
        monkeypatch.setenv(VARIABLE, named)
        assert run("--version").out == f"gd-analyze {gd.__version__}\ncache {told}\n"


@pytest.mark.parametrize("words", [long("two_link two-link-swing"), "simplify two_link"])
def test_without_the_cache_nothing_is_kept_and_all_is_the_same(run, monkeypatch, tmp_path, words):
    def told(line: str) -> dict:
        kept_programs.cache_clear()
        result = run(f"{line} --json")
        assert result.code == 0, result.err
        return {key: value for key, value in result.json.items() if key not in ("provenance", "seconds")}

    monkeypatch.setenv(VARIABLE, str(tmp_path / "cache"))
    without = told(f"--no-cache {words}")
    assert not (tmp_path / "cache").exists()
    cold = told(words)
    assert any((tmp_path / "cache").iterdir())
    assert without == cold == told(words)


def test_the_package_runs_as_a_module():
    command = [sys.executable, "-m", "gd_analyze"]
    done = subprocess.run([*command, "--version"], capture_output=True, text=True, check=True)
    assert done.stdout.startswith(f"gd-analyze {gd.__version__}\n")
    refused = subprocess.run([*command, "arms", "nowhere.toml"], capture_output=True, text=True, check=False)
    assert (refused.returncode, "nowhere.toml" in refused.stderr) == (2, True)


def test_debug_adds_the_traceback(run):
    plain, debug = run("two_link nowhere.csv"), run("two_link nowhere.csv --debug")
    assert plain.code == debug.code == 2
    assert ("Traceback" in plain.err, "Traceback" in debug.err) == (False, True)


@pytest.mark.parametrize(
    ("failure", "says"),
    [
        (ZeroDivisionError("oh"), (": ZeroDivisionError: oh\n  next: ", "bug")),
        (MemoryError("7 TiB"), ("memory", "7 TiB", "--no-christoffel")),
    ],
)
def test_failures_of_the_program_and_the_machine(run, motion, monkeypatch, failure, says):
    def fail(*_, **__):
        raise failure

    monkeypatch.setattr("gd_analyze.studies.main_job.find", fail)
    result = run("two_link gentle.csv")
    assert (result.code, result.out) == (1, "")
    assert all(text in result.err for text in says)
    assert "Traceback" not in result.err


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs /dev/full, which stands for a full disk")
@pytest.mark.parametrize("unbuffered", ["", "1"])
def test_a_full_disk_behind_standard_output(process, monkeypatch, unbuffered):
    monkeypatch.setenv("PYTHONUNBUFFERED", unbuffered)
    with Path("/dev/full").open("w") as full:
        done = process("arms", stdout=full)
    assert done.code == 1
    assert done.err.startswith("error: ")
    assert os.strerror(errno.ENOSPC) in done.err
    assert "Traceback" not in done.err


@POSIX
def test_a_reader_that_leaves_early_is_no_error(process):
    read, write = os.pipe()
    os.close(read)
    done = process("arms puma560 --to toml", stdout=write)
    os.close(write)
    assert (done.code, done.err) == (-signal.SIGPIPE, "")


@POSIX
@pytest.mark.parametrize(
    ("words", "closed", "code", "says"),
    [
        ("arms puma560 --json", ">&-", 1, "not writable"),
        ("two_link -", "<&-", 2, "error: standard input: "),
        ("two_link nowhere.csv", "2>&-", 2, ""),
        ("two_link gentle.csv --format json --quiet", "<&- >&- 2>&-", 0, ""),
    ],
)
def test_closed_streams(motion, words, closed, code, says):
    program = f"{shlex.quote(sys.executable)} -c {shlex.quote(PROGRAM)}"
    done = subprocess.run(
        f"{program} {words} {closed}", shell=True, capture_output=True, text=True, check=False
    )
    assert done.returncode == code
    assert says in done.stderr
    assert "Traceback" not in done.stderr
    if code == 0:
        assert gd.load_model(Path("reports/two_link-gentle/model.json")).arm.name == "two_link"


@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), long(signal.SIGTERM, 143)])
def test_an_interrupted_run_cleans_up(process, motion, listing, number, code):
    """The signal comes while the HDF5 file is half written: nothing of it stays, nor the folder made for it.

    A run in the background of a shell ignores interrupts, and so would its children.
    """
    dying = f"""
import os, signal, time
signal.signal(signal.SIGINT, signal.default_int_handler)
from gd_analyze.results import store
def half(path, *rest):
    path.write_bytes(b"half")
    os.kill(os.getpid(), {int(number)})
    time.sleep(30)
store.write_tables = half"""
    result = process("two_link gentle.csv --out r", before=dying)
    assert (result.code, result.out) == (code, "")
    assert "Traceback" not in result.err
    assert listing() == {"gentle.csv"}


@POSIX
@pytest.mark.parametrize("delays", [(0.05, 0.15, 0.3, 0.8), long((0.1, 0.2, 0.5))], ids=["some", "others"])
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupt_at_any_time_shows_no_traceback_of_ours(here, number, delays):
    """From our first import to the end; the clock starts once Python runs, which a busy machine delays."""
    ready = "import signal, sys, gd_analyze\nsignal.signal(2, signal.default_int_handler)\n"
    ready += "sys.argv[0] = 'gd-analyze'\nprint('ready', flush=True)\n"
    command = [sys.executable, "-c", ready + PROGRAM]
    for delay in delays:
        work = subprocess.Popen(
            [*command, "rank-terms", "two_link", "two-link-swing"],
            stderr=subprocess.PIPE,
            stdout=subprocess.PIPE,
        )
        assert work.stdout.readline() == b"ready\n"
        time.sleep(delay)
        work.send_signal(number)
        errors = work.communicate(timeout=60)[1].decode()
        assert work.returncode in (0, 128 + number, -number)
        assert "Traceback" not in errors or "gd_analyze/" not in errors  # no frame, but Python's .pth of us


@pytest.mark.parametrize(("stop", "code"), [("KeyboardInterrupt", 130), long("SystemExit(143)", 143)])
@pytest.mark.parametrize(
    "wrapped", ["raise RuntimeError('in a class')", "raise ImportError('no array') from None"]
)
def test_a_signal_that_a_library_wraps_ends_as_the_signal(process, stop, code, wrapped):
    begin = f"""
def stopped(*_):
    try:
        raise {stop}
    except BaseException:
        {wrapped}
from gd_analyze.cli.given import GivenRobot
GivenRobot.load = stopped"""
    done = process("rank-terms two_link two-link-swing", before=begin)
    assert (done.code, done.out) == (code, "")
    assert "bug" not in done.err


@pytest.mark.slow
def test_signs_a_stream_cannot_show_break_nothing(process, motion, monkeypatch):
    monkeypatch.setenv("PYTHONIOENCODING", "ascii:strict")
    result = process("two_link gentle.csv --format csv")
    assert (result.code, result.err) == (0, "")


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux allows file names that are not text")
def test_a_name_that_is_no_text_is_refused(here):
    command = [os.fsencode(sys.executable), b"-c", PROGRAM.encode(), b"two_link", b"\xff.csv"]
    done = subprocess.run(command, capture_output=True, check=False)
    assert done.returncode == 2
    assert done.stderr.startswith(b"error: ")
    assert b"\\udcff.csv" in done.stderr


@pytest.fixture
def on_terminal(process, monkeypatch):
    """Run the program with standard error on a terminal, and return what is shown there, too."""
    import pty  # which Windows has not

    monkeypatch.setenv("TERM", "xterm-256color")

    def call(words: str):
        terminal, far_end = pty.openpty()
        chunks = []

        def read() -> None:  # while the program writes: the terminal holds a few kilobytes
            with suppress(OSError):  # Linux: the far end is closed
                while chunk := os.read(terminal, 65536):
                    chunks.append(chunk)

        reader = Thread(target=read)
        reader.start()
        try:
            done = process(words, stderr=far_end)
        finally:
            os.close(far_end)
            reader.join()
            os.close(terminal)
        return done, b"".join(chunks).decode()

    return call


@POSIX
@pytest.mark.parametrize("quiet", ["", long("--quiet")])
def test_progress_on_a_terminal_and_not_when_quiet(on_terminal, motion, quiet):
    done, shown = on_terminal(f"two_link gentle.csv --format json --json {quiet}")
    assert done.code == 0
    assert done.json
    assert ("reading" in shown) == (not quiet)
    # The first answer stands above the progress while models are searched.
    assert ("Verdicts at 1%" in shown) == (not quiet)


@pytest.mark.parametrize("quiet", ["", long("--quiet")])
def test_without_a_terminal_long_work_tells_each_stage_in_a_line(process, motion, quiet):
    done = process(f"two_link gentle.csv --format json {quiet}", silent=0)
    told = [line.split(", after ")[0] for line in done.err.splitlines()]
    assert done.code == 0
    assert told[:2] == ([] if quiet else ["reading", "decomposing"])
    assert told[-1:] == ([] if quiet else ["writing json"])
    assert "\x1b" not in done.err
    assert process("rank-terms two_link gentle.csv").err == ""


@POSIX
@pytest.mark.parametrize("terminal", [False, long(True)])
def test_long_work_tells_its_warnings_while_it_lasts(on_terminal, process, here, terminal):
    """A wrong unit is known in a second, a search may take minutes: one need not wait for its end."""
    rows = "".join(f"{0.1 * k},{0.3 * k * k},{0.02 * k}\n" for k in range(31))
    (here / "far.csv").write_text(f"time,q1,q2\n{rows}")
    words = "two_link far.csv --format json"
    if terminal:
        done, shown = on_terminal(words)
        plain = re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "", shown)
        assert plain.index("warning: ") < plain.index("Verdicts at")
    else:
        done = process(words, silent=0)
        stages = done.err.splitlines()
        warned = [k for k, line in enumerate(stages) if line.startswith("warning: ")]
        assert warned
        assert max(warned) < stages.index(next(line for line in stages if line.startswith("writing json")))
        assert len(set(stages)) == len(stages)
    assert done.code == 0


def test_a_stage_that_goes_on_is_told_without_a_new_one(process):
    slow = "import time\nfrom gd_analyze.cli.given import GivenRobot\nload = GivenRobot.load\n"
    slow += "GivenRobot.load = lambda *a, **k: time.sleep(1.5) or load(*a, **k)"
    told = process("simplify two_link two-link-swing", before=slow, silent=0.5).err
    assert told.startswith("reading, after ")


@POSIX
@pytest.mark.parametrize("terminal", [False, True])
def test_a_batch_tells_how_many_rows_are_done(on_terminal, process, here, terminal):
    """Also of those that failed, or that an earlier run did."""
    rows = ["two_link,two-link-swing,element", "two_link,none.csv,element", "two_link,two-link-swing,element"]
    (here / "rows.csv").write_text("\n".join(["arm,trajectory,level", *rows, ""]))
    words = "batch rows.csv --format none"
    if terminal:
        done, shown = on_terminal(words)
        assert "3 of 3 rows" in shown
    else:
        told = process(words, silent=0, before="terminal.REPEATED_AFTER_SECONDS = 0")
        counts = re.findall(r"^analysing, (.*), after \d+ s$", told.err, re.M)
        assert counts == ["1 of 3 rows", "2 of 3 rows, 1 failed", "3 of 3 rows, 1 failed"]
        done = process(words)
    assert done.code == 1


@POSIX
def test_errors_are_wrapped_on_a_terminal_only(on_terminal, process):
    words = f"columns two_link {'a' * 40}.csv"
    done, shown = on_terminal(words)
    plain = re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "", shown)
    plain = plain[plain.rindex("error: ") :]
    assert done.code == 2
    assert max(map(len, plain.splitlines())) <= 80
    piped = process(words).err
    assert len(plain.splitlines()) > len(piped.splitlines())
    assert plain.split() == piped.split()


VERBS = [name for name, command in app.commands.items() if not command.hidden]


@pytest.mark.parametrize(
    ("words", "last", "offered"),
    [
        ("", "", [*gd.builtin_arms(), *VERBS]),
        ("", "pu", ["puma560"]),
        ("puma560 pick-and-place", "--no-c", ["--no-christoffel", "--no-cache"]),
        ("plan two_link --profile", "c", ["cubic"]),
        ("evaluate model.json", "wr", ["wrist-move"]),
        ("two_link x.csv --format", "h5,h", ["h5,html"]),
    ],
)
def test_completion(process, monkeypatch, words, last, offered):
    """What the program offers for the last word, by the protocol of the fish script."""
    monkeypatch.setenv("_GD_ANALYZE_COMPLETE", "fish_complete")
    monkeypatch.setenv("COMP_WORDS", f"gd-analyze {words}".rstrip())
    monkeypatch.setenv("COMP_CWORD", last)
    result = process("")
    assert result.err == ""
    kinds = [entry.split(",", 1) for entry in result.out.split("\n") if "," in entry]
    assert [value.split("\t")[0] for kind, value in kinds if kind == "plain"] == offered


@pytest.mark.skipif(shutil.which("bash") is None, reason="runs the script in bash, which is not installed")
def test_the_completion_script_works_in_bash(here):
    program = here / "bin" / "gd-analyze"
    program.parent.mkdir()
    program.write_text(f"#!{sys.executable}\n{PROGRAM}\n")
    program.chmod(0o755)
    script = """
eval "$(gd-analyze completion bash)"
compopt() { :; }  # works during a completion only
COMP_WORDS=(gd-analyze puma560 pi) COMP_CWORD=2 COMPREPLY=()
_gd_analyze_completion gd-analyze
echo "${COMPREPLY[*]}"
"""
    path = {"PATH": f"{program.parent}:{os.environ['PATH']}"}
    command = ["bash", "-euc", script]
    done = subprocess.run(command, capture_output=True, text=True, check=False, env=os.environ | path)
    assert (done.stdout, done.stderr) == ("pick-and-place\n", "")
