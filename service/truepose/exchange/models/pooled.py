"""What is believed of a further robot of a type, as a file: `truepose fleet --pooled` writes it."""

from dataclasses import dataclass
from pathlib import Path
from typing import Final, cast, get_args

import numpy as np

from truepose.domain.errors import TrueposeError
from truepose.domain.results.identification import Unit
from truepose.effects.ports import ParameterSpec
from truepose.effects.registry import chosen_effects
from truepose.exchange.document import Node, json_document
from truepose.exchange.errors import NewerVersionError
from truepose.exchange.input_file import read_bytes
from truepose.exchange.json_text import Json, render_json
from truepose.exchange.keys import NUMBER, TEXT, Key, each, number, read_keys, record
from truepose.exchange.models.covariance import covariance_document, read_covariance
from truepose.exchange.models.document import file_factor, file_unit
from truepose.identification.problem.belief import Belief

_FORMAT: Final = 1
_UNITS: Final = {file_unit(unit): unit for unit in cast(tuple[Unit, ...], get_args(Unit))}


@dataclass(frozen=True, slots=True)
class Pooled:
    """What robots of one type say of a further one."""

    robot: str  # the type
    belief: Belief


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


def _belief(root: Node, parameters: tuple[_Parameter, ...]) -> Belief:
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
    return Belief(specs, tuple(one.effect for one in parameters), values / factors, covariance)


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
