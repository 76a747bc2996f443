"""Design by batch.

A designer has three ideas for an arm: a longer forearm, a heavier tool, a counterweight at the elbow. This
tutorial asks of each what the drives must give and whether the controller needs another model, and decides.
Run it in this folder; it needs only gd-analyze.
"""

# %% [markdown]
# ## Arm, motion, budget
#
# The allowed torque error is 0.5 % of each drive's limit of 80 N m, 0.4 N m: the same for every design. A
# share of peak torque would grow and shrink with the torque. The torques in the log are those of the arm as
# it is: only the motion is kept.

# %%
from itertools import product

import gd_analyze as gd

arm = gd.load_arm("my_robot.urdf")
motion = gd.read_trajectory("log.csv", arm)
for speed in (0.3, 1.0):
    replayed = gd.Trajectory(motion.time / speed, motion.q, speed * motion.qd, speed**2 * motion.qdd)
    gd.write_trajectory(replayed, f"speed_{speed}.csv")
SAME = {"arm": "my_robot.urdf", "trajectory": "speed_1.0.csv", "budget": "0.5% limit"}
SHOWN = ["peak_torque_2", "model_operations", "exact_operations", "changed_verdicts"]

# %% [markdown]
# ## A longer forearm
#
# A number of the arm is a column, named as in arm files: joint 3, the wrist, is 0.35 m from the elbow. All
# else is held: a longer link keeps its mass, its inertia and its centre of mass. `forearm/batch.svg` shows
# peak torques and operations over the length.

# %%
rows = [SAME | {"joint3.xyz.x": length} for length in (0.35, 0.4, 0.45, 0.5, 0.55)]
forearm = gd.batch(rows, "forearm", formats=(), to=("csv", "svg"))
print(forearm[["joint3.xyz.x", *SHOWN]].to_string())
assert abs(forearm.peak_torque_2[2] / forearm.peak_torque_2[0] - 1.09) < 0.005
assert forearm.changed_verdicts.tolist() == ["", "", "", "D22 translation", "D22 translation"]

# %% [markdown]
# 10 cm more take 9 % more torque at the elbow, and the models are of one size. One verdict changes: from
# 0.5 m on translation alone makes D22.
#
# ## A heavier tool, and how fast
#
# Every combination of two speeds of the motion and three masses.

# %%
rows = [
    SAME | {"trajectory": f"speed_{speed}.csv", "link3.mass": mass}
    for speed, mass in product((0.3, 1.0), (0.6, 2.1, 3.6))
]
tool = gd.batch(rows, "tool", formats=())
print(tool[["trajectory", "link3.mass", *SHOWN]].to_string())
slow, fast = tool[:3].reset_index(), tool[3:].reset_index()
assert abs(fast.peak_torque_2[2] / fast.peak_torque_2[0] - 2.76) < 0.005
assert (slow.model_operations <= 0.5 * fast.model_operations).all()

# %% [markdown]
# The elbow holds the tool more than it moves it: 3 kg more take 2.8 times the torque at either speed. The
# model for full speed takes nearly twice as many operations with the heavy tool, and that for 0.3 of the
# speed half of them with any.
#
# ## A counterweight
#
# Mass behind the elbow moves the centre of mass of link 2, now at 0.175 m, towards the elbow's axis.

# %%
rows = [SAME | {"link2.com.x": place} for place in ("175 mm", "100 mm", 0, "-50 mm")]
balance = gd.batch(rows, "balance", formats=())
print(balance[["link2.com.x", *SHOWN, "gamma"]].to_string())
assert abs(balance.peak_torque_2[2] - 2.4) < 0.05
assert balance.model_operations[2] < balance.model_operations[0]

# %% [markdown]
# With the centre of mass on the axis, the elbow takes 2.4 N m instead of 6.7, and the model fewer operations.
#
# **Decision.** The counterweight comes first: a smaller drive and a smaller model. A longer forearm changes
# the model's numbers only. The heavier tool needs a larger drive at any speed, and a larger model at full
# speed.
