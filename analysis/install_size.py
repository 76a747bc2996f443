"""Size of every dependency, and what installing takes, written into `install_size.md` beside this file.

Run it with the Python of an environment that holds `pip install .` and nothing else: `python analysis/install_size.py`.
Packages should be in the caches of pip and uv already.
"""

from __future__ import annotations

import re
import resource
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path

from gd_analyze.files import write_text

ROOT = Path(__file__).parents[1]
PAGE = Path(__file__).with_suffix(".md")
COMMANDS = ("pip install .", "pip install --no-compile .", "pip wheel --no-deps .", "uv pip install .")


def canonical(name: str) -> str:
    """Name of a distribution as PyPI compares it."""
    return re.sub(r"[-_.]+", "-", name).lower()


def required(name: str) -> Iterator[str]:
    """Names that a distribution needs here, without its extras."""
    for line in distribution(name).requires or []:
        wanted = canonical(re.split(r"[^\w.-]", line, maxsplit=1)[0])
        try:
            distribution(wanted)
        except PackageNotFoundError:
            continue  # of another system
        if "extra ==" not in line:
            yield wanted


def closure(name: str) -> set[str]:
    """A distribution, and all that it needs."""
    found, open_ones = set[str](), {name}
    while open_ones:
        one = open_ones.pop()
        found.add(one)
        open_ones |= set(required(one)) - found
    return found


def megabytes(names: set[str]) -> float:
    """Size of what distributions install, without the byte code that pip adds."""
    paths = {
        Path(str(file.locate()))
        for name in names
        for file in distribution(name).files or []
        if file.suffix != ".pyc"
    }
    return sum(path.stat().st_size for path in paths if path.is_file()) / 1e6


def table() -> str:
    """A row for each dependency; what several need counts for the first of them."""
    direct, seen, rows = sorted(set(required("gd-analyze"))), {"gd-analyze"}, []
    for name in ["numpy", *(name for name in direct if name != "numpy")]:
        others = closure(name) - seen - set(direct) | {name}
        seen |= others
        rows.append((megabytes(others), name))
    rows.sort(reverse=True)
    rows += [(megabytes({"gd-analyze"}), "gd-analyze"), (megabytes(seen), "all")]
    return "| library | MB |\n| --- | --- |\n" + "".join(f"| {name} | {size:.1f} |\n" for size, name in rows)


def installing() -> str:
    """Processor time of installing into an empty environment."""
    text = "| command | processor time, s |\n| --- | --- |\n"
    for command in COMMANDS:
        with tempfile.TemporaryDirectory() as folder:
            subprocess.run([sys.executable, "-m", "venv", folder], check=True)
            python = str(Path(folder, "bin", "python"))
            words = [*command.split()[:-1], "--quiet", str(ROOT)]
            if words[1] == "wheel":
                words += ["--wheel-dir", folder]
            if words[0] == "uv":
                words = [shutil.which("uv") or "uv", *words[1:3], "--python", python, *words[3:]]
            else:
                words = [python, "-m", *words]
            before = resource.getrusage(resource.RUSAGE_CHILDREN)
            subprocess.run(words, check=True, capture_output=True)
            after = resource.getrusage(resource.RUSAGE_CHILDREN)
        taken = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
        text += f"| `{command}` | {taken:.2g} |\n"
    return text


def main() -> None:
    """Write the tables where the page marks them."""
    for name, make in (("sizes", table), ("installing", installing)):
        page, text, mark = PAGE.read_text(encoding="utf-8"), make(), f"<!-- table: {name} -->\n"
        print(text)
        write_text(PAGE, re.sub(rf"{mark}(\|.*\n)*", f"{mark}{text}".replace("\\", r"\\"), page))


if __name__ == "__main__":
    main()
