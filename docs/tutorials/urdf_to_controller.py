"""From a URDF to a controller in C.

You have a URDF and want to run the arm by computed torque on a small processor. This takes three steps: find
the smallest model that errs by no more than 1 % of each joint's peak torque, prove what it errs by at most,
and write it in C. Run it in this folder: it needs gd-analyze, and gcc to try what it wrote.
"""

# %% [markdown]
# ## The model
#
# A URDF has no limits of acceleration, so they are given here: the model's budget and its bound hold within
# all limits. `states_in_box` draws states from them; `simplify` drops and refits what the budget allows.

# %%
import ctypes
import subprocess
from pathlib import Path

import numpy as np

import gd_analyze as gd
from gd_analyze.dynamics.simulation import simulate

arm = gd.load_arm("my_robot.urdf", limits=("all=15",))
model = gd.simplify(arm, gd.states_in_box(arm), "1%")
print(model)

# %% [markdown]
# ## The bound
#
# So far the error was sampled. `certify` proves that no state within the limits has a larger one.

# %%
certificate = gd.certify(model)
print(certificate)

# %% [markdown]
# ## The C
#
# `export` writes `my_robot.h` and `my_robot.c`. They allocate nothing and need only libm; the bound and the
# box it holds in are constants beside the functions.

# %%
gd.export(model, "c", certificate=certificate).save("controller")

# %% [markdown]
# Computed torque asks the model for the torque of the acceleration it wants: that planned, and what brings
# the error down. With a bandwidth of 20 rad/s, critically damped, that is all there is to write by hand.

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
# ## Trying it
#
# The compiled controller moves the exact arm from rest to a posture half a radian away.

# %%
Path("controller/controller.c").write_text(CONTROLLER, encoding="utf-8")
words = "gcc -std=c99 -O2 -Wall -Wextra -pedantic -shared -fPIC -o controller.so controller.c my_robot.c -lm"
subprocess.run(words.split(), cwd="controller", check=True)
compiled = ctypes.CDLL(str(Path("controller/controller.so").resolve())).controller

plan = np.array([0.5, -0.5, 0.5])


def torque(t: float, q: np.ndarray, qd: np.ndarray) -> np.ndarray:
    """Ask the controller."""
    given, tau = [np.ascontiguousarray(x, dtype=float) for x in (q, qd, plan)], np.empty(3)
    compiled(*(x.ctypes.data_as(ctypes.c_void_p) for x in (*given, tau)))
    return tau


run = simulate(arm, torque, np.zeros(3), np.zeros(3), 1.0)
error = np.abs(run.q[-1] - plan).max()
print(f"after a second the arm is {1000 * error:.3f} mrad from where it should be")
assert error < 2e-3
