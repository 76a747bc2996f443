"""Control in MuJoCo.

How well does an arm track if its controller uses a simplified model? This tutorial moves the PUMA 560 along a
pick-and-place motion in MuJoCo, a simulator that shares nothing with gd-analyze: under computed torque with
the exact model, with the simplified one, and under PD without any model. With a model of 1 % every joint
stays within 0.15 mrad, less than 0.01 degrees. Without a model the shoulder is off by 20 mrad, more than a
degree. It needs MuJoCo (`pip install mujoco`).
"""

# %% [markdown]
# ## The arm in MuJoCo
#
# Each link becomes a body of MJCF, in the Denavit-Hartenberg frame of the arm's file. `armature` is the
# inertia of the drive. There is no friction. Two links need care:
#
# - Link 1 has no mass in the file, as it only turns about the waist's axis. MuJoCo demands a mass; one
#   kilogram on that axis changes nothing.
# - The measured inertias of link 3 are those of no real body: the largest exceeds the sum of the others.
#   `balanceinertia` makes MuJoCo accept the link; then the published numbers are put back.

# %%
import matplotlib.pyplot as plt
import mujoco
import numpy as np
from scipy.interpolate import BPoly

import gd_analyze as gd

arm = gd.load_arm("puma560")
dynamics = gd.types.ArmDynamics(arm)


def numbers(*values):
    """Numbers of an attribute, with all their digits."""
    return " ".join(repr(float(value)) for value in values)


bodies = ""
for joint, link, drive, row in zip(arm.joints, arm.links, arm.drives, arm.dh_table, strict=True):
    sine, cosine = np.sin(row.alpha), np.cos(row.alpha)
    mass, inertia = link.mass, np.diag(link.inertia_com)
    if link.axial_only:
        mass, inertia = 1.0, np.full(3, inertia[1])
    bodies += f"""
    <body pos="{numbers(row.a, 0, row.d)}" euler="{numbers(row.alpha, 0, 0)}">
      <joint name="{joint.name}" armature="{drive.inertia}"
             pos="{numbers(-row.a, -row.d * sine, -row.d * cosine)}" axis="{numbers(0, sine, cosine)}"/>
      <inertial mass="{mass}" pos="{numbers(*link.com)}" diaginertia="{numbers(*inertia)}"/>"""

MJCF = f"""
<mujoco>
  <compiler angle="radian" balanceinertia="true"/>
  <option timestep="0.001" integrator="RK4" gravity="{numbers(*arm.gravity_vector)}"/>
  <worldbody>{bodies}{"</body>" * arm.n}</worldbody>
</mujoco>"""

model = mujoco.MjModel.from_xml_string(MJCF)
data = mujoco.MjData(model)
model.body_inertia[3] = np.diag(arm.links[2].inertia_com)
mujoco.mj_setConst(model, data)

# %% [markdown]
# ## The same arm
#
# At random states MuJoCo's mass matrix is the arm's D, and its `qfrc_bias` the arm's h + c.

# %%
random = np.random.default_rng(0)
for _ in range(20):
    data.qpos[:], data.qvel[:] = random.uniform(-2.0, 2.0, (2, arm.n))
    mujoco.mj_forward(model, data)
    mass_matrix = np.zeros((arm.n, arm.n))
    for column, acceleration in zip(mass_matrix, np.eye(arm.n), strict=True):
        mujoco.mj_mulM(model, data, column, acceleration)
    assert abs(mass_matrix - dynamics.inertia(data.qpos)).max() < 1e-9
    bias = dynamics.coriolis_centrifugal(data.qpos, data.qvel) + dynamics.gravity_loading(data.qpos)
    assert abs(data.qfrc_bias - bias).max() < 1e-9

# %% [markdown]
# ## Motion and models
#
# Polynomials of fifth degree lead through the positions, velocities and accelerations of the set points. The
# models are exported as Python; `function` is what `gd-analyze export --to python` writes into a file.

# %%
motion = gd.read_trajectory("pick-and-place", arm)
path = BPoly.from_derivatives(motion.time, np.stack([motion.q, motion.qd, motion.qdd], axis=1))
velocity, acceleration = path.derivative(1), path.derivative(2)

simplified = gd.simplify(arm, motion, "1%")
exact_torque = gd.export(arm, "python").function("torque")
simplified_torque = gd.export(simplified, "python").function("torque")
print(f"{simplified.operations.total} operations of the torque instead of {simplified.operations_full.total}")

# %% [markdown]
# ## Three controllers
#
# Computed torque is tau = D (qdd_d + Kd e' + Kp e) + h + c, with the error e = q_d - q: the torque for the
# desired acceleration and the feedback. Kp is 400, Kd is 40.
#
# If the model is right, every error decays like that of a critically damped oscillator of 20 rad/s.
#
# PD has the same gains, times the inertia that each joint has at the start of the motion. It knows neither
# gravity nor velocities nor what one joint does to the others.

