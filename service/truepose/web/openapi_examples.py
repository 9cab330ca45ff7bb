"""Examples of everything that the interface takes and gives, in its document.

A schema has an example of its own where one was written; else it is put together from those of its fields.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, Final

Schema = Mapping[str, Any]
_DEEPEST: Final = 12  # levels; below them a list stays empty: a schema may hold itself
_TEXTS: Final = {"date": "2026-03-03", "date-time": "2026-03-03T09:12:33Z", "binary": ""}
_JSON: Final = "application/json"
_USUAL: Final = {  # what texts of these names hold, wherever a schema has no example of its own
    "answered_serial_number": "391234",
    "branch": "front, up, no flip",
    "cautions": "Targets outside the measured zone are corrected less accurately.",
    "cells": "512.4",
    "centre": "nest 1",
    "certainty": "read",
    "certificate": "report 7",
    "certificate_expires": "2027-03-03",
    "column": "x_mm",
    "corrected_sha256": "9f86d081884c7d65",
    "effect": "joint_harmonics",
    "effects": "geometry",
    "expected_serial_number": "390003",
    "file": "weld.mod",
    "heading": "X [mm]",
    "ignored": "torques.csv",
    "instrument_serial": "391234",
    "key": "tablet-1-17",
    "kind": "joint_sign",
    "kept_out": "column",
    "message": "reading the campaign",
    "model": "model 3",
    "name": "left arm",
    "notes": "Two readings were repeated.",
    "original_sha256": "2c26b46b68ffc68f",
    "parameters": "theta_2",
    "outcome": "Mean error 0.412 mm before (nominal), 0.0381 mm predicted after 60 configurations.",
    "people": "Ada Byron",
    "person": "Ada Byron",
    "program_version": "0.1.0",
    "quantity": "x",
    "reason": "The plan is stored; nothing has moved.",
    "remarks": "The residuals are consistent with the stated noise.",
    "robot": "ABB IRB 120",
    "robot_serial_number": "120-500123",
    "role": "calibration",
    "sentence": "Joint 6 has a periodic error of 2 periods per turn, amplitude 0.029 deg.",
    "serial_number": "391234",
    "shown": "512.4",
    "source": "Product specification 3HAC035960",
    "start_effects": "geometry",
    "step_id": "placement-1/pose-3/leg-1-2",
    "subject": "joint 6",
    "suspected": "leg 1-2",
    "symbol": "AP",
    "tablet": "tablet-1",
    "target": "p10",
    "text": "Stored.",
    "tool": "probe 50 mm",
    "unit": "mm",
    "withdrawn": "backlash of joint 2",
    "withheld": "RP: fewer than 30 cycles were measured.",
}


def add_examples(document: dict[str, Any]) -> None:
    """Give every body and every reply in JSON that has none an example."""
    write = _Writer(document.get("components", {}).get("schemas", {}))
    for content in _contents(document):
        if _JSON in content and not {"example", "examples"} & content[_JSON].keys():
            content[_JSON]["example"] = write.example(content[_JSON].get("schema", {}))


def _contents(document: dict[str, Any]) -> Iterator[dict[str, Any]]:
    for methods in document["paths"].values():
        for operation in methods.values():
            yield operation.get("requestBody", {}).get("content", {})
            yield from (reply.get("content", {}) for reply in operation["responses"].values())


@dataclass(frozen=True, slots=True)
class _Writer:
    schemas: Mapping[str, Schema]

    def example(self, schema: Schema, name: str = "", depth: int = 0) -> Any:
        """Return what fits the schema of a field and says what it is for."""
        if "$ref" in schema:
            return self.example(self.schemas[schema["$ref"].rpartition("/")[2]], name, depth)
        if schema.get("examples"):
            return schema["examples"][0]
        for said in ("const", "default"):
            if schema.get(said) is not None:
                return schema[said]
        if "enum" in schema:
            return schema["enum"][0]
        choices = schema.get("anyOf") or schema.get("oneOf") or schema.get("allOf")
        return self.example(choices[0], name, depth) if choices else self._plain(schema, name, depth)

    def _plain(self, schema: Schema, name: str, depth: int) -> Any:
        match schema.get("type"):
            case "object":
                return self._object(schema, depth)
            case "array":
                return self._array(schema, name, depth)
            case "string":
                return _TEXTS.get(schema.get("format", ""), _USUAL.get(name))
            case "integer" | "number":
                return max(schema.get("minimum", 1), schema.get("exclusiveMinimum", 0) + 1)
            case "boolean":
                return True
        return None

    def _object(self, schema: Schema, depth: int) -> dict[str, Any]:
        fields = schema.get("properties", {})
        shown = fields if depth < _DEEPEST else schema.get("required", [])
        return {name: self.example(fields[name], name, depth + 1) for name in shown}

    def _array(self, schema: Schema, name: str, depth: int) -> list[Any]:
        if "prefixItems" in schema:
            return [self.example(item, name, depth + 1) for item in schema["prefixItems"]]
        count = max(schema.get("minItems", 0), 1 if depth < _DEEPEST else 0)
        return [self.example(schema.get("items", {}), name, depth + 1) for _ in range(count)]
