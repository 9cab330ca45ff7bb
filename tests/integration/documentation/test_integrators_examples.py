"""The worked examples of docs/integrator.md do what the page says."""

import math
import sys
import tomllib
from dataclasses import replace
from importlib.metadata import EntryPoint
from pathlib import Path

import numpy as np
import pytest

from tests.helpers.diagnosis.point_scenes import telling_scene
from tests.helpers.instruments.memory_link import MemoryLink
from truepose.domain.campaign import Campaign, PointReadings, Stops
from truepose.effects.causes import FittedCause
from truepose.effects.registry import EFFECTS
from truepose.exchange.cells.file import read_cell
from truepose.exchange.robots.named import load_robot_with_tool, read_robot_file
from truepose.identification import identify
from truepose.identification.model.derivatives import position_jacobian
from truepose.identification.model.evaluation import Targets, evaluate
from truepose.identification.problem.build import build
from truepose.kinematics.chain import nominal_chain
from truepose_drivers.api import Environment
from truepose_drivers.contract.case import run as require_kept
from truepose_drivers.contract.cases import CASES
from truepose_drivers.contract.hostile import require_unharmed
from truepose_drivers.contract.link_recovery import require_found
from truepose_drivers.errors import (
    BeamBrokenError,
    ConfigurationError,
    DeviceRefusedError,
    NotInitialisedError,
    ReflectorNotFoundError,
    RemoteProtocolError,
)
from truepose_drivers.monotonic_clock import MonotonicClock
from truepose_drivers.registry import ENTRY_POINT_GROUP, load_registry

_EXAMPLES = Path(__file__).parents[3] / "docs" / "examples"


@pytest.fixture
def acme(monkeypatch):
    """The driver package of the example, importable as if it were installed."""
    monkeypatch.syspath_prepend(str(_EXAMPLES / "acme_tracker"))
    yield
    for name in [name for name in sys.modules if name.split(".")[0] == "acme_tracker"]:
        del sys.modules[name]


class AcmeInstrument:
    """Answers as the ACME tracker would; `replies` overrides single words."""

    def __init__(self, **replies):
        self.asked = []
        self._replies = {
            "WHO": "ACME T1 42 1.0",
            "MODE_MM": "OK",
            "AIM": "LOCKED",
            "MEASURE": "POINT 1 mm 2 1.0000 -2.5000 3.0001 0.0100 0.0100 0.0200 0.0300",
            "FLIP": "OK",
            "AIR": "AIR 20.5000 1013.2000 45.0000",
            **replies,
        }

    async def serve(self, end):
        buffer = b""
        while data := await end.receive():
            buffer += data
            while b"\n" in buffer:
                line, _, buffer = buffer.partition(b"\n")
                self.asked.append(line.decode())
                reply = self._replies[line.split()[0].decode()]
                if reply is not None:
                    await end.send(f"{reply}\n".encode())


async def _connected(instrument, chunk_bytes=65_536):
    from acme_tracker.driver import AcmeTracker

    tracker = AcmeTracker(MemoryLink(instrument.serve, chunk_bytes=chunk_bytes), MonotonicClock())
    await tracker.connect()
    return tracker


def test_the_example_driver_is_found_by_the_entry_point_of_its_package(acme):
    project = tomllib.loads((_EXAMPLES / "acme_tracker" / "pyproject.toml").read_text(encoding="utf-8"))
    entries = project["project"]["entry-points"][ENTRY_POINT_GROUP]

    registry = load_registry([EntryPoint(name, value, ENTRY_POINT_GROUP) for name, value in entries.items()])

    assert registry.names("tracker") == ("acme_tracker",)
    assert registry.broken == {}
    assert not registry.open("acme_tracker", {"host": "127.0.0.1"}).connected
    with pytest.raises(ConfigurationError, match="host"):
        registry.open("acme_tracker", {"port": 9000})


