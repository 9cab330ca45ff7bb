"""Who a planted change is about; every refusal says what may stand there."""

import re

from truepose_simulators.errors import ScenarioError
from truepose_simulators.physics.arm import Arm
from truepose_simulators.physics.effects.effect import PlantedChange


def joint_index(change: PlantedChange, arm: Arm) -> int:
    """0-based joint of a subject such as "joint 3"; raises ScenarioError."""
    return joint_named(change.subject, change, "subject", arm)


def joint_named(text: str, change: PlantedChange, key: str, arm: Arm) -> int:
    """0-based joint of a text such as "joint 3" at `key` of the change; raises ScenarioError."""
    number = _number(text, "joint")
    if number is None or number > arm.n_joints:
        raise _refusal(change, key, text, f'"joint 1" to "joint {arm.n_joints}"')
    return number - 1


def joint_indices(change: PlantedChange, arm: Arm) -> tuple[int, ...]:
    """0-based joints of "joint 3" (one) or "joints" (all); raises ScenarioError."""
    if change.subject == "joints":
        return tuple(range(arm.n_joints))
    number = _number(change.subject, "joint")
    if number is None or number > arm.n_joints:
        raise _refusal(change, "subject", change.subject, f'"joint 1" to "joint {arm.n_joints}" or "joints"')
    return (number - 1,)


def link_numbers(change: PlantedChange, known: tuple[int, ...]) -> tuple[int, ...]:
    """Links of "link 2" (one) or "links" (all `known`), 1-based; raises ScenarioError."""
    if change.subject == "links":
        return known
    number = _number(change.subject, "link")
    if number not in known:
        names = ", ".join(f'"link {link}"' for link in known)
        raise _refusal(change, "subject", change.subject, f'{names} or "links"')
    return (number,)


def nest_index(change: PlantedChange, n_nests: int) -> int:
    """0-based nest of a subject such as "nest 3"; raises ScenarioError."""
    number = _number(change.subject, "nest")
    if number is None or number > n_nests:
        raise _refusal(change, "subject", change.subject, f'"nest 1" to "nest {n_nests}"')
    return number - 1


def placement_number(change: PlantedChange) -> int:
    """Return the number of a subject such as "placement 2"; raises ScenarioError."""
    number = _number(change.subject, "placement")
    if number is None:
        raise _refusal(change, "subject", change.subject, '"placement 1" or another of the base fixture')
    return number


def nest_pair(change: PlantedChange, n_nests: int) -> tuple[int, int]:
    """Both nests of "nest 1, nest 2", ascending, 1-based; raises ScenarioError."""
    numbers = [_number(part, "nest") for part in change.subject.split(", ")]
    match numbers:
        case [int(first), int(second)] if first < second <= n_nests:
            return first, second
    raise _refusal(
        change, "subject", change.subject, f'two of the {n_nests} nests, ascending, such as "nest 1, nest 2"'
    )


def check_only(change: PlantedChange, subject: str) -> None:
    """Raise ScenarioError unless the change is about `subject`, the only thing that it can be about."""
    if change.subject != subject:
        raise _refusal(change, "subject", change.subject, f'"{subject}"')


def check_one_of(change: PlantedChange, *subjects: str) -> None:
    """Raise ScenarioError unless the change is about one of `subjects`."""
    if change.subject not in subjects:
        raise _refusal(change, "subject", change.subject, " or ".join(f'"{name}"' for name in subjects))


def _number(text: str, kind: str) -> int | None:
    match = re.fullmatch(rf"{kind} ([1-9][0-9]{{0,3}})", text)
    return None if match is None else int(match[1])


def _refusal(change: PlantedChange, key: str, text: str, allowed: str) -> ScenarioError:
    return ScenarioError(f'effect {change.name}: {key} "{text}" must be {allowed}')
