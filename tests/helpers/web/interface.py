"""What programs rely on in the OpenAPI document: kept without its prose, and what a change breaks of it.

What was taken has to be taken still, and what was answered has to be answered still. More may be taken, and
more answered: new operations, new fields of answers, new fields of requests that may be left out. A new value
in an answer is more as well; clients are asked to take what they do not know for unknown.
"""

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, Final

Schema = Mapping[str, Any]
_LOWEST: Final = ("minimum", "exclusiveMinimum", "minLength", "minItems", "minProperties")
_HIGHEST: Final = ("maximum", "exclusiveMaximum", "maxLength", "maxItems", "maxProperties")
_EXACT: Final = ("format", "pattern", "uniqueItems")
_ALTERNATIVES: Final = ("anyOf", "oneOf")
_BY_NAME: Final = ("properties", "patternProperties")
_OF_EACH: Final = ("items", "additionalProperties")
_SAYS: Final = {"$ref", "type", "enum", "const", "default", "required"}.union(
    _LOWEST, _HIGHEST, _EXACT, _ALTERNATIVES, _BY_NAME, _OF_EACH
)


def interface_of(document: Schema) -> dict[str, Any]:
    """Return what programs rely on in an OpenAPI document: operations by their names, and schemas."""
    operations = {
        operation["operationId"]: _operation(method, path, operation)
        for path, methods in document["paths"].items()
        for method, operation in methods.items()
    }
    schemas = {name: _bare(schema) for name, schema in document["components"]["schemas"].items()}
    return {"operations": dict(sorted(operations.items())), "schemas": dict(sorted(schemas.items()))}


def written(interface: Mapping[str, Any]) -> str:
    """Return an interface as JSON with a line for each parameter, field, body and answer."""
    return "\n".join(_lines(interface, "", 4)) + "\n"


def _lines(node: Any, indent: str, depth: int) -> Iterator[str]:
    if depth == 0 or not isinstance(node, dict) or not any(isinstance(one, dict) for one in node.values()):
        yield json.dumps(node, ensure_ascii=False)
        return
    yield "{"
    for number, (key, value) in enumerate(node.items(), start=1):
        first, *rest = _lines(value, f"{indent} ", depth - 1)
        comma = "," if number < len(node) else ""
        lines = [f"{indent} {json.dumps(key)}: {first}", *rest]
        yield from lines[:-1]
        yield lines[-1] + comma
    yield f"{indent}}}"


def _operation(method: str, path: str, operation: Schema) -> dict[str, Any]:
    body = operation.get("requestBody", {})
    return {
        "at": f"{method.upper()} {path}",
        "parameters": {
            f"{one['in']} {one['name']}": {"needed": one.get("required", False), **_bare(one["schema"])}
            for one in operation.get("parameters", ())
        },
        "body_required": body.get("required", False),
        "body": _contents(body),
        "answers": {
            status: {"headers": sorted(answer.get("headers", ())), **_contents(answer)}
            for status, answer in operation["responses"].items()
            if int(status) < 400
        },
    }


def _contents(holder: Schema) -> dict[str, Any]:
    return {media: _bare(held.get("schema", {})) for media, held in holder.get("content", {}).items()}


def _bare(schema: Any) -> Any:
    """Return a schema without what is only prose."""
    if not isinstance(schema, Mapping):
        return schema
    bare = {key: value for key, value in schema.items() if key in _SAYS}
    for key in _BY_NAME:
        if key in bare:
            bare[key] = {name: _bare(one) for name, one in bare[key].items()}
    for key in _ALTERNATIVES:
        if key in bare:
            bare[key] = [_bare(one) for one in bare[key]]
    for key in _OF_EACH:
        if key in bare:
            bare[key] = _bare(bare[key])
    return bare


def broken(before: Mapping[str, Any], now: Mapping[str, Any]) -> list[str]:
    """Return a sentence for each promise of an interface that another one does not keep."""
    found: list[str] = []
    for name, old in before["operations"].items():
        new = now["operations"].get(name)
        found += _gone(name, old, now) if new is None else _of_operation(name, old, new, before, now)
    asked, answered = {"schemas": before["schemas"]}, {"schemas": now["schemas"]}
    if "Problem" in before["schemas"]:
        problem = {"$ref": "#/components/schemas/Problem"}
        found += _Comparison(answered, asked, answers=True).found_in(problem, problem, "every refusal")
    return found


