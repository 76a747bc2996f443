"""Commands and Python blocks of README and docs run in order, a folder per page, and print what is shown.

Pages that take a few seconds run always, the others and README in the long tests. Of all pages every command
is parsed and every Python block compiled.
"""

from __future__ import annotations

import os
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from markdown_pages import ROOT, Block, blocks

from gd_analyze.cli import main
from gd_analyze.cli.app import app
from long_cases import long

NOT_RUN, PRINTED = "not run", "printed"
README = ROOT / "README.md"


def commands(block: Block) -> list[str]:
    """The block's `gd-analyze` commands, continuation lines joined."""
    lines = block.text.replace("\\\n", " ").splitlines()
    return [line for line in lines if line.startswith("gd-analyze ")]


def runnable(path: Path) -> list[Block]:
    return [
        block
        for block in blocks(path)
        if block.marked != NOT_RUN
        and (block.language == "python" or (block.language == "sh" and commands(block)))
    ]


# The gallery's commands are run by analysis/gallery.py, which writes the page.
PAGES = [README] + [
    page for page in sorted((ROOT / "docs").rglob("*.md")) if runnable(page) and page.name != "gallery.md"
]
# Pages whose blocks take a few seconds at most.
QUICK = {"arms.md", "batch.md", "equations.md", "evaluation.md", "formulations.md"}


def name_of(page: Path) -> str:
    return str(page.relative_to(ROOT))


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with data beside it as in a checkout, the tutorials' robot and log; the current one."""
    work = tmp_path / "work"
    shutil.copytree(ROOT / "data", work / "data")
    for file in ("my_robot.urdf", "log.csv"):
        shutil.copy(ROOT / "docs" / "tutorials" / file, work)
    monkeypatch.chdir(work)
    monkeypatch.syspath_prepend(work)  # as of a script in that folder
    monkeypatch.setenv("COLUMNS", "80")
    return work


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="the page's commands are for a POSIX shell")
def test_the_readme_runs_in_a_shell(folder: Path):
    program = folder.parent / "bin" / "gd-analyze"
    program.parent.mkdir()
    program.write_text(f"#!{sys.executable}\nfrom gd_analyze.cli import main\nmain()\n")
    program.chmod(0o755)
    environment = os.environ | {"PATH": f"{program.parent}{os.pathsep}{os.environ['PATH']}"}
    assert runnable(README)
    for block in runnable(README):
        calls = [[sys.executable, "-c", block.text]]
        if block.language == "sh":
            calls = [["sh", "-ec", command] for command in commands(block)]
        for call in calls:
            done = subprocess.run(call, env=environment, capture_output=True, text=True, check=False)
            assert done.returncode == 0, f"line {block.line}:\n{call[-1]}\n{done.stderr}"
            assert "Traceback" not in done.stderr
    assert (folder / "controller" / "my_robot.c").exists()


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_the_blocks_can_be_parsed(page: Path, folder: Path):
    for block in runnable(page):
        if block.language == "python":
            compile(block.text, f"{page.name}, line {block.line}", "exec")
            continue
        for command in commands(block):
            words = shlex.split(command, comments=True)[1:]
            context = app.make_context("gd-analyze", words)
            name, verb, rest = app.resolve_command(context, [*context._protected_args, *context.args])
            verb.make_context(name, rest, parent=context)


@pytest.mark.parametrize(
    "page",
    [page if page.name in QUICK else long(page) for page in PAGES],
    ids=name_of,
)
def test_the_blocks_run(page: Path, folder: Path, capsys: pytest.CaptureFixture[str]):
    for block in runnable(page):
        if block.language == "python":
            exec(compile(block.text, f"{page.name}, line {block.line}", "exec"), {"__name__": "__main__"})
            continue
        for command in commands(block):
            main(shlex.split(command, comments=True)[1:])
    lines = {"...", *capsys.readouterr().out.splitlines()}
    for block in blocks(page):
        if block.marked == PRINTED:
            assert [line for line in block.text.splitlines() if line not in lines] == [], f"line {block.line}"