@pytest.mark.parametrize("chunk_bytes", [1, 5, 4096])  # an answer is up to 40 bytes
async def test_the_example_driver_measures_a_point_in_whatever_pieces_it_arrives(acme, chunk_bytes):
    instrument = AcmeInstrument()
    tracker = await _connected(instrument, chunk_bytes)

    await tracker.initialise()
    await tracker.find_reflector((1.0, -2.5, 3.0), search_radius_mm=10.0)
    await tracker.change_face()
    reading = await tracker.measure_point(duration_s=0.5)
    await tracker.close()

    assert reading.point_mm == (1.0, -2.5, 3.0001)
    assert (reading.face, reading.rms_mm) == (2, 0.03)
    assert instrument.asked[2] == "AIM 1.0000 -2.5000 3.0000 10.0000"


@pytest.mark.parametrize(
    ("word", "reply", "error"),
    [
        ("AIM", "EMPTY", ReflectorNotFoundError),
        ("MEASURE", "BEAM", BeamBrokenError),
        ("MEASURE", "REFUSED warming up", DeviceRefusedError),
        ("MEASURE", "POINT 1 mm 1 1.0000 2.0000 nan 0.0000 0.0000 0.0000 0.0000", RemoteProtocolError),
        ("MEASURE", "POINT 1 mm 1 1.0000 2.0000", RemoteProtocolError),
        ("MEASURE", "POINT 1 mm 3 1.0000 2.0000 3.0000 0.0000 0.0000 0.0000 0.0000", RemoteProtocolError),
        ("MEASURE", "POINT x mm 1 1.0000 2.0000 3.0000 0.0000 0.0000 0.0000 0.0000", RemoteProtocolError),
        ("MEASURE", "POINT 1 in 1 1.0000 2.0000 3.0000 0.0000 0.0000 0.0000 0.0000", NotInitialisedError),
        ("MEASURE", "x" * 2000, RemoteProtocolError),
    ],
)
async def test_the_example_driver_names_what_went_wrong(acme, word, reply, error):
    tracker = await _connected(AcmeInstrument(**{word: reply}))

    with pytest.raises(error):
        await tracker.find_reflector((0.0, 0.0, 0.0), search_radius_mm=10.0)
        await tracker.measure_point(duration_s=0.1)

    await tracker.close()


async def test_the_example_driver_reads_the_air(acme):
    tracker = await _connected(AcmeInstrument())

    assert await tracker.environment() == Environment(20.5, 1013.2, 45.0)


@pytest.mark.parametrize("case", CASES, ids=[case.name for case in CASES])
def test_the_example_driver_keeps_the_contract(acme, case):
    from acme_tracker.bench import AcmeTrackerBench

    require_kept(case, AcmeTrackerBench)


def test_the_example_driver_withstands_hostile_answers_and_faults_of_its_link(acme):
    from acme_tracker.bench import AcmeTrackerBench

    require_unharmed(AcmeTrackerBench, 200)
    require_found(AcmeTrackerBench, 50)


def test_the_example_cell_brings_its_own_robot():
    cell = read_cell(_EXAMPLES / "own_robot" / "cell.toml")

    assert cell.robot.name == "ACME A6"
    assert [device.driver for device in cell.devices] == ["acme_tracker", "abb_open_abb"]
    assert cell.robot.masses[-1].mass_kg == 1.2


def test_the_example_robot_stands_where_its_drawing_says():
    robot = read_robot_file(_EXAMPLES / "own_robot" / "acme-a6.toml").robot

    chain = nominal_chain(robot, np.zeros((1, 6)))

    # Upper arm upright: forward 25 + 420 + 80, upward 400 + 450 + 35; sums of the table to rounding.
    assert chain.origin[-1][0] == pytest.approx((525.0, 0.0, 885.0), abs=1e-9)


@pytest.fixture
def with_friction(monkeypatch):
    """The example effect registered, as its line in the registry would do it."""
    monkeypatch.syspath_prepend(str(_EXAMPLES / "acme_causes"))
    from friction_windup import FrictionWindup

    monkeypatch.setitem(EFFECTS, "friction_windup", FrictionWindup())
    yield ("base", "geometry", "friction_windup")
    del sys.modules["friction_windup"]


