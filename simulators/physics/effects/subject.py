"""Who a planted change is about."""

import re

from simulators.errors import ScenarioError
from simulators.physics.arm import Arm
from simulators.physics.effects.effect import PlantedChange


def joint_index(change: PlantedChange, arm: Arm) -> int:
    """0-based joint of a subject such as "joint 3"; raises ScenarioError."""
    match = re.fullmatch(r"joint ([1-9][0-9]*)", change.subject)
    if match is None or int(match[1]) > arm.n_joints:
        raise ScenarioError(
            f'effect {change.name}: subject "{change.subject}" must be "joint 1" to "joint {arm.n_joints}"'
        )
    return int(match[1]) - 1
