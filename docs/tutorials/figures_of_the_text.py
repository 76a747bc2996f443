"""Figs 3.10 and 3.11 of the text.

Figs 3.10 and 3.11 of Fu, Gonzalez and Lee (1987) show the translational and rotational parts of the elements
of D and h, for a PUMA 560 along a planned trajectory of 31 set points. The text gives neither its trajectory
nor its inertial parameters. This tutorial draws the same figures for the shipped arm and trajectory.
"""

# %% [markdown]
# ## The parts along the motion
#
# `decompose` evaluates D^tran, D^rot, h^tran, h^rot and c at every set point. As in the text, drives are left
# out. Parts are selected by name: effect, joint, time.

# %%
import gd_analyze as gd

arm = gd.load_arm("puma560")
motion = gd.read_trajectory("pick-and-place", arm)
parts = gd.decompose(arm, motion, drives=False)
inertia = parts.inertia.sel(joint=2, joint_j=2)
whole = inertia.sum("effect")
print(f"D22 lies between {float(whole.min()):.2f} and {float(whole.max()):.2f} kg m^2")
assert parts.sizes["time"] == 31

# %% [markdown]
# ## Figs 3.10 and 3.11
#
# All 21 elements of D and all 6 of h by effect, with a mark at each set point. `findings.plot` takes the
# elements, the effects, the abscissa ("time" or "set point") and axes of your own. `gd-analyze figures
# puma560 pick-and-place --no-drives --to svg,pdf,png` writes the same as files.

# %%
findings = gd.analyze(arm, motion, drives=False, level="term")
matrix = findings.plot.inertia(x="set point")
vector = findings.plot.coriolis_centrifugal(x="set point")
print(f"{len(matrix)} panels of D, {len(vector)} of h")
matrix[0].figure.savefig("inertia.png", dpi=150)
vector[0].figure.savefig("coriolis_centrifugal.png", dpi=150)

# %% [markdown]
# ## Which effect dominates, and when
#
# Colour: the effects that the element needs at the set point. Shade: the torque that it makes.

# %%
(at_a_glance,) = findings.plot.dominance()
at_a_glance.figure.savefig("dominance.png", dpi=150)
over_time = gd.tables.dominance_over_time(parts)
d25 = gd.tables.verdicts(over_time).sel(element="D25")
print(
    "D25:",
    ", ".join(f"{verdict} at {int((d25 == verdict).sum())} set points" for verdict in ("both", "rotation")),
)

# %% [markdown]
# ## The verdicts
#
# `rank` finds the dominant effect of every element: dropping the other effect changes the element by at most
# 10 % of its peak. `text_verdicts` holds the verdicts that the text reads from its figures.

# %%
ranking = gd.rank(parts)
text = gd.tables.text_verdicts("puma560")
agree = [label for label, verdict in text.verdicts.items() if ranking.dominant.sel(element=label) == verdict]
print(f"the text's verdict holds for {len(agree)} of {len(text.verdicts)} elements:")
print(", ".join(agree))
assert "D11" in agree
