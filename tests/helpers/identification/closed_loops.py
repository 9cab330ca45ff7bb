"""Closed loops of a robot without errors: contacts with targets about it."""

from dataclasses import replace

import numpy as np

from tests.helpers.domain.robots import IRB_120
from tests.helpers.identification.synthetic import NESTS, configurations
from truepose.domain.campaign import NO_AXIS, Campaign, ContactReadings, Stops, TargetDistances
from truepose.domain.contacts import SEEN_ALONG_AXES, Target, TargetKind
from truepose.domain.robot import FramePlacement, Nest
from truepose.kinematics.chain import forward, nominal_values
from truepose.kinematics.frames import rotation_xyz

NOISE_MM = 0.002
PLACES = np.array([[420.0, 180.0, 250.0], [300.0, -310.0, 340.0], [150.0, 420.0, 500.0]])
NORMALS = np.array([[0.02, -0.01, 1.0], [1.0, 0.05, 0.03], [-0.04, 1.0, 0.02]])
NORMALS /= np.linalg.norm(NORMALS, axis=1)[:, None]
SENSOR = rotation_xyz(0.3, -0.2, 0.5)  # how the sensor of balls is turned in the flange frame


def contact_campaign(kind, n=60, seed=0, noise_mm=NOISE_MM, known_nests=True, **target):
    """Contacts of nest 1 with three targets of a kind, each as large as the arm goes."""
    joints = np.repeat(configurations(n, seed), 3, axis=0)
    number = np.tile(np.arange(3), n)
    axes = np.tile(np.arange(3), n) if kind in SEEN_ALONG_AXES else np.full(3 * n, NO_AXIS)
    if kind in SEEN_ALONG_AXES:
        number = np.repeat(np.arange(n) % 3, 3)
    chain = forward(nominal_values(IRB_120, joints), np.eye(3), np.zeros(3))
    place = chain.points(np.array(NESTS[0]))
    arm = place - PLACES[number]
    reading = np.linalg.norm(arm, axis=1) - (target.get("zero_mm") or 0.0)
    if kind in (TargetKind.PLANE, TargetKind.GAUGE):
        reading = (arm * NORMALS[number]).sum(axis=1)
    elif kind is TargetKind.BALL:
        along = (chain.end_rotation @ SENSOR)[np.arange(3 * n), :, axes]
        reading = -(arm * along).sum(axis=1)
    elif kind is TargetKind.FACE:
        along = (chain.end_rotation @ SENSOR)[np.arange(3 * n), :, axes]
        height, facing = ((x * NORMALS[number]).sum(axis=1) for x in (arm, along))
        met = np.abs(facing) > 0.5
        number, joints, axes = number[met], joints[met], axes[met]
        reading = -height[met] / facing[met]
    n_read = len(reading)
    reading += noise_mm * np.random.default_rng(seed + 1).standard_normal(n_read)
    contacts = ContactReadings(
        Stops(np.arange(n_read) if kind is TargetKind.FACE else np.repeat(np.arange(n), 3), joints),
        number + 1,
        np.ones(n_read, np.int64),
        reading,
        np.full(n_read, noise_mm),
        axes if kind in SEEN_ALONG_AXES else None,
    )
    return Campaign(
        robot=replace(IRB_120, masses=()),
        base_nominal=FramePlacement(),
        nests=tuple(Nest(centre if known_nests else None, 0.002) for centre in NESTS[:1]),
        contacts=contacts,
        targets=tuple(Target(k, kind, **target) for k in (1, 2, 3)),
    )


def with_distance(campaign, first=1, second=2, u_mm=0.001):
    """The campaign with a certified distance of two of its targets."""
    length = float(np.linalg.norm(PLACES[first - 1] - PLACES[second - 1]))
    distances = TargetDistances(np.array([first]), np.array([second]), np.array([length]), np.array([u_mm]))
    return replace(campaign, target_distances=distances)
