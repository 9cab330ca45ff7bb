"""The oldest versions that are promised are those that are tried."""

import re
import tomllib

from tests.helpers.checkout import CHECKOUT

# What a user installs; tools of the project itself are always the newest.
EXTRAS = ("notebook", "postgresql", "contract", "dask")
_BOUND = re.compile(r"(?P<name>[\w-]+)(\[\w+\])?>=(?P<version>[\d.]+)")


def _lower_bounds():
    project = tomllib.loads((CHECKOUT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    optional = project["optional-dependencies"]
    required = [*project["dependencies"], *(one for extra in EXTRAS for one in optional[extra])]
    found = {one: _BOUND.match(one) for one in required}
    unbounded = [one for one, bound in found.items() if bound is None]
    assert not unbounded, "each has a lower bound, which is tried"
    return {f"{bound['name']}=={bound['version']}" for bound in found.values()}


def test_the_constraints_are_the_lower_bounds():
    lines = (CHECKOUT / "tests" / "oldest.txt").read_text(encoding="utf-8").splitlines()

    assert {line for line in lines if not line.startswith("#")} == _lower_bounds()
