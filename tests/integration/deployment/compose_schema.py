"""The part of the Compose Specification that our file uses, as a JSON schema that refuses all the rest.

Source: compose-spec.io, "Compose file reference" (top-level elements, services, build, networks, volumes).
A key that we begin to use is added here with the form the specification gives it.
"""

_TEXT = {"type": "string", "minLength": 1}
_TEXTS = {"type": "array", "items": _TEXT, "minItems": 1, "uniqueItems": False}
_NAME = "^[a-zA-Z0-9._-]+$"
_DURATION = {"type": "string", "pattern": r"^(\d+h)?(\d+m)?(\d+s)?(\d+ms)?$", "minLength": 2}


def _closed(properties, required=()):
    return {
        "type": "object",
        "properties": properties,
        "required": list(required),
        "additionalProperties": False,
    }


def _named(entry):
    return {"type": "object", "patternProperties": {_NAME: entry}, "additionalProperties": False}


_HEALTHCHECK = _closed(
    {
        "test": {
            "type": "array",
            "prefixItems": [{"enum": ["CMD", "CMD-SHELL", "NONE"]}],
            "items": _TEXT,
            "minItems": 2,
        },
        "interval": _DURATION,
        "timeout": _DURATION,
        "retries": {"type": "integer", "minimum": 1},
        "start_period": _DURATION,
    },
    required=["test"],
)

_CONDITION = _closed(
    {
        "condition": {
            "enum": ["service_started", "service_healthy", "service_completed_successfully"],
        }
    },
    required=["condition"],
)

_SERVICE = _closed(
    {
        "build": _closed({"context": _TEXT, "dockerfile": _TEXT}, required=["context"]),
        "command": _TEXTS,
        "networks": {"type": "array", "items": {"type": "string", "pattern": _NAME}, "uniqueItems": True},
        "depends_on": _named(_CONDITION),
        "ports": {
            "type": "array",
            "items": {"type": "string", "pattern": r"^(\d+(\.\d+){3}:)?\d+:\d+(/(tcp|udp))?$"},
        },
        "volumes": {"type": "array", "items": {"type": "string", "pattern": r"^[^:]+:/[^:]+(:(ro|rw))?$"}},
        "healthcheck": _HEALTHCHECK,
        "init": {"type": "boolean"},
        "restart": {"enum": ["no", "always", "on-failure", "unless-stopped"]},
        "stop_grace_period": _DURATION,
        "profiles": {"type": "array", "items": {"type": "string", "pattern": "^[a-zA-Z0-9][a-zA-Z0-9_.-]+$"}},
        "network_mode": {"enum": ["none", "host"]},
        "cap_drop": _TEXTS,
        "security_opt": _TEXTS,
    },
    required=["build"],
)

COMPOSE_SCHEMA = {
    "$schema": "https://json-schema.org/draft/2020-12/schema",
    **_closed(
        {
            "name": {"type": "string", "pattern": "^[a-z0-9][a-z0-9_-]*$"},
            "services": _named(_SERVICE),
            "networks": _named({"anyOf": [{"type": "null"}, _closed({"internal": {"type": "boolean"}})]}),
            "volumes": _named({"type": "null"}),
        },
        required=["services"],
    ),
}
