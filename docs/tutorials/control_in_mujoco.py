"""Control in MuJoCo.

How well does an arm track if its controller uses a simplified model? This tutorial moves the PUMA 560 along a
pick-and-place motion in MuJoCo, under computed torque with the exact model, with the simplified one, and
under PD without any model. It needs MuJoCo (`pip install mujoco`).
"""

# %% [markdown]
# ## The arm in MuJoCo
#
# Each link becomes a body of MJCF, in the Denavit-Hartenberg frame of the arm's file. `armature` is the
# inertia of the drive. Two links need care:
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
# desired acceleration and the feedback. Kp = 400 and Kd = 40 are a bandwidth of 20 rad/s, critically damped.
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
# A steady torque error r moves a joint of inertia M by r / (Kp M). A joint that may be 0.1 degrees off
# therefore allows a torque error of Kp M times as much, which is a budget.

# %%
tolerance = np.radians(0.1)
allowed = gd.types.Budget.of_torques(KP * start_inertia * tolerance)
rough = gd.simplify(arm, motion, allowed)
rough_error = tracking_errors(computed_torque(gd.export(rough, "python").function("torque")))
print("budget:", allowed)
print(f"{rough.operations.total} operations of the torque, largest error {abs(rough_error).max():.2f} mrad")
assert abs(rough_error).max() < 1e3 * tolerance
