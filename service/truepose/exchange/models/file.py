"""Model files: JSON, versioned, with a digest; and the file of what is believed of a further robot."""

from dataclasses import dataclass
from pathlib import Path
from typing import Final, cast, get_args

import numpy as np

from truepose.domain.errors import TrueposeError
from truepose.domain.identification import Model, Unit
from truepose.effects.ports import ParameterSpec
from truepose.effects.registry import chosen_effects
from truepose.exchange.document import (
    NUMBER,
    TEXT,
    Key,
    Node,
    each,
    json_document,
    number,
    read_bytes,
    read_keys,
    record,
)
from truepose.exchange.errors import NewerVersionError
from truepose.exchange.json_text import Json, render_json
from truepose.exchange.models.digest import Integrity, integrity_of, require_unedited
from truepose.exchange.models.document import (
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


@dataclass(frozen=True, slots=True)
class _Parameter:
    """As the file has it, in its units."""

    name: str
    effect: str
    unit: str
    prior_mean: float
    prior_width: float
    value: float


_PARAMETER: Final = record(
    _Parameter,
    [
        *(Key(name, name, TEXT) for name in ("name", "effect", "unit")),
        Key("prior_mean", "prior_mean", NUMBER),
        Key("prior_width", "prior_width", number(above=0.0)),
        Key("value", "value", NUMBER),
    ],
)


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
    found = read_keys(root, [Key("robot", "robot", TEXT), Key("parameters", "parameters", each(_PARAMETER))])
    return Pooled(found["robot"], _belief(root, found["parameters"]))


def _belief(root: Node, parameters: tuple[_Parameter, ...]) -> JointPrior:
    nodes = root.key("parameters").items()
    units = [_unit(node.key("unit")) for node in nodes]
    for node in nodes:
        _check_effect(node.key("effect"))
    factors = np.array([file_factor(unit) for unit in units])
    specs = tuple(
        ParameterSpec(one.name, unit, one.prior_mean / factor, one.prior_width / factor)
        for one, unit, factor in zip(parameters, units, factors.tolist(), strict=True)
    )
    covariance = read_covariance(root.key("covariance"), len(specs)) / np.outer(factors, factors)
    if not np.all(np.isfinite(covariance)):
        root.key("covariance").fail("the covariance must be known completely")
    values = np.array([one.value for one in parameters])
    return JointPrior(specs, tuple(one.effect for one in parameters), values / factors, covariance)


def _unit(node: Node) -> Unit:
    unit = node.text()
    if unit not in _UNITS:
        node.fail(f"{unit!r} is no unit of a parameter; one of {', '.join(_UNITS)} is required")
    return _UNITS[unit]


def _check_effect(node: Node) -> None:
    try:
        chosen_effects([node.text()])
    except TrueposeError as error:
        node.fail(str(error).removesuffix("."))
