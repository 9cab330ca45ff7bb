"""An identified arm of Universal Robots as `calibrated_kinematics.yaml`."""

import hashlib
from collections.abc import Iterator

from truepose.domain.errors import UnsuitableModelError
from truepose.domain.sentences import Sentence, said
from truepose.exchange.exports.subject import Subject, remarks
from truepose.exchange.exports.urdf import joint_origin, roll_pitch_yaw
from truepose.exchange.robots.calibrated_kinematics import is_of_that_structure, kinematics_document
from truepose.words.catalogue import english


def kinematics_text(subject: Subject) -> str:
    """Return the content of the file.

    Raises
    ------
    UnsuitableModelError
        The model is of another kind of arm.
    """
    if not is_of_that_structure(subject.model.robot):
        raise UnsuitableModelError(
            f"{subject.model.robot.name} has not the axes of an arm of Universal Robots, which this format "
            "describes: export it as URDF."
        )
    frames = [joint_origin(row) for row in subject.arm.robot.joints]
    origins = [(frame[:3, 3].tolist(), roll_pitch_yaw(frame[:3, :3])) for frame in frames]
    comment = "".join(f"# {english(sentence)}\n" for sentence in kinematics_remarks(subject))
    return comment + kinematics_document(origins, _hash(origins))


def kinematics_remarks(subject: Subject) -> Iterator[Sentence]:
    """Yield what the file does not hold."""
    yield from remarks(subject)
    yield said("exports.ros.arm_only")
    yield said("exports.ros.hash")


def _hash(origins: object) -> str:
    """Return a mark that changes with the numbers; a controller's own is made otherwise."""
    return "truepose_" + hashlib.sha256(repr(origins).encode()).hexdigest()[:16]
