"""The founding text's figures.

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
import matplotlib.pyplot as plt

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
# Solid lines are translation, dashed lines rotation. A dashed line near zero means that rotation can be
# dropped.

# %%
figure, axes = plt.subplots(2, 3, figsize=(10, 5), sharex=True, layout="constrained")
styles = {"translation": "-", "rotation": "--"}
for k, axis in enumerate(axes.flat, start=1):
    shown = parts.inertia.sel(joint=k, joint_j=k) if k < 4 else parts.coriolis_centrifugal.sel(joint=k - 3)
    for effect, style in styles.items():
        axis.plot(parts.time, shown.sel(effect=effect), style, color="black", label=effect)
    axis.set_ylim(bottom=0.0 if k < 4 else None)
    axis.set_title(f"$D_{{{k}{k}}}$ in kg m$^2$" if k < 4 else f"$h_{k - 3}$ in N m", loc="left")
axes[0, 0].legend(frameon=False)
for axis in axes[1]:
    axis.set_xlabel("time in s")
figure.savefig("figures_of_the_text.png", dpi=120)

# %% [markdown]
# ## The verdicts
#
# `rank` finds the dominant effect of every element: dropping the other effect changes the element by at most
# 10 % of its peak. `text_verdicts` holds the verdicts that the text reads from its figures.

# %%
ranking = gd.rank(parts)
text = gd.text_verdicts("puma560")
agree = [label for label, verdict in text.verdicts.items() if ranking.dominant.sel(element=label) == verdict]
print(f"the text's verdict holds for {len(agree)} of {len(text.verdicts)} elements:")
print(", ".join(agree))
assert "D11" in agree
