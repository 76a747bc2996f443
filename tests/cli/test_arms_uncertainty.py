"""`gd-analyze arms NAME` shows the uncertainties that an arm states, and nothing where it states none."""

from __future__ import annotations

import gd_analyze as gd

ARM = """\
format = "gd-analyze arm 1"
name = "own"

[[joints]]
[[joints]]

[[links]]
name = "plain"
mass = 1.0
com = [0.0, 0.0, 0.0]
inertia = { xx = 0.1, yy = 0.1, zz = 0.1 }
mass_uncertainty = 0.0123

[[links]]
name = "swung"
mass = 1.0
com = [0.0, 0.0, 0.0]
inertia = { xx = 0.1, yy = 0.1, zz = 0.1 }
inertia_about = "origin"
com_uncertainty_mm = [1.5, 2.5, 3.5]
inertia_uncertainty = { xx = 0.011, yy = 0.012, zz = 0.013, xz = 0.0042 }
"""


def section(out: str, title: str) -> list[list[str]]:
    """Rows of the table below a title, cell by cell."""
    lines = out[out.index(title) :].split("\n\n")[0].splitlines()
    rule = next(i for i, line in enumerate(lines) if line.startswith("─"))
    return [line.split() for line in lines[rule + 1 :]]


def test_the_pumas(run):
    result = run("arms", "puma560")
    rows = section(result.out, "Standard uncertainties")
    assert rows[1] == ["2", "?", "?", "?", "?", "0.013", "0.0524", "0.0539"]
    assert len(rows) == 6
    told = run("arms", "puma560", "--json").json
    assert told["links"][1]["uncertainty"]["inertia"][0][0] == 0.013
    assert told["drive_inertia_uncertainty"] == [0.27, 0.54, 0.093, 0.016, 0.014, 0.016]


def test_every_stated_one(run, here):
    (here / "own.toml").write_text(ARM, encoding="utf-8")
    result = run("arms", "own.toml")
    assert (result.code, result.err) == (0, "")
    assert max(map(len, result.out.splitlines())) <= 80
    assert section(result.out, "Standard uncertainties of mass") == [
        ["plain", "0.0123", "?", "?", "?", "?", "?", "?"],
        ["swung", "?", "0.0015", "0.0025", "0.0035", "0.011", "0.012", "0.013"],
    ]
    products = result.out[result.out.index("Standard uncertainties of products") :]
    assert "swung    0  0.0042    0" in products
    assert "Of the inertia about the link frame's origin: swung." in products


def test_none_where_none_is_stated(run):
    for name in set(gd.builtin_arms()) - {"puma560"}:
        assert "uncertainties" not in run("arms", name).out
