"""Programs kept between runs: the same as written anew, and never believed when they are wrong."""

from __future__ import annotations

from pathlib import Path

import pytest

from gd_analyze.operations.program import Program, written
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.catalogue import load_arm
from gd_analyze.simplification.cache import VARIABLE, keep, without_cache
from gd_analyze.simplification.effort import THOROUGH
from gd_analyze.simplification.exact_form import ExactForm
from gd_analyze.simplification.program_cache import kept_programs
from gd_analyze.simplification.torque_program import torque_program


@pytest.fixture(autouse=True)
def place(tmp_path, monkeypatch) -> Path:
    """An empty folder; nothing is remembered of earlier tests, nor afterwards."""
    monkeypatch.setenv(VARIABLE, str(tmp_path / "cache"))
    kept_programs.cache_clear()
    yield tmp_path / "cache"
    kept_programs.cache_clear()


def exact(arm: RobotArm, drives: bool = False) -> Program:
    """As another run would make it."""
    kept_programs.cache_clear()
    return ExactForm(arm, drives).program


def thorough(arm: RobotArm) -> Program:
    kept_programs.cache_clear()
    form = ExactForm(arm)
    some = dict(sorted(form.torques.items())[:10])
    return torque_program(form.velocities, some, THOROUGH)


@pytest.fixture(params=[exact, thorough], ids=["exact", "some terms"])
def made(request):
    return request.param


def test_it_is_written_once_and_the_same_with_and_without(two_link, place, made, monkeypatch):
    first = made(two_link)
    assert len(list(place.iterdir())) == 1
    with without_cache():
        assert written(made(two_link)) == written(first)
    for module, name in (("exact_form", "_shortest"), ("torque_program", "_thorough")):
        monkeypatch.setattr(f"gd_analyze.simplification.{module}.{name}", None)
    again = made(two_link)
    assert written(again) == written(first)
    assert [step.order for step in again.steps] == [step.order for step in first.steps]


def test_a_wrong_entry_is_not_believed_and_written_anew(two_link, place, made):
    right = written(made(two_link))
    (path,) = place.iterdir()
    before, name = path.read_bytes(), path.name.split(".")[0]
    numbers = [(k, j) for k, step in enumerate(right[0]) for j, x in enumerate(step) if isinstance(x, float)]
    steps = [list(step) for step in right[0]]
    k, j = numbers[0]
    steps[k][j] *= 1.0 + 1e-6
    renamed = [["input", "q9"] if step == ["input", "q1"] else step for step in right[0]]
    for wrong in (
        [[steps, right[1]]],
        [[right[0], right[1][:1]]],
        [[right[0], [*reversed(right[1])]]],
        [[renamed, right[1]]],
        [[right[0], [float("1e300")] * 2]],
        [right, right],
        [],
        [None],
        {"steps": 1},
        "text",
        7,
        None,
    ):
        keep(name, wrong)
        assert path.read_bytes() != before
        assert written(made(two_link)) == right
        assert path.read_bytes() == before


def test_what_is_no_entry_at_all_is_replaced(two_link, place, made):
    right = written(made(two_link))
    (path,) = place.iterdir()
    before = path.read_bytes()
    for content in (b"", b"\0" * 100, before[:-1], b"[" * 10_000):
        path.write_bytes(content)
        assert written(made(two_link)) == right
        assert path.read_bytes() == before


def test_every_arm_has_its_own_and_with_drives_another(two_link, puma, place):
    counts = {exact(two_link).count, exact(puma).count, exact(puma, True).count}
    assert len(counts) == 3
    assert len(list(place.iterdir())) == 3


def test_without_a_folder_to_write_to_work_goes_on(two_link, blocked_folder, monkeypatch, made):
    right = written(made(two_link))
    monkeypatch.setenv(VARIABLE, str(blocked_folder))
    assert written(made(two_link)) == right


def test_other_code_finds_nothing_of_this(two_link, place, monkeypatch):
    exact(two_link)
    monkeypatch.setattr("gd_analyze.simplification.program_cache._surroundings", lambda: ["other code"])
    exact(two_link)
    assert len(list(place.iterdir())) == 2


def test_an_arm_file_read_again_is_the_same_arm(place):
    for _ in range(2):
        exact(load_arm("two_link"))
    assert len(list(place.iterdir())) == 1
