"""Every case of the contract, asked of every driver that has a bench."""

from collections.abc import Callable

import pytest

from truepose_drivers.contract import codec_fuzz, hostile
from truepose_drivers.contract.bench import NewBench
from truepose_drivers.contract.case import Case, reason_absent, unknown_absences
from truepose_drivers.contract.case import run as require_kept
from truepose_drivers.contract.cases import CASES
from truepose_drivers.contract.link_recovery import require_found

Record = Callable[[str, object], None]


def test_the_bench_leaves_out_cases_that_there_are(driver: str, new_bench: NewBench) -> None:
    """A case that the bench declares absent is one of the contract's, and has a reason."""
    if unknown := unknown_absences(new_bench(), CASES):
        pytest.fail(
            f"`absent` of the bench of {driver} names something that is not a case, or gives no reason:"
            f" {', '.join(unknown)}"
        )


def test_the_driver_keeps(case: Case, driver: str, new_bench: NewBench, record_property: Record) -> None:
    """Ask one case."""
    bench = new_bench()
    record_property("driver", driver)
    record_property("case", case.name)
    if reason := reason_absent(case, bench):
        pytest.skip(reason)
    require_kept(case, new_bench)


def test_hostile_bytes_do_no_harm(
    driver: str, new_bench: NewBench, record_property: Record, pytestconfig: pytest.Config
) -> None:
    """No hostile bytes crash a codec, or hang it."""
    record_property("driver", driver)
    record_property("case", "hostile_bytes_do_no_harm")
    if not codec_fuzz.has_codec(new_bench()):
        pytest.skip("the bench does not say how the codec reads")
    codec_fuzz.require_unharmed(new_bench, pytestconfig.getoption("fuzz_inputs"))


def test_hostile_answers_do_no_harm(
    driver: str, new_bench: NewBench, record_property: Record, pytestconfig: pytest.Config
) -> None:
    """No hostile answer crashes a driver, hangs it, or becomes a reading that something betrays."""
    record_property("driver", driver)
    record_property("case", "hostile_answers_do_no_harm")
    hostile.require_unharmed(new_bench, pytestconfig.getoption("hostile_answers"))


def test_link_faults_are_found_and_pass(
    driver: str, new_bench: NewBench, record_property: Record, pytestconfig: pytest.Config
) -> None:
    """A lost link is told within 2 s, is back within 5 s, and leaves no stale value."""
    record_property("driver", driver)
    record_property("case", "link_faults_are_found_and_pass")
    require_found(new_bench, pytestconfig.getoption("link_faults"))
