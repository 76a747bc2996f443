"""From a log to a verdict.

Given a log of an arm with torques, and a URDF that may contain errors, this tutorial checks whether a
simplified model is good enough for the logged motion, and whether the URDF describes the arm. Run it in this
folder; it needs only gd-analyze.
"""

# %% [markdown]
# ## The motion
#
# The log holds positions and torques. Velocities and accelerations are derived from the smoothed positions.
# Assumptions about a log are stated as warnings; this log needs none.

# %%
import gd_analyze as gd

arm = gd.load_arm("my_robot.urdf", limits=("all=20",))
motion = gd.read_trajectory("log.csv", arm)
print(motion)

# %% [markdown]
# ## The model
#
# The model is fitted on the motion in the log. The budget is 2 % of each joint's peak torque.

# %%
model = gd.simplify(arm, motion, "2%")
print(model)

# %% [markdown]
# ## The verdict
#
# `evaluate` compares the model with the exact dynamics and fails if any joint's error exceeds 2 % of its peak
# torque.

# %%
verdict = gd.evaluate(model, motion, fail_over="2%")
print(verdict)
assert verdict.passed

# %% [markdown]
# `evaluate` also compares the measured torques with both models, after fitting friction. The remaining RMS
# of the exact model contains errors of the URDF and noise; that of the simplified model also its torque
# error.

# %%
(found,) = verdict.motions
exact, simplified = found.measured.exact, found.measured.simplified
for joint, one, other in zip(arm.joints, exact.friction.rms, simplified.friction.rms, strict=True):
    print(f"{joint.name}: RMS {one:.3f} N m from the exact model, {other:.3f} from the simplified one")
print(verdict.log_verdict.text)
