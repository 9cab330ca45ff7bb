"""Parameter names: a quantity, an underscore, and the joint, nest or component it belongs to.

Joints and nests are numbered from 1 in names, as people and documents do, and joints from 0 in indices.
"""

_COMPONENTS = "xyz"


def joint_name(quantity: str, joint: int) -> str:
    """Return e.g. `alpha_3` for joint index 2 (0-based)."""
    return f"{quantity}_{joint + 1}"


def joint_of(name: str) -> int:
    """Return the 0-based joint of e.g. `alpha_3`."""
    return int(name.rsplit("_", 1)[1]) - 1


def nest_name(nest: int, component: int) -> str:
    """Return e.g. `nest_2_x` for nest 2 (1-based), component 0."""
    return f"nest_{nest}_{_COMPONENTS[component]}"


def nest_port_index(name: str) -> int:
    """Return the port index of e.g. `nest_2_x`."""
    _, nest, component = name.split("_")
    return 3 * (int(nest) - 1) + _COMPONENTS.index(component)


def joint_subject(joint: int) -> str:
    """Return e.g. `joint 3` for joint index 2 (0-based)."""
    return f"joint {joint + 1}"


def joint_of_subject(subject: str) -> int:
    """Return the 0-based joint of e.g. `joint 3`."""
    return int(subject.rsplit(" ", 1)[1]) - 1
