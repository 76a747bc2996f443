"""Design by sweep.

A designer has three ideas for an arm: a longer forearm, a heavier tool, a counterweight at the elbow. This
tutorial asks of each what the drives must give and whether the controller needs another model, and decides.
Run it in this folder; it needs only gd-analyze.
"""

# %% [markdown]
# ## Arm, motion, budget
#
# The allowed torque error is 0.5 % of each drive's limit of 80 N m, 0.4 N m: the same for every design. A
# share of peak torque would grow and shrink with the torque.

# %%
import gd_analyze as gd

arm = gd.load_arm("my_robot.urdf")
motion = gd.read_trajectory("log.csv", arm)
BUDGET = "0.5% limit"


def changes(found):
    """The values at which a verdict changes."""
    columns = ("change_element", "change_from", "change_to", "change_at")
    return list(zip(*(found[name].values.tolist() for name in columns), strict=True))


# %% [markdown]
# ## A longer forearm
#
# Names are the keys of `gd-analyze arms my_robot.urdf --to toml`: joint 3, the wrist, is 0.35 m from the
# elbow. All else is held: a longer link keeps its mass, its inertia and its centre of mass.

# %%
forearm = gd.sweep(arm, motion, "joint3.xyz.x=0.35..0.55:5", budget=BUDGET)
elbow = forearm.peak_torque.sel(joint=2)
print(elbow.values, "N m;", forearm.operations.values, "operations;", changes(forearm))
assert abs(elbow.sel({"joint3.xyz.x": 0.45}) / elbow[0] - 1.09) < 0.005

# %% [markdown]
# 10 cm more take 9 % more torque at the elbow, and 28 operations of the model instead of 25. One verdict
# changes: above 0.461 m translation alone makes D22.
#
# ## A heavier tool, and how fast
#
# `speed` multiplies the velocities of the motion. "without h1" says whether joint 1 keeps its budget if
# Coriolis and centrifugal torques are left out. Changes between neighbours on the grid are bisected.

# %%
vary = ["link3.mass=0.6..3.6:3", "speed=0.2..1:5"]
tool = gd.sweep(arm, motion, vary, budget=BUDGET, operations="none")
below = {}
for element, _, verdict, (mass, speed) in changes(tool):
    if (element, verdict) == ("without h1", "beyond budget") and mass in tool["link3.mass"]:
        below[mass] = speed
print("h1 may be left out below these speeds:", below)
assert [round(below[mass], 2) for mass in (0.6, 3.6)] == [0.52, 0.28]

# %% [markdown]
# A controller without h may run at 0.52 of the speed with the tool of 0.6 kg, at 0.28 with 3.6 kg. At full
# speed it needs h with either.
#
# ## A counterweight
#
# Mass behind the elbow moves the centre of mass of link 2, now at 0.175 m, towards the elbow's axis.

# %%
balance = gd.sweep(arm, motion, "link2.com.x=-0.05..0.175:10", budget=BUDGET)
elbow = balance.peak_torque.sel(joint=2)
print(elbow.values, "N m;", balance.operations.values, "operations;", changes(balance))
assert abs(elbow[2] - 2.4) < 0.05
assert balance.operations[[2, -1]].values.tolist() == [20, 25]

# %% [markdown]
# With the centre of mass on the axis, the elbow takes 2.4 N m instead of 6.7, the model 20 operations
# instead of 25, and joint 2 may do without h.
#
# **Decision.** The counterweight comes first: a smaller drive and a smaller model. A forearm of up to 0.46 m
# changes the model's numbers only. The heavier tool is no reason to add h: the controller has it at full
# speed anyway.