# %%
KP, KD = 400.0, 40.0
start_inertia = np.diag(dynamics.inertia(motion.q[0]))


def computed_torque(torque):
    """Controller that evaluates a model at the desired acceleration and the feedback."""
    return lambda q, qd, qdd, feedback: torque(q, qd, qdd + feedback)


def pd(q, qd, qdd, feedback):
    """Controller without a model."""
    return start_inertia * feedback


# %% [markdown]
# ## The loop, at 1 kHz
#
# Every millisecond the controller reads MuJoCo's state. Its torque acts until the next one.

# %%
times = np.arange(0.0, motion.time[-1], 1e-3)


def tracking_errors(controller):
    """Errors of all joints at every millisecond, mrad."""
    mujoco.mj_resetData(model, data)
    data.qpos[:], data.qvel[:] = motion.q[0], motion.qd[0]
    errors = []
    for t in times:
        error = path(t) - data.qpos
        errors.append(1e3 * error)
        feedback = KD * (velocity(t) - data.qvel) + KP * error
        data.qfrc_applied[:] = controller(data.qpos, data.qvel, acceleration(t), feedback)
        mujoco.mj_step(model, data)
    return np.array(errors)


errors = {
    "exact model": tracking_errors(computed_torque(exact_torque)),
    "1 % model": tracking_errors(computed_torque(simplified_torque)),
    "PD": tracking_errors(pd),
}

# %% [markdown]
# ## Largest errors
#
# ```text
# 88 operations of the torque instead of 284
# largest tracking error, mrad
# joint         exact model    1 % model           PD
# waist               0.016        0.059        7.196
# shoulder            0.024        0.144       19.986
# elbow               0.016        0.099        9.526
# wrist roll          0.011        0.032        4.996
# wrist bend          0.014        0.037        4.074
# flange              0.011        0.013        4.987
# ```
#
# The exact model's error is that of the loop: its torque is a millisecond old at most. What the simplified
# model adds follows from its torque error. A steady torque error r moves a joint of inertia M by r / (Kp M).
# The shoulder has M = 6.7 kg m² and the model errs there by up to 0.37 N m: 0.14 mrad, as simulated.

# %%
print("largest tracking error, mrad")
print("joint       " + "".join(f"{name:>13}" for name in errors))
largest = np.array([abs(error).max(axis=0) for error in errors.values()])
for name, of_joint in zip(arm.joint_names, largest.T, strict=True):
    print(f"{name:12}" + "".join(f"{value:13.3f}" for value in of_joint))
assert (largest[1] < 0.2).all()
assert (largest[1] < largest[2] / 50).all()

# %% [markdown]
# ## Over time
#
# The largest error of any joint, on a logarithmic scale.
#
# ![About 10 mrad with PD, 0.1 with the 1 % model, 0.01 exact](../images/control_in_mujoco.png)

# %%
figure, axes = plt.subplots(figsize=(7.0, 3.4), layout="constrained")
for (name, error), colour in zip(errors.items(), ("black", "tab:blue", "tab:red"), strict=True):
    axes.semilogy(times[1:], abs(error[1:]).max(axis=1), color=colour, label=name)
axes.set(xlabel="time, s", ylabel="largest error of any joint, mrad")
axes.set(xlim=(0.0, motion.time[-1]), ylim=(1e-3, 1e2))
axes.yaxis.set_major_formatter("{x:g}")
axes.grid(alpha=0.3)
axes.legend(ncols=3, loc="upper center", frameon=False)
figure.savefig("control_in_mujoco.png", dpi=100)

# %% [markdown]
# ## A model for a tolerance
#
# The same rule gives a budget: a joint that may be 0.1 degrees (1.75 mrad) off allows a torque error of Kp M
# times as much. A model of 20 operations keeps this tolerance:
#
# ```text
# budget: 3.00877 N m, 4.69467 N m, 0.812012 N m, 0.140777 N m, 0.125414 N m, 0.134767 N m
# 20 operations of the torque, largest error 1.19 mrad
# ```
#
# The rule takes each joint for itself: try the model in simulation, as here, and tighten the budget if the
# joints' coupling asks for it.
#
# Real joints have friction. By the same rule the PUMA's Coulomb friction, 27 N m at the waist, costs some
# 16 mrad there, far more than a model of 1 %: compensate it first (`--what friction`
# [exports](../export.md) it).

# %%
tolerance = np.radians(0.1)
allowed = gd.types.Budget.of_torques(KP * start_inertia * tolerance)
rough = gd.simplify(arm, motion, allowed)
rough_error = tracking_errors(computed_torque(gd.export(rough, "python").function("torque")))
print("budget:", allowed)
print(f"{rough.operations.total} operations of the torque, largest error {abs(rough_error).max():.2f} mrad")
assert abs(rough_error).max() < 1e3 * tolerance
