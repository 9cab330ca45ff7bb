"""Model files: JSON, versioned, with a digest; and the file of what is believed of a further robot."""

from dataclasses import dataclass
from pathlib import Path
from typing import Final, cast, get_args

import numpy as np

from truepose.domain.errors import TrueposeError
from truepose.domain.identification import Model, Unit
from truepose.effects.ports import ParameterSpec
from truepose.effects.registry import chosen_effects
from truepose.exchange.document import Node, json_document, read_bytes
from truepose.exchange.errors import NewerVersionError, UnreadableFileError
from truepose.exchange.json_text import Json, render_json
from truepose.exchange.models.digest import Integrity, integrity_of, require_unedited
from truepose.exchange.models.document import (
    NOT_A_MODEL,
    check_format,
    file_factor,
    file_unit,
    model_document,
    read_model_document,
)
from truepose.exchange.robots.document import covariance_document, read_covariance
from truepose.identification.problem.build import JointPrior


@dataclass(frozen=True, slots=True)
class ModelFile:
    """A model, and what its digest says."""

    model: Model
    integrity: Integrity


def model_text(model: Model) -> str:
    """Return the text of a model file."""
    return render_json(model_document(model)) + "\n"


def model_file_from_text(text: bytes, name: str, *, accept_edited: bool = False) -> ModelFile:
    """Read a model from the content of a file called `name`.

    Raises
    ------
    NewerVersionError
        A later program wrote it.
    EditedFileError
        It was edited after truepose wrote it, and that is not accepted.
    InputFileError
        It is cut off, of another kind, or a value in it cannot be meant.
    """
    if b"\0" in text:  # a picture, say: that it is not UTF-8 would not help
        raise UnreadableFileError(NOT_A_MODEL, file=name)
    root = json_document(name, text)
    check_format(root)
    # Before the values are read: an edit that no reader would notice is still an edit.
    integrity = integrity_of(root.entries()) if accept_edited else require_unedited(root)
    return ModelFile(read_model_document(root), integrity)


def model_from_text(text: bytes, name: str) -> Model:
    """Read a model that nobody edited; raises as `model_file_from_text`."""
    return model_file_from_text(text, name).model


def write_model(model: Model, file: Path) -> None:
    """Write a model file."""
    file.write_text(model_text(model), encoding="utf-8", newline="\n")


def read_model_file(file: Path, *, accept_edited: bool = False) -> ModelFile:
    """Read a model file; raises as `model_file_from_text`, and MissingFileError."""
    return model_file_from_text(read_bytes(file), file.name, accept_edited=accept_edited)


def read_model(file: Path) -> Model:
    """Read a model file that nobody edited; raises as `read_model_file`."""
    return read_model_file(file).model


_FORMAT: Final = 1
_UNITS: Final = {file_unit(unit): unit for unit in cast(tuple[Unit, ...], get_args(Unit))}


@dataclass(frozen=True, slots=True)
class Pooled:
    """What robots of one type say of a further one."""

    robot: str  # the type
    belief: JointPrior


def pooled_text(pooled: Pooled) -> str:
    """Return the text of a file."""
    belief = pooled.belief
    factors = np.array([file_factor(spec.unit) for spec in belief.specs])
    parameters: list[Json] = [
        {
            "name": spec.name,
            "effect": owner,
            "unit": file_unit(spec.unit),
            "prior_mean": spec.prior_mean * factor,
            "prior_width": spec.prior_width * factor,
            "value": value * factor,
        }
        for spec, owner, value, factor in zip(
            belief.specs, belief.owners, belief.mean.tolist(), factors.tolist(), strict=True
        )
    ]
    covariance = covariance_document(belief.covariance * np.outer(factors, factors))
    document: dict[str, Json] = {
        "truepose_fleet": _FORMAT,
        "robot": pooled.robot,
        "parameters": parameters,
        "covariance": covariance,
    }
    return render_json(document) + "\n"


def write_pooled(file: Path, pooled: Pooled) -> None:
    """Write a file."""
    file.write_text(pooled_text(pooled), encoding="utf-8", newline="\n")


def read_pooled(file: Path) -> Pooled:
    """Read a file.

    Raises
    ------
    NewerVersionError
        A later program wrote it.
    InputFileError
        It is cut off, of another kind, or a value in it cannot be meant.
    """
    root = json_document(file.name, read_bytes(file))
    version = root.key("truepose_fleet")
    if version.whole(least=1) > _FORMAT:
        version.fail("a later version of this program wrote it", NewerVersionError)
    return Pooled(root.key("robot").text(), _belief(root))


def _belief(root: Node) -> JointPrior:
    nodes = root.key("parameters").items()
    specs = tuple(map(_spec, nodes))
    owners = tuple(_effect(node.key("effect")) for node in nodes)
    factors = np.array([file_factor(spec.unit) for spec in specs])
    covariance = read_covariance(root.key("covariance"), len(specs)) / np.outer(factors, factors)
    if not np.all(np.isfinite(covariance)):
        root.key("covariance").fail("the covariance must be known completely")
    values = np.array([node.key("value").number() for node in nodes])
    return JointPrior(specs, owners, values / factors, covariance)


def _spec(node: Node) -> ParameterSpec:
    name, unit = node.key("name").text(), _unit(node.key("unit"))
    mean, width = node.key("prior_mean").number(), node.key("prior_width").number(above=0.0)
    return ParameterSpec(name, unit, mean / file_factor(unit), width / file_factor(unit))


def _unit(node: Node) -> Unit:
    unit = node.text()
    if unit not in _UNITS:
        node.fail(f"{unit!r} is not a unit of a parameter; one of {', '.join(_UNITS)} is required")
    return _UNITS[unit]


def _effect(node: Node) -> str:
    try:
        chosen_effects([node.text()])
    except TrueposeError as error:
        node.fail(str(error).removesuffix("."))
    return node.text()
