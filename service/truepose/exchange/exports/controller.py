"""Values for a controller as text to be typed in."""

import math
from collections.abc import Iterator

from truepose.correction.controller_values import ControllerValues
from truepose.correction.zone_errors import ZoneError
from truepose.domain.results.identification import Model
from truepose.domain.sentences import Sentence, said
from truepose.exchange.exports.dhm_table import placement_words, point_words
from truepose.words.catalogue import english


def values_text(model: Model, values: ControllerValues) -> str:
    """Return the values, their accuracy and what they mean."""
    return "\n".join([
        model.robot.name,
        "",
        "joint zeros: true angle minus the angle that the controller shows",
        *(f"  joint {k}: {math.degrees(zero):.5f} deg" for k, zero in enumerate(values.joint_zeros_rad, 1)),
        "",
        f"base in the frame of the readings: {placement_words(values.base)}",
        f"frame of the readings in the base: {placement_words(values.world)}",
        "",
        *(f"tool point at nest {nest.nest}: {point_words(nest.centre_mm)}" for nest in values.tool_points),
        *_tool_frame(values),
        "",
        *(english(sentence) for sentence in controller_remarks(values)),
        "",
    ])


def _tool_frame(values: ControllerValues) -> Iterator[str]:
    if values.tool_frame is not None:
        yield f"tool frame of nests 1, 2, 3: {placement_words(values.tool_frame)}"


def controller_remarks(values: ControllerValues) -> Iterator[Sentence]:
    """Yield what the values reach, and how to read them."""
    yield said("exports.controller.nominal", **_sizes(values.nominal))
    yield said("exports.controller.reached", **_sizes(values.controller))
    yield said("exports.controller.model", **_sizes(values.model))
    yield said("exports.controller.angles")
    yield said("exports.controller.first_joint")


def _sizes(error: ZoneError) -> dict[str, float]:
    return {"mean_mm": error.mean_mm, "largest_mm": error.max_mm}