def _campaign(n=40):
    """A nominal robot with known nests at random configurations, approached from either side."""
    shipped = load_robot_with_tool("abb-irb-120")
    rng = np.random.default_rng(0)
    joints, direction = rng.uniform(-1.2, 1.2, (n, 6)), rng.choice([-1, 1], (n, 6))
    stops = Stops(np.arange(1, n + 1), joints, direction)
    nest = rng.integers(1, 4, n)
    centres = np.array([nest.centre_mm for nest in shipped.nests])
    places = nominal_chain(shipped.robot, stops.joints_rad).points(centres[nest - 1])
    readings = PointReadings(stops, nest, places, np.full(n, 0.01))
    return Campaign(shipped.robot, base_nominal=None, nests=shipped.nests, calibration=readings)


def test_the_example_effect_has_the_derivative_that_it_claims(with_friction):
    campaign = _campaign()
    problem = build(campaign, with_friction)
    targets = Targets(campaign.calibration.stops, campaign.calibration.nest)
    k = problem.structure.index_of("friction_3")
    step = np.zeros_like(problem.start)
    step[k] = 1e-9

    up, down = (evaluate(problem.structure, problem.start + s, targets).position_mm for s in (step, -step))
    claimed = position_jacobian(evaluate(problem.structure, problem.start, targets))[k]

    # At most 20 N m turn the joint by 2e-5 rad at either end. That the torque follows this turn, by 2e-5 of
    # itself, is left out of derivatives; curvature and rounding are far below that.
    assert (up - down) / 2e-9 == pytest.approx(claimed, abs=1e-4 * np.abs(claimed).max())


def test_the_example_is_a_cause_that_a_diagnosis_can_look_for(with_friction):
    """Its candidates, what hides it, and its words; the scene is that of a fit without it."""
    scene = telling_scene()
    cause = EFFECTS["friction_windup"]
    one_sided = replace(scene.stops, direction=np.ones_like(scene.stops.direction))

    candidates = cause.candidates(scene)
    shown = cause.describe(
        "joint 3", FittedCause(("friction_3",), np.array([1e-8]), np.array([[1e-18]])), scene
    )

    assert [c.subject for c in candidates] == ["joint 2", "joint 3", "joint 4", "joint 5", "joint 6"]
    assert "from the other" in cause.unseen(replace(scene, stops=one_sided))
    assert (shown.amplitude, shown.unit) == (1e-8, "rad/(N*mm)")
    assert not any("friction_3" in c.names for c in cause.candidates(replace(scene, present={"friction_3"})))


def test_the_example_effect_is_identified_from_readings_that_contain_it(with_friction):
    campaign = _campaign()
    problem = build(campaign, with_friction)
    truth = problem.start.copy()
    truth[problem.structure.index_of("friction_3")] = 1e-8
    targets = Targets(campaign.calibration.stops, campaign.calibration.nest)
    noise = np.random.default_rng(1).normal(0.0, 0.01, (len(targets), 3))
    positions = evaluate(problem.structure, truth, targets).position_mm + noise
    readings = PointReadings(
        targets.stops, targets.nest, positions, campaign.calibration.standard_uncertainty_mm
    )

    answer = identify(
        Campaign(campaign.robot, base_nominal=None, nests=campaign.nests, calibration=readings),
        with_friction,
    )

    found = next(p for p in answer.parameters if p.name == "friction_3")
    # Within four of its own standard uncertainties, and these well below what is looked for: 0.01 mm seen 40
    # times at 0.4 m under some 7 N m is 6e-10; what must be told from it costs a factor of two.
    assert found.value == pytest.approx(1e-8, abs=4.0 * found.standard_uncertainty)
    assert 0.0 < found.standard_uncertainty < 2e-9
    assert math.isfinite(answer.chi2_per_dof)
