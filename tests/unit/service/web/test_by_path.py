"""What may be at a path: all that the list in its order would have given, and little more."""

import pytest

from truepose.web.middleware.routing import RouteTable

PATHS = ("/", "/{name}", "/jobs", "/api/v1/jobs", "/api/v1/jobs/{id}", "/api/v1/{any}/x", "/jobs/{id}")


@pytest.mark.parametrize(
    ("asked", "found"),
    [
        pytest.param("/", ["/", "/{name}", "/api/v1/{any}/x"], id="the root"),
        pytest.param("/jobs", ["/{name}", "/jobs", "/api/v1/{any}/x", "/jobs/{id}"], id="a page"),
        pytest.param(
            "/api/v1/jobs/3",
            ["/{name}", "/api/v1/jobs", "/api/v1/jobs/{id}", "/api/v1/{any}/x"],
            id="a record",
        ),
        pytest.param("/api/v1/no", ["/{name}", "/api/v1/{any}/x"], id="no resource"),
        pytest.param("", ["/{name}", "/api/v1/{any}/x"], id="no path"),
    ],
)
def test_what_begins_otherwise_is_passed_over_and_what_is_left_keeps_its_order(asked, found):
    assert list(RouteTable((path, path) for path in PATHS).at(asked)) == found


def test_where_nothing_has_an_open_first_word_nothing_is_found_elsewhere():
    assert list(RouteTable([("/jobs", 1)]).at("/other")) == []
