"""Ten tasks of a robotics notebook.

What users of the robotics toolbox and of Pinocchio do first, with gd-analyze. States are in radians and SI
units, joints along the last axis.
"""

# %% [markdown]
# ## 1. Load an arm and plan a motion
#
# Arms come by name, or from a TOML, URDF or MJCF file. `gd.Trajectory(time, q)` makes a motion of positions
# alone.

# %%
import matplotlib.pyplot as plt
import numpy as np
import pinocchio as pin

import gd_analyze as gd
from gd_analyze.dynamics.pinocchio_check import pinocchio_model

arm = gd.load_arm("puma560")
motion = gd.plan(arm, np.zeros(arm.n), [0.8, -0.6, 0.5, 0.4, -0.7, 0.3], duration=2.0, n_set_points=101)
print(arm.n, arm.joint_names)

# %% [markdown]
# ## 2. Torque, at one state and at all
#
# The drives' inertia is part of it, as the PUMA's file describes drives; `drives=False` gives the links'
# torque.

# %%
q, qd, qdd = motion.q, motion.qd, motion.qdd
dynamics = gd.types.ArmDynamics(arm)
print(dynamics.torque(q[50], qd[50], qdd[50]).round(2))
torque = dynamics.torque(q, qd, qdd)
print(torque.shape, abs(torque).max(axis=0).round(2))

# %% [markdown]
# ## 3. Compare with Pinocchio

# %%
model = pinocchio_model(arm)
theirs = pin.rnea(model, model.createData(), q[50], qd[50], qdd[50])
difference = dynamics.torque(q[50], qd[50], qdd[50], drives=False) - theirs
print("largest difference:", f"{abs(difference).max():.0e}", "N m")

# %% [markdown]
# ## 4. D by effect

# %%
translation, rotation = dynamics.inertia(q[50], by_effect=True)
print("D12:", translation[0, 1].round(4), "+", rotation[0, 1].round(4), "kg m^2")

# %% [markdown]
# ## 5. Elements ranked by torque, as a pandas table

# %%
dataset = gd.decompose(arm, motion)
ranking = dataset.gd.ranking()
print(ranking[["verdict", "torque_share", "torque_joint"]].head())

# %% [markdown]
# ## 6. The parts of D12 over time

# %%
dataset.gd.plot.inertia(["D12"])
plt.show()
print(dataset.gd.D("D12").sel(effect="rotation").max().item())

# %% [markdown]
# ## 7. Simplify, and read the equations
#
# The budget holds between the set points, too, and nearby: it is proven there.

# %%
simplified = gd.simplify(arm, motion, "2%")
print(simplified)
print(simplified.equations)

# %% [markdown]
# ## 8. The error on another motion

# %%
print(gd.evaluate(simplified, "wrist-move").errors.largest.round(3), "N m")

# %% [markdown]
# ## 9. Export to a callable
#
# `casadi` and `jax` in place of `python` give functions of these; `save` writes the text.

# %%
exported = gd.export(simplified, "python").function("torque")
print(abs(exported(q, qd, qdd) - simplified.torque(q, qd, qdd)).max() < 1e-9)

# %% [markdown]
# ## 10. Simulate
#
# Symplectic Euler for a tenth of a second: the arm falls from its first position, without torque.

# %%
position, velocity, step = q[0].copy(), np.zeros(arm.n), 1e-3
for _ in range(100):
    velocity += step * dynamics.forward_dynamics(position, velocity, np.zeros(arm.n))
    position += step * velocity
print(position.round(3))
