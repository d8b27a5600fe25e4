"""A right solution: every equation is written out, nothing of the model is used."""

import itertools

import numpy as np

A = [0.0, -0.425, -0.39225, 0.0, 0.0, 0.0]
D = [0.089159, 0.0, 0.0, 0.10915, 0.09465, 0.0823]
ALPHA = [np.pi / 2, 0.0, 0.0, np.pi / 2, -np.pi / 2, 0.0]


def frames(q):
    found, pose = [], np.eye(4)
    for angle, a, d, alpha in zip(q, A, D, ALPHA, strict=True):
        c, s, ca, sa = np.cos(angle), np.sin(angle), np.cos(alpha), np.sin(alpha)
        pose = pose @ np.array([[c, -s * ca, s * sa, a * c], [s, c * ca, -c * sa, a * s],
                                [0.0, sa, ca, d], [0.0, 0.0, 0.0, 1.0]])
        found.append(pose)
    return found


def forward_kinematics(q):
    return frames(q)[-1]


def jacobian(q):
    poses = [np.eye(4), *frames(q)]
    tip = poses[-1][:3, 3]
    columns = [np.concatenate([np.cross(pose[:3, 2], tip - pose[:3, 3]), pose[:3, 2]])
               for pose in poses[:-1]]
    return np.array(columns).T


def solutions(T):
    found = []
    p5 = T[:3, 3] - D[5] * T[:3, 2]
    reach = np.hypot(p5[0], p5[1])
    if reach < D[3]:
        return found
    for shoulder, wrist, elbow in itertools.product((1, -1), repeat=3):
        q1 = np.arctan2(p5[1], p5[0]) + shoulder * np.arccos(D[3] / reach) + np.pi / 2
        c5 = (T[0, 3] * np.sin(q1) - T[1, 3] * np.cos(q1) - D[3]) / D[5]
        if abs(c5) > 1.0:
            continue
        q5 = wrist * np.arccos(c5)
        s5 = np.sin(q5)
        q6 = np.arctan2((-T[0, 1] * np.sin(q1) + T[1, 1] * np.cos(q1)) / s5,
                        (T[0, 0] * np.sin(q1) - T[1, 0] * np.cos(q1)) / s5)
        first = frames([q1, 0, 0, 0, 0, 0])[0]
        link = np.eye(4)
        for angle, d, alpha in ((q5, D[4], ALPHA[4]), (q6, D[5], ALPHA[5])):
            c, s, ca, sa = np.cos(angle), np.sin(angle), np.cos(alpha), np.sin(alpha)
            link = link @ np.array([[c, -s * ca, s * sa, 0], [s, c * ca, -c * sa, 0],
                                    [0, sa, ca, d], [0, 0, 0, 1.0]])
        inner = np.linalg.inv(first) @ T @ np.linalg.inv(link)
        # frame 4 seen from frame 1: d4 along z_4's axis is taken off
        point = inner[:3, 3] - D[3] * np.array([0.0, 0.0, 1.0])
        c3 = (point[0]**2 + point[1]**2 - A[1]**2 - A[2]**2) / (2 * A[1] * A[2])
        if abs(c3) > 1.0:
            continue
        q3 = elbow * np.arccos(c3)
        q2 = (np.arctan2(point[1], point[0])
              - np.arctan2(A[2] * np.sin(q3), A[1] + A[2] * np.cos(q3)))
        q4 = np.arctan2(inner[1, 0], inner[0, 0]) - q2 - q3
        found.append(np.array([q1, q2, q3, q4, q5, q6]))
    return found


def inverse_kinematics(T, q_near):
    wrapped = [q + 2 * np.pi * np.round((q_near - q) / (2 * np.pi)) for q in solutions(T)]
    return min(wrapped, key=lambda q: np.abs(q - q_near).sum())


def number_of_solutions(T):
    return len(solutions(T))
