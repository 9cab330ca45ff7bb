"""Drawn requests of every operation, answered as documented; `make interface-report` draws more."""

import contextlib

import pytest
from hypothesis.errors import Unsatisfiable
from schemathesis import GenerationMode

from tests.integration.web.middleware.test_openapi import (
    OPERATIONS,
    api,
    assert_answered_as_documented,
    connection,
)

__all__ = ["api", "connection"]  # fixtures
ENOUGH = 6  # of each kind, each operation, each run


@pytest.mark.parametrize("mode", [GenerationMode.POSITIVE, GenerationMode.NEGATIVE])
@pytest.mark.parametrize(("method", "path"), OPERATIONS)
def test_what_is_drawn_is_answered_as_documented(api, connection, method, path, mode):
    with contextlib.suppress(Unsatisfiable):  # nothing can be wrong about a request without parameters
        assert_answered_as_documented(api[path][method], mode, connection, ENOUGH)