def _gone(name: str, old: Schema, now: Mapping[str, Any]) -> list[str]:
    other = next((other for other, one in now["operations"].items() if one["at"] == old["at"]), None)
    if other is not None:
        return [f"{name}: {old['at']} is called {other} now; generated clients call it by its name."]
    return [f"{name}: {old['at']} is gone."]


def _of_operation(
    name: str, old: Schema, new: Schema, before: Mapping[str, Any], now: Mapping[str, Any]
) -> list[str]:
    found = [] if old["at"] == new["at"] else [f"{name}: it was at {old['at']} and is at {new['at']}."]
    found += _of_parameters(name, old, new, before, now)
    if new["body_required"] and not old["body_required"]:
        found.append(f"{name}: it has to have a body now.")
    takes, gives = _Comparison(before, now), _Comparison(now, before, answers=True)
    for media, schema in old["body"].items():
        if media not in new["body"]:
            found.append(f"{name}: a body as {media} is refused now.")
        else:
            found += takes.found_in(schema, new["body"][media], f"{name}: the body")
    for status, answer in old["answers"].items():
        found += _of_answer(f"{name}: answer {status}", answer, new["answers"].get(status), gives)
    return found


def _of_parameters(
    name: str, old: Schema, new: Schema, before: Mapping[str, Any], now: Mapping[str, Any]
) -> list[str]:
    found = []
    for parameter, wanted in new["parameters"].items():
        if wanted["needed"] and not old["parameters"].get(parameter, {}).get("needed"):
            found.append(f"{name}: parameter {parameter} has to be given now.")
    for parameter, schema in old["parameters"].items():
        if parameter not in new["parameters"]:
            found.append(f"{name}: parameter {parameter} is refused now.")
        else:
            there = new["parameters"][parameter]
            found += _Comparison(before, now).found_in(schema, there, f"{name}: parameter {parameter}")
    return found


def _of_answer(where: str, old: Schema, new: Schema | None, gives: "_Comparison") -> list[str]:
    if new is None:
        return [f"{where} is never given now."]
    found = [f"{where}: header {one} is gone." for one in old["headers"] if one not in new["headers"]]
    for media, schema in old.items():
        if media == "headers":
            continue
        if media not in new:
            found.append(f"{where} is not given as {media} now.")
        else:
            found += gives.found_in(new[media], schema, where)
    return found


