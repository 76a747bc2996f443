"""From a log to a verdict.

You have a log of your arm, with torques, and a URDF that may or may not be right. Is a simplified model good
enough for what the arm does there? Run it in this folder; nothing but gd-analyze is needed.
"""

# %% [markdown]
# ## The motion
#
# The log holds positions and torques. Rates and accelerations are taken from the readings, filtered; what has
# to be assumed of a log is said in warnings, and here there is nothing.

# %%
import gd_analyze as gd

arm = gd.load_arm("my_robot.urdf", limits=("all=20",))
motion = gd.read_trajectory("log.csv", arm)
print(motion)

# %% [markdown]
# ## The model
#
# Made for what the arm does in the log, with 2 % of each joint's peak torque as the budget.

# %%
model = gd.simplify(arm, motion, "2%")
print(model)

# %% [markdown]
# ## The verdict
#
# `validate` compares the model with the exact dynamics: does it keep its promise?

# %%
verdict = gd.validate(model, motion, fail_over="2%")
print(verdict)
assert verdict.passed

# %% [markdown]
# And against the measured torques, which hold friction, too: it is fitted, so that what remains is what the
# URDF gets wrong, what the sensors add and, beside the exact model, what the simplified one leaves out.

# %%
(found,) = verdict.motions
exact, simplified = found.measured.exact, found.measured.simplified
for joint, one, other in zip(arm.joints, exact.friction.rms, simplified.friction.rms, strict=True):
    print(f"{joint.name}: RMS {one:.3f} N m beside the exact model, {other:.3f} beside the simplified one")
print("the URDF, joint by joint:", ", ".join(exact.verdicts))
