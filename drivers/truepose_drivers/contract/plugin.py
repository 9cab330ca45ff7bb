"""What pytest loads at every start where truepose is installed: nothing, unless the contract is asked for.

Its options are short words, as somebody types them, and other plug-ins may have the same.
"""

import pytest

_SUITE = "truepose_drivers.contract"


def pytest_load_initial_conftests(early_config: pytest.Config, args: list[str]) -> None:
    """Bring the options of the suite where it is named on the command line."""
    if any(word.partition("::")[0] in (_SUITE, f"{_SUITE}.test_contract") for word in args):
        early_config.pluginmanager.import_plugin(f"{_SUITE}.suite")
