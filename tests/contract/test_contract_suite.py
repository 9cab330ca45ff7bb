"""Every shipped driver keeps every case of the contract that ships with the drivers' package."""

import pytest

from tests.contract.benches import WITHOUT_A_DEVICE, registry
from tests.contract.devices.every import BENCHES
from truepose_drivers.contract import codec_fuzz, hostile
from truepose_drivers.contract.case import reason_absent, unknown_absences
from truepose_drivers.contract.case import run as require_kept
from truepose_drivers.contract.cases import CASES
from truepose_drivers.contract.link_recovery import require_found

NAMES = [bench.plugin.name for bench in BENCHES]
ASKED = [(bench, case) for bench in BENCHES for case in CASES if reason_absent(case, bench()) is None]
IDS = [f"{bench.plugin.name}-{case.name}" for bench, case in ASKED]
every_driver = pytest.mark.parametrize("bench", BENCHES, ids=NAMES)


def test_every_registered_driver_has_a_bench():
    assert set(registry().names()) == {*NAMES, *WITHOUT_A_DEVICE}
    assert registry().broken == {}


@pytest.mark.parametrize(("bench", "case"), ASKED, ids=IDS)
def test_a_driver_keeps_the_contract(bench, case):
    require_kept(case, bench)


@every_driver
def test_a_bench_leaves_out_cases_that_there_are(bench):
    assert unknown_absences(bench(), CASES) == []


@every_driver
def test_hostile_bytes_do_no_harm(bench):
    codec_fuzz.require_unharmed(bench, 200, seed=7)


@every_driver
def test_hostile_answers_do_no_harm(bench):
    hostile.require_unharmed(bench, 80, seed=7)


@every_driver
def test_faults_of_a_link_are_found_and_pass(bench):
    require_found(bench, 30, seed=7)
