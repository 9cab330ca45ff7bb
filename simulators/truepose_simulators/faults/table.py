"""A fault as a table with its `kind`, in a scenario, a file of faults, or a request."""

from collections.abc import Mapping

from truepose_simulators.errors import ScenarioError
from truepose_simulators.faults.kinds import KINDS
from truepose_simulators.faults.times import Fault
from truepose_simulators.scenarios.table import read_table


def read_fault(table: object, where: str) -> Fault:
    """Build a fault from a table; raises ScenarioError."""
    kind = table.get("kind") if isinstance(table, Mapping) else None
    if not isinstance(table, Mapping) or not isinstance(kind, str) or kind not in KINDS:
        raise ScenarioError(f'{where}: key "kind" must be one of {", ".join(KINDS)}')
    rest = {key: value for key, value in table.items() if key != "kind"}
    try:
        return read_table(KINDS[kind], rest, where)
    except ScenarioError as error:
        text = str(error)
        raise ScenarioError(text if text.startswith(where) else f"{where}: {text}") from error
