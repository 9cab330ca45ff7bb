"""The contract suite fails a driver that breaks the contract, and says what its author does."""

import sys
from dataclasses import replace
from pathlib import Path
from typing import ClassVar

import pytest

from truepose_drivers.api import BallbarReading, DeviceIdentity, DriverPlugin
from truepose_drivers.contract import codec_fuzz, hostile, link_recovery
from truepose_drivers.contract.bench import BallbarBench, find_benches, messages
from truepose_drivers.contract.case import ContractBrokenError, reason_absent, run, unknown_absences
from truepose_drivers.contract.cases import CASES
from truepose_drivers.contract.suite import Row, table
from truepose_drivers.errors import ConfigurationError, RemoteProtocolError
from truepose_drivers.framing import LineReader

NAMED = {case.name: case for case in CASES}
CARELESS = DriverPlugin("careless", "ballbar", "lines", {}, lambda options, clock: CarelessGauge(None, clock))


class CarelessGauge:
    """Does what a first draft does: asks, takes what comes, waits for ever, keeps its link open."""

    def __init__(self, link, clock):
        self._link, self._clock = link, clock

    @property
    def connected(self):
        return self._link.is_open

    async def connect(self):
        await self._link.open()

    async def close(self):
        await self._link.close()

    async def identify(self):
        return DeviceIdentity("ACME", "careless", "1001", "")

    async def read(self):
        await self._link.send(b"?\n")
        answer = await self._link.receive(60.0) or b"0"
        return BallbarReading(float(answer), "good", 1e-4, await self._clock.now_s())


class CarelessBench(BallbarBench):
    plugin = CARELESS
    absent: ClassVar = {"a_frozen_device_gives_no_reading": "no count"}

    def driver(self, wiring):
        return CarelessGauge(wiring.line(lambda _: [f"{self.true_mm:.4f}\n".encode()]), wiring.clock)


class BlindBench(CarelessBench):
    def is_right(self, value):
        return True


@pytest.mark.parametrize(
    ("name", "says"),
    [
        ("answers_in_single_bytes_are_right", "returned"),
        ("garbage_closes_the_link", "ValueError"),
        ("stale_answers_are_no_reading", "returned"),
        ("silence_is_told_within_two_seconds", "where nothing could be read"),
        ("connect_asks_who_is_there", "connect returned"),
        ("connect_refuses_another_protocol", "another server"),
        ("it_says_who_it_is", "identify returned"),
        ("another_serial_number_is_told", "2002"),
        ("another_unit_changes_no_reading", "no special of the kind 'unit'"),
    ],
)
def test_a_careless_driver_is_told_what_it_breaks(name, says):
    with pytest.raises(ContractBrokenError, match=says) as raised:
        run(NAMED[name], CarelessBench)

    assert NAMED[name].remedy in str(raised.value)


@pytest.mark.parametrize("name", ["whole_answers_are_right", "nothing_is_opened_before_connect"])
def test_what_a_careless_driver_does_right_is_no_failure(name):
    assert run(NAMED[name], CarelessBench) == "kept"


class BoxBench(CarelessBench):
    plugin = replace(CARELESS, kind="linear_gauge", also=("robot",))

    def driver(self, wiring):
        return self.box(None, None)


class WaitlessBox(CarelessGauge):
    def read_channels(self):
        return ()


class BoastingRobot(CarelessGauge):
    motion_guard = 1.0


@pytest.mark.parametrize(("box", "lost"), [(WaitlessBox, "read_channels"), (BoastingRobot, "motion_guard")])
def test_an_ability_that_its_guard_would_lose_is_told(box, lost, monkeypatch):
    monkeypatch.setattr(BoxBench, "box", box, raising=False)

    with pytest.raises(ContractBrokenError, match=f"{lost} does not come through the guard"):
        run(NAMED["its_abilities_reach_the_service"], BoxBench)


def test_a_bench_that_takes_everything_for_right_is_told():
    with pytest.raises(ContractBrokenError, match="wherever it moves"):
        run(NAMED["the_bench_knows_a_wrong_value"], BlindBench)


