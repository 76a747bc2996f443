function [tau, D, h, c, stated] = two_link(q, qd, qdd)
% [tau, D, h, c, stated] = two_link(q, qd, qdd)
%
% Simplified torque model of Two-link planar arm, by gd-analyze VERSION.
%
% Level energy: 5 of 5 energy terms; budget 1 N m.
% torque: generalized torque tau = D(q) qdd + h(q, qd) + c(q);
%   22 (12 mult + 10 add), 4 sin and cos.
% inertia: mass matrix D(q), row by row;
%   4 (1 mult + 3 add), 1 sin and cos.
% coriolis_centrifugal: Coriolis and centrifugal torque h(q, qd);
%   7 (5 mult + 2 add), 1 sin and cos.
% gravity_loading: gravity loading c(q);
%   4 (2 mult + 2 add), 2 sin and cos.
% The exact torque takes 22 (12 mult + 10 add), 4 sin and cos,
%   exact D, h and c, each a function of its own, 3 + 7 + 4 operations,
%   4 sin and cos.
% Inertia of the drives: none in the arm's file.
% Units: rad and m, s, N m and N. Friction is not included.
% Arm two_link, SHA-256 of all that affects its torque:
%   187bf5c5c5eed8fce5b8ab617b4b82c548c4e2e83b09ba06363becbb363e8f7f
% SHA-256 of the model file:
%   HASH
%
% Joints in order, with their original names if these differ:
%   1: shoulder, revolute: q in rad, tau in N m
%   2: elbow, revolute: q in rad, tau in N m
% Links: upper rod, fore rod
%
% Torque errors, sampled where the model was fitted:
%   box drawn, states 5, seed 0
%   joint  peak torque  allowed  largest  RMS
%       1            1        1        0    0
%       2            1        1        0    0
% Proven: no state of the following box (a box) has an error above the bound.
%   joint  q from  q to  |qd| up to  |qdd| up to     bound
%       1    -0.7   1.1         2.3          3.3       0.1
%       2    -0.7   1.1         2.3          3.3  0.433334
%
% States are columns of 2 numbers; matrices of many states are 2 by 2 by states.
% stated: errors and box as numbers.
    tau = two_link_torque(q, qd, qdd);
    if nargout > 1
        D = two_link_inertia(q);
    end
    if nargout > 2
        h = two_link_coriolis_centrifugal(q, qd);
    end
    if nargout > 3
        c = two_link_gravity_loading(q);
    end
    if nargout > 4
        stated = struct( ...
            'sampled_error', [0.0; 0.0], ... % largest torque error at the states the model was fitted on
            'error_bound', [0.1; 0.433334], ... % bound on the torque error at all states within the box
            'lower', [-0.7; -0.7], ... % the box: lowest positions
            'upper', [1.1; 1.1], ... % the box: highest positions
            'velocity', [2.3; 2.3], ... % the box: largest velocities in both directions
            'acceleration', [3.3; 3.3], ... % the box: largest accelerations in both directions
            'joints', 2);
    end
end

function [tau] = two_link_torque(q, qd, qdd)
% generalized torque tau = D(q) qdd + h(q, qd) + c(q)
    q1 = q(1, :);
    q2 = q(2, :);
    qd1 = qd(1, :);
    qd2 = qd(2, :);
    qdd1 = qdd(1, :);
    qdd2 = qdd(2, :);
    t1 = qd1 + qd2;
    t2 = qdd1 + qdd2;
    cos_q1 = cos(q1);
    t4 = 19.612 .* cos_q1;
    sin_q2 = sin(q2);
    t6 = 0.5 .* sin_q2;
    cos_q2 = cos(q2);
    t8 = 0.5 .* cos_q2;
    t9 = q1 + q2;
    cos_t9 = cos(t9);
    t11 = 4.903 .* cos_t9;
    t12 = t1 .* t6;
    t13 = t1 .* t12;
    t14 = t4 - t13;
    t15 = t2 .* t8;
    t16 = t14 + t15;
    t17 = 1.667 .* qdd1;
    t18 = t16 + t17;
    t19 = qd1 .* t6;
    t20 = qd1 .* t19;
    t21 = t11 + t20;
    t22 = qdd1 .* t8;
    t23 = t21 + t22;
    t24 = 0.333 .* t2;
    t25 = t23 + t24;
    t26 = t18 + t25;
    tau = zeros(2, size(q, 2));
    tau(1, :) = t26;
    tau(2, :) = t25;
end

function [D] = two_link_inertia(q)
% mass matrix D(q), row by row
    q2 = q(2, :);
    cos_q2 = cos(q2);
    t2 = 0.5 .* cos_q2;
    t3 = 1.667 + t2;
    t4 = 0.333 + t2;
    t5 = t3 + t4;
    D = zeros(2, 2, size(q, 2));
    D(1, 1, :) = t5;
    D(1, 2, :) = t4;
    D(2, 1, :) = t4;
    D(2, 2, :) = 0.333;
end

function [h] = two_link_coriolis_centrifugal(q, qd)
% Coriolis and centrifugal torque h(q, qd)
    q2 = q(2, :);
    qd1 = qd(1, :);
    qd2 = qd(2, :);
    t1 = qd1 + qd2;
    sin_q2 = sin(q2);
    t3 = 0.5 .* sin_q2;
    t4 = t1 .* t3;
    t5 = t1 .* t4;
    t6 = qd1 .* t3;
    t7 = qd1 .* t6;
    t8 = t7 - t5;
    h = zeros(2, size(q, 2));
    h(1, :) = t8;
    h(2, :) = t7;
end

function [c] = two_link_gravity_loading(q)
% gravity loading c(q)
    q1 = q(1, :);
    q2 = q(2, :);
    cos_q1 = cos(q1);
    t2 = 19.612 .* cos_q1;
    t3 = q1 + q2;
    cos_t3 = cos(t3);
    t5 = 4.903 .* cos_t3;
    t6 = t2 + t5;
    c = zeros(2, size(q, 2));
    c(1, :) = t6;
    c(2, :) = t5;
end
