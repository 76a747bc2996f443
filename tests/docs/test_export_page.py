"""The C of docs/export.md compiles, and does what the page says."""

from __future__ import annotations

import shutil
import subprocess

import pytest
from markdown_pages import ROOT, blocks

import gd_analyze as gd
from gd_analyze.exporting.export import CLASSES
from gd_analyze.exporting.names import LANGUAGES
from made_models import exact_model

PAGE = ROOT / "docs" / "export.md"
C = [block.text for block in blocks(PAGE) if block.language == "c"]


@pytest.mark.skipif(shutil.which("gcc") is None, reason="gcc, which compiles it, is not installed")
def test_the_controller_compiles_and_runs(puma, tmp_path):
    model = exact_model(puma)
    certificate = gd.certify(model, gd.types.Box.of(puma), effort=1000)
    gd.export(model, "c", name="puma", certificate=certificate).save(tmp_path)
    controller, many = C
    (tmp_path / "main.c").write_text(controller)
    strict = ("-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic")
    command = ["gcc", *strict, "main.c", "puma.c", "-o", "run", "-lm"]
    subprocess.run(command, cwd=tmp_path, check=True)
    said = subprocess.run([tmp_path / "run"], capture_output=True, check=True, text=True).stdout.splitlines()
    q, qd, qdd = [0.1, -0.5, 0.3, 0, 0, 0], [0.5, 0, 0, 0, 0, 0], [1, 0, 0, 0, 0, 0]
    torque = model.torque(q, qd, qdd)
    assert said[:6] == [f"{tau:.3f} N m" for tau in torque]
    assert said[6].startswith("proven: the shoulder")
    assert many.strip() in (tmp_path / "puma.h").read_text()


def test_every_language_and_its_files_are_on_the_page():
    text = PAGE.read_text(encoding="utf-8")
    for name in LANGUAGES:
        files = ", ".join(f"`NAME{suffix}`" for suffix in CLASSES[name].files)
        assert f"| `{name}` | {files} | " in text
