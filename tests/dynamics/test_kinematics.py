"""Axes, origins, frames and centres of mass, against 4x4 transforms and a published pose."""

from __future__ import annotations

import numpy as np
from hypothesis import given

from gd_analyze.dynamics.kinematics import solve_kinematics
from strategies import arms_with_states, examples
from transforms import link_frames

EPS = float(np.finfo(float).eps)


def test_puma_hand_in_closed_form_and_at_the_pose_of_the_text(puma, rng):
    """[FGL87] section 2.2.10, position column of the PUMA's arm matrix; Fig. 2.11 at (90, 0, 90, 0, 0, 0)."""
    drawn = rng.uniform(puma.limits("lower"), puma.limits("upper"), (200, 6))
    q = np.vstack([np.radians([90.0, 0.0, 90.0, 0.0, 0.0, 0.0]), drawn]).T.copy()
    a2, a3, d2, d4, d6 = 431.8, -20.32, 149.09, 433.07, 56.25
    (_, c2, _, c4, c5, _), (_, s2, _, s4, s5, _) = np.cos(q), np.sin(q)
    c1, s1, c23, s23 = np.cos(q[0]), np.sin(q[0]), np.cos(q[1] + q[2]), np.sin(q[1] + q[2])
    outwards = d6 * (c23 * c4 * s5 + s23 * c5) + s23 * d4 + a3 * c23 + a2 * c2
    aside = d6 * s4 * s5 + d2
    up = d6 * (c23 * c5 - s23 * c4 * s5) + c23 * d4 - a3 * s23 - a2 * s2
    kinematics = solve_kinematics(puma, q)
    hand = 1000 * kinematics.link_origins[5]
    # Lengths below 1 m, six rotations of some roundings each; cos(pi/2) = 6e-17 is one of them.
    allowed = 1000 * 60 * EPS
    np.testing.assert_allclose(
        hand, [c1 * outwards - s1 * aside, s1 * outwards + c1 * aside, up], atol=allowed
    )
    np.testing.assert_allclose(hand[:, 0], [-149.09, 921.12, 20.32], atol=allowed)
    rows = kinematics.link_rotations[5, :, :, 0]
    np.testing.assert_allclose(rows, [[0, -1, 0], [0, 0, 1], [-1, 0, 0]], atol=60 * EPS)


@examples(30)
@given(arms_with_states())
def test_frames_axes_and_centres_of_mass_are_those_of_the_transforms(case):
    arm, states = case
    kinematics = solve_kinematics(arm, states.q.T.copy())
    frames = link_frames(arm, states.q)
    before = np.concatenate([np.broadcast_to(np.eye(4), frames[:1].shape), frames[:-1]])
    # Each joint multiplies by at most three rotations and adds two vectors: some 20 roundings, of coordinates
    # no larger than the arm with its slides stretched out; for unit vectors that size is 1.
    unit = 20 * arm.n_joints * EPS
    reach = 1.0 + 2 * arm.n_joints + np.abs(states.q).sum(axis=1).max()

    def placed(frame, point):
        return np.einsum("nNab,nb->naN", frame[..., :3, :3], point) + np.moveaxis(frame[..., :3, 3], 1, -1)

    rotations = np.moveaxis(frames[..., :3, :3], 1, -1)
    np.testing.assert_allclose(kinematics.link_rotations, rotations, atol=unit)
    axes = np.array([joint.placement.rotation @ joint.axis for joint in arm.joints])
    turned = np.einsum("nNab,nb->naN", before[..., :3, :3], axes)
    np.testing.assert_allclose(kinematics.joint_axes, turned, atol=unit)
    origins = np.array([joint.placement.translation for joint in arm.joints])
    for found, wanted in (
        (kinematics.link_origins, placed(frames, 0.0 * origins)),
        (kinematics.com_positions, placed(frames, arm.com)),
        (kinematics.joint_origins, placed(before, origins)),
    ):
        np.testing.assert_allclose(found, wanted, atol=unit * reach)