def test_a_case_that_is_declared_absent_is_not_asked():
    case = NAMED["a_frozen_device_gives_no_reading"]

    assert reason_absent(case, CarelessBench()) == "no count"
    assert run(case, CarelessBench) == "absent"


def test_a_case_of_robots_is_not_asked_of_a_gauge():
    assert reason_absent(NAMED["a_target_that_is_none_moves_nothing"], CarelessBench())


def test_hostile_inputs_and_link_faults_find_a_careless_driver():
    with pytest.raises(ContractBrokenError, match="harmed"):
        hostile.require_unharmed(CarelessBench, 50)
    with pytest.raises(ContractBrokenError, match="stale"):
        link_recovery.require_found(CarelessBench, 20)


def test_bytes_that_a_codec_stumbles_over_are_told():
    class Stumbling(CarelessBench):
        def decoded(self, data):
            return [float(data)]

    with pytest.raises(ContractBrokenError, match="could not convert"):
        codec_fuzz.require_unharmed(Stumbling, 20)


def test_a_codec_that_refuses_or_waits_is_unharmed():
    class Wary(CarelessBench):
        def decoded(self, data):
            return messages(LineReader(), data, _number)

    found = codec_fuzz.tally(Wary, 100)

    assert (found.inputs, found.foreign) == (100, 0)
    assert found.read + found.refused + found.waiting == 100
    assert min(found.read, found.refused, found.waiting) > 5
    assert codec_fuzz.has_codec(Wary())
    assert not codec_fuzz.has_codec(CarelessBench())


def _number(line):
    try:
        return float(line)
    except ValueError as error:
        raise RemoteProtocolError(str(error)) from error


def test_an_absence_that_is_misspelt_or_has_no_reason_is_told():
    class Misspelt(CarelessBench):
        absent: ClassVar = {"whole_answer": "a reason", "it_says_who_it_is": " "}

    assert unknown_absences(Misspelt(), CASES) == ["whole_answer", "it_says_who_it_is"]
    assert unknown_absences(CarelessBench(), CASES) == []


def test_every_case_asks_one_sentence_and_says_what_to_do():
    assert all(case.asks.endswith(".") and case.asks.count(". ") == 0 and case.remedy for case in CASES)


@pytest.mark.parametrize("place", ["nowhere:BENCH", "math:NOTHING", "math:pi"])
def test_a_bench_that_cannot_be_found_is_told(place):
    with pytest.raises(ConfigurationError, match=r"MODULE:NAME|subclass"):
        find_benches([place], None)


class GaugeBench(CarelessBench):
    plugin = replace(CARELESS, kind="linear_gauge")


class OwnBench(CarelessBench):
    pass


TWO = [CarelessBench, GaugeBench]


def test_a_driver_of_two_kinds_has_two_benches_each_under_its_own_name():
    found = find_benches([f"{__name__}:TWO"], ["careless"])

    assert found == {"careless_ballbar": CarelessBench, "careless_linear_gauge": GaugeBench}


def test_the_bench_that_is_named_last_goes_before_another_of_its_kind():
    assert find_benches([f"{__name__}:CarelessBench", f"{__name__}:OwnBench"], None) == {"careless": OwnBench}


def test_a_driver_without_a_bench_is_told():
    with pytest.raises(ConfigurationError, match="no bench for mine"):
        find_benches([], ["mine"])


def test_the_table_has_a_line_a_case_and_a_column_a_driver():
    rows = [Row("a", "one", "yes"), Row("b", "one", "NO"), Row("a", "two", "-", "cannot be")]

    lines = table(rows)

    assert "one yes  NO" in lines
    assert "a: cannot be (two)" in lines
    assert table([]) == []


def test_nothing_of_the_product_imports_pytest():
    packages = Path(sys.modules["truepose_drivers"].__file__).parents[2]
    sources = [
        path
        for package in ("service", "drivers", "simulators")
        for path in (packages / package).rglob("*.py")
        if "import pytest" in path.read_text(encoding="utf-8")
    ]

    assert {path.name for path in sources} == {"suite.py", "plugin.py", "test_contract.py"}