@dataclass
class _Comparison:
    """Whether whatever fits a schema of one interface, `narrow`, fits one of another, `wide`."""

    narrow: Mapping[str, Any]
    wide: Mapping[str, Any]
    answers: bool = False  # of what is answered `narrow` is the new one
    _seen: set[tuple[str, str]] = field(default_factory=set)

    def found_in(self, narrow: Schema, wide: Schema, where: str) -> list[str]:
        """Return what does not fit."""
        pair = (narrow.get("$ref", ""), wide.get("$ref", ""))
        if all(pair):
            if pair in self._seen:
                return []
            self._seen.add(pair)
        narrow, wide = _followed(narrow, self.narrow), _followed(wide, self.wide)
        kinds, known = _kinds(narrow), _kinds(wide)
        if len(kinds) > 1 or len(known) > 1:
            return [said for kind in kinds for said in self._among(kind, known, where)]
        return self._plain(narrow, wide, where)

    def _among(self, kind: Schema, known: list[Schema], where: str) -> list[str]:
        tried = [
            _Comparison(self.narrow, self.wide, self.answers).found_in(kind, one, where) for one in known
        ]
        if any(not found for found in tried):
            return []
        alike = [found for found, one in zip(tried, known, strict=True) if _called(one) == _called(kind)]
        return alike[0] if alike else [f"{where} {self._cannot(_called(kind))}."]

    def _cannot(self, what: str) -> str:
        return f"may be {what} now" if self.answers else f"may not be {what} now"

    def _plain(self, narrow: Schema, wide: Schema, where: str) -> list[str]:
        kind, known = narrow.get("type"), wide.get("type")
        if known is not None and kind != known and (kind, known) != ("integer", "number"):
            other = (kind, known) if self.answers else (known, kind)
            return [f"{where} is {other[0] or 'anything'} now, and was {other[1] or 'anything'}."]
        found = self._limits(narrow, wide, where) + self._values(narrow, wide, where)
        if "items" in narrow and "items" in wide:
            found += self.found_in(narrow["items"], wide["items"], f"{where}: each of them")
        return found + self._mapping(narrow, wide, where) + self._fields(narrow, wide, where)

    def _limits(self, narrow: Schema, wide: Schema, where: str) -> list[str]:
        said = [key for key in _LOWEST if key in wide and narrow.get(key, float("-inf")) < wide[key]]
        said += [key for key in _HIGHEST if key in wide and narrow.get(key, float("inf")) > wide[key]]
        said += [key for key in _EXACT if key in wide and narrow.get(key) != wide[key]]
        new, old = (narrow, wide) if self.answers else (wide, narrow)
        found = [
            f"{where}: {key} is {new.get(key, 'open')} now, and was {old.get(key, 'open')}." for key in said
        ]
        if not self.answers and narrow.get("default") != wide.get("default"):
            found.append(
                f"{where}: left out it is {wide.get('default')} now, and was {narrow.get('default')}."
            )
        return found

    def _values(self, narrow: Schema, wide: Schema, where: str) -> list[str]:
        if self.answers or not ({"enum", "const"} & wide.keys()):
            return []
        if not {"enum", "const"} & narrow.keys():
            return [f"{where} has to be one of {', '.join(map(str, _listed(wide)))} now."]
        lost = [value for value in _listed(narrow) if value not in _listed(wide)]
        return [f"{where} may not be {value!r} now." for value in lost]

    def _mapping(self, narrow: Schema, wide: Schema, where: str) -> list[str]:
        pairs = [(narrow.get("additionalProperties"), wide.get("additionalProperties"))]
        named = narrow.get("patternProperties", {}), wide.get("patternProperties", {})
        pairs += [(schema, named[1].get(pattern)) for pattern, schema in named[0].items()]
        found = []
        for one, other in pairs:
            if isinstance(one, Mapping) and isinstance(other, Mapping):
                found += self.found_in(one, other, f"{where}: each value")
        if not self.answers and named[0].keys() - named[1].keys():
            found.append(f"{where}: other keys are taken now.")
        return found

    def _fields(self, narrow: Schema, wide: Schema, where: str) -> list[str]:
        old, new = (wide, narrow) if self.answers else (narrow, wide)
        before, now = old.get("properties", {}), new.get("properties", {})
        needed = set(old.get("required", ())), set(new.get("required", ()))
        gone, late = (
            ("is gone", "may be left out now") if self.answers else ("is refused now", "has to be given now")
        )
        found = [f"{where}: field {name} {gone}." for name in before if name not in now]
        moved = needed[0] - needed[1] if self.answers else needed[1] - needed[0]
        found += [f"{where}: field {name} {late}." for name in sorted(moved & now.keys())]
        for name in before.keys() & now.keys():
            pair = (now[name], before[name]) if self.answers else (before[name], now[name])
            found += self.found_in(*pair, f"{where}: field {name}")
        return sorted(found)


def _followed(schema: Schema, interface: Mapping[str, Any]) -> Schema:
    return interface["schemas"][_name(schema)] if "$ref" in schema else schema


def _name(schema: Schema) -> str:
    return str(schema["$ref"]).rpartition("/")[2]


def _kinds(schema: Schema) -> list[Schema]:
    """Return the alternatives that a schema has; one that has none is its own."""
    return list(schema.get("anyOf") or schema.get("oneOf") or [schema])


def _called(schema: Schema) -> str:
    return _name(schema) if "$ref" in schema else str(schema.get("type", "anything"))


def _listed(schema: Schema) -> list[Any]:
    return list(schema["enum"]) if "enum" in schema else [schema["const"]]
