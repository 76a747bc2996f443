"""From a URDF to a controller in C.

This tutorial makes a computed-torque controller for a small processor from a URDF, in three steps: find the
smallest model with a torque error of at most 1 % of each joint's peak torque, prove a bound on its error, and
write it in C. Run it in this folder; it needs gd-analyze, and gcc to compile the result.
"""

# %% [markdown]
# ## The model
#
# URDF has no acceleration limits, so they are given here. `states_in_box` draws random states within all
# limits; `simplify` drops terms within the budget.

# %%
import ctypes
import subprocess
from pathlib import Path

import numpy as np

import gd_analyze as gd

arm = gd.load_arm("my_robot.urdf", limits=("all=15",))
model = gd.simplify(arm, gd.tables.states_in_box(arm), "1%")
print(model)

# %% [markdown]
# ## The bound
#
# The error so far is sampled, at the states drawn. `certify` proves a bound for every state within the
# limits.

# %%
certificate = gd.certify(model)
print(certificate)

# %% [markdown]
# ## The C
#
# `export` writes `my_robot.h` and `my_robot.c`. They allocate nothing and need only libm. The header holds
# the bound and the limits within which it is proven.

# %%
gd.export(model, "c", "controller", certificate=certificate)

# %% [markdown]
# Computed torque evaluates the model at the desired acceleration: the planned one, here zero, plus the
# feedback. With a bandwidth of 20 rad/s and critical damping the controller is:

# %%
CONTROLLER = """
#include "my_robot.h"

void controller(const double q[], const double qd[], const double plan[], double tau[])
{
    double qdd[my_robot_joints];
    for (int j = 0; j < my_robot_joints; j++)
        qdd[j] = 400.0 * (plan[j] - q[j]) - 40.0 * qd[j];
    my_robot_torque(q, qd, qdd, tau);
}
"""

# %% [markdown]
# ## Test
#
# The compiled controller moves the exact arm from rest to a posture half a radian away.

# %%
Path("controller/controller.c").write_text(CONTROLLER, encoding="utf-8")
words = "gcc -std=c99 -O2 -Wall -Wextra -pedantic -shared -fPIC -o controller.so controller.c my_robot.c -lm"
subprocess.run(words.split(), cwd="controller", check=True)
compiled = ctypes.CDLL(str(Path("controller/controller.so").resolve())).controller

plan = np.array([0.5, -0.5, 0.5])


def torque(t: float, q: np.ndarray, qd: np.ndarray) -> np.ndarray:
    """Torque of the compiled controller."""
    given, tau = [np.ascontiguousarray(x, dtype=float) for x in (q, qd, plan)], np.empty(3)
    compiled(*(x.ctypes.data_as(ctypes.c_void_p) for x in (*given, tau)))
    return tau


run = gd.tables.simulate(arm, torque, np.zeros(3), np.zeros(3), 1.0)
error = np.abs(run.q[-1] - plan).max()
print(f"after a second the arm is {1000 * error:.3f} mrad from its goal")
assert error < 2e-3
