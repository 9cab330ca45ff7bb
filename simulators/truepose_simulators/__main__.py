"""`python -m truepose_simulators [SCENARIO]`: starts a simulated cell and announces its endpoints."""

import argparse
import asyncio
import signal
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TypeAlias

from truepose_simulators.cell.environment import CellClock, Pace
from truepose_simulators.cell.journal import RememberedCell
from truepose_simulators.errors import EndpointUnavailableError, ModelError, SimulatorError
from truepose_simulators.faults.file import read_faults
from truepose_simulators.faults.times import Fault
from truepose_simulators.instruments.cable import FaultyCable
from truepose_simulators.instruments.cell_endpoints import clock_endpoint, faults_endpoint, hands_endpoint
from truepose_simulators.instruments.endpoint import Endpoint
from truepose_simulators.instruments.gauges.ballbar_hid import HidBallbarGadget
from truepose_simulators.instruments.gauges.length_source import Electronics
from truepose_simulators.instruments.gauges.nd28x import nd28x_endpoint
from truepose_simulators.instruments.gauges.text_boxes import keyence_gt2_endpoint
from truepose_simulators.instruments.gauges.usb_itn import UsbItnGadget
from truepose_simulators.instruments.gauges.usbip import usbip_endpoint
from truepose_simulators.instruments.leica_emscon.server import tracker_endpoint
from truepose_simulators.instruments.ndi_polaris import camera_endpoint
from truepose_simulators.instruments.robot.abb_rws.controller import AbbController, program_of
from truepose_simulators.instruments.robot.abb_rws.egm_stream import EgmStream
from truepose_simulators.instruments.robot.abb_rws.server import web_endpoint
from truepose_simulators.instruments.robot.fanuc_rmi.controller import Controller as FanucController
from truepose_simulators.instruments.robot.fanuc_rmi.endpoints import connect_endpoint, session_endpoint
from truepose_simulators.instruments.robot.fanuc_rmi.program import RmiMove
from truepose_simulators.instruments.robot.kuka import Variables, proxy_endpoint
from truepose_simulators.instruments.robot.mappdk import (
    MappdkProgram,
    mappdk_endpoint,
    mappdk_logger_endpoint,
)
from truepose_simulators.instruments.robot.open_abb import MotionProgram, logger_endpoint, robot_endpoint
from truepose_simulators.instruments.robot.universal_robots import Controller, Programs
from truepose_simulators.instruments.robot.universal_robots_ports import (
    dashboard_endpoint,
    rtde_endpoint,
    script_endpoint,
)
from truepose_simulators.instruments.truth_endpoint import truth_endpoint
from truepose_simulators.physics.identified import IdentifiedModel
from truepose_simulators.scenarios.file import load_scenario, shipped_scenarios
from truepose_simulators.scenarios.model_file import load_model

Instrument: TypeAlias = Endpoint | EgmStream  # where a client finds an instrument, or is found by it

# Ctrl-C; a service manager; on Windows alone Ctrl-Break, which a closed window is told by as well.
_ASKING = ("SIGINT", "SIGTERM", "SIGBREAK")


def end_event() -> asyncio.Event:
    """Return what is set when somebody asks this process to end, which is the last that its loop does."""
    loop, asked = asyncio.get_running_loop(), asyncio.Event()
    for number in (getattr(signal, name) for name in _ASKING if hasattr(signal, name)):
        try:
            loop.add_signal_handler(number, asked.set)
        except NotImplementedError:  # Windows: there the signal itself wakes the loop
            signal.signal(number, lambda *_: loop.call_soon_threadsafe(asked.set))
    return asked


_EXIT_UNUSABLE_INPUT = 2
_EXIT_DEVICE_FAILED = 3
_JOINTS_ON_THE_WIRE = 6  # of every message of open_abb and MAPPDK


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a cell until interrupted; returns the exit status."""
    options = _parse(arguments)
    try:
        scenario = load_scenario(options.scenario)
        model = None if options.model is None else _drivable(load_model(options.model))
        cell = RememberedCell(scenario, options.seed, CellClock(0), model)
        for fault in _faults(options.faults, cell):
            cell.add_fault(fault)
        asyncio.run(_run(cell, options))
    except EndpointUnavailableError as error:
        return _fail(error, _EXIT_DEVICE_FAILED)
    except SimulatorError as error:
        return _fail(error, _EXIT_UNUSABLE_INPUT)
    except KeyboardInterrupt:  # before the signal handlers were in place
        return 0
    return 0


def _parse(arguments: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="python -m truepose_simulators",
        description="Start a simulated cell: tracker (emScon), robot (open_abb or another maker's), clock.",
        epilog="example: python -m truepose_simulators irb120-clean --seed 3 --port-base 7000 --pace 0",
    )
    parser.add_argument(
        "scenario",
        nargs="?",
        default="irb120-tilted",
        help=f"a scenario file or one of {', '.join(shipped_scenarios())} (default: %(default)s)",
    )
    parser.add_argument(
        "--seed", type=_natural, default=0, help="random seed: which cell of that kind (default: 0)"
    )
    parser.add_argument(
        "--port-base", type=_natural, default=0, help="first of the consecutive ports; 0: any free ports"
    )
    parser.add_argument(
        "--pace", type=int, choices=(0, 1), default=1, help="1: real time (default); 0: as fast as possible"
    )
    parser.add_argument(
        "--model",
        type=Path,
        help="identified model (JSON): its robot, base and tool replace those of the scenario",
    )
    parser.add_argument(
        "--faults", type=Path, help="file of [[fault]] tables: which faults occur, and when (docs/faults.md)"
    )
    parser.add_argument(
        "--state",
        type=Path,
        help="file that keeps the state of the cell; a cell restarted with it continues from that state",
    )
    parser.add_argument("--host", default="127.0.0.1", help="address to listen on (default: %(default)s)")
    return parser.parse_args(arguments)


def _natural(text: str) -> int:
    number = int(text)
    if number < 0:
        raise argparse.ArgumentTypeError(f"{text} is negative")
    return number


def _drivable(model: IdentifiedModel) -> IdentifiedModel:
    """Return a model that can be moved over the wire; raises ModelError."""
    n_joints, instead = len(model.table.rows), "replay a campaign with truepose_simulators.recording instead"
    if n_joints != _JOINTS_ON_THE_WIRE:
        raise ModelError(
            f"{model.table.name} has {n_joints} joints, but open_abb moves {_JOINTS_ON_THE_WIRE}; {instead}"
        )
    if model.sensed_torques and not model.table.masses:
        raise ModelError(
            f"the compliance of {model.table.name} was identified from torque sensors and the model states no"
            f" masses, so nothing would load the joints here; {instead}"
        )
    return model


async def _run(cell: RememberedCell, options: argparse.Namespace) -> None:
    if options.state is not None:
        await cell.remember(options.state)
    pace: Pace = 1 if options.pace == 1 else 0
    cell.clock.go_at(pace)
    interrupted = end_event()
    endpoints, first = _endpoints(cell), options.port_base
    try:
        for offset, endpoint in enumerate(endpoints):
            endpoint.cable = FaultyCable(endpoint.device, cell.faults, cell.clock)
            address = await endpoint.open(options.host, first + offset if first else 0)
            sys.stdout.write(address.as_json() + "\n")
        sys.stdout.flush()
        await interrupted.wait()
    finally:
        for endpoint in endpoints:
            await endpoint.close()


def _endpoints(cell: RememberedCell) -> list[Instrument]:
    camera = cell.scenario.camera
    controller, newer = _controller(cell)
    bar = Electronics(cell.ballbar, cell.faults, cell.clock)
    return [
        tracker_endpoint(cell),
        *controller,
        clock_endpoint(cell.clock),
        truth_endpoint(cell),
        # Newer endpoints come last, so that the older ones keep their ports.
        nd28x_endpoint(bar),
        usbip_endpoint("hid", HidBallbarGadget(bar)),
        usbip_endpoint("usb_itn", UsbItnGadget(bar)),
        hands_endpoint(cell),
        *([] if camera is None else [camera_endpoint(cell, camera)]),
        *_gauges(cell),
        faults_endpoint(cell),
        *newer,
    ]


def _gauges(cell: RememberedCell) -> list[Instrument]:
    """Return an endpoint for each gauge of a closed loop: a box of its own."""
    boxes = [Electronics(gauge, cell.faults, cell.clock) for gauge in cell.loop]
    return [keyence_gt2_endpoint([box], f"gauge-{number}") for number, box in enumerate(boxes, start=1)]


def _faults(path: Path | None, cell: RememberedCell) -> tuple[Fault, ...]:
    return () if path is None else read_faults(path, cell.scenario.check_fault)


def _controller(cell: RememberedCell) -> tuple[list[Instrument], list[Instrument]]:
    """Return the ports of the robot's controller, in the language of the scenario, and its newer ones."""
    if cell.scenario.arm.protocol == "ur_rtde":
        universal = Controller(cell)
        programs = Programs(universal)
        texts = [script_endpoint(programs), dashboard_endpoint(universal, programs)]
        return [rtde_endpoint(universal), *texts], []
    if cell.scenario.arm.protocol == "mappdk":
        outputs: dict[str, str] = {}
        motion, logger = (MappdkProgram(cell, outputs=outputs) for _ in range(2))
        return [mappdk_endpoint(cell, motion), mappdk_logger_endpoint(cell, logger)], []
    if cell.scenario.arm.protocol == "rmi":
        fanuc = FanucController(cell)
        session = session_endpoint(fanuc, RmiMove(fanuc))
        return [connect_endpoint(session), session], []
    if cell.scenario.arm.protocol == "kuka_variable_proxy":
        return [proxy_endpoint(cell, Variables(cell))], []
    return _abb(cell)


def _abb(cell: RememberedCell) -> tuple[list[Instrument], list[Instrument]]:
    abb = AbbController(cell)
    port = cell.scenario.arm.egm_port
    stream: list[Instrument] = [] if port is None else [EgmStream(abb, port)]
    if cell.scenario.arm.protocol == "rws":
        abb.task = program_of(abb)
        return [web_endpoint(cell, abb), *stream], []
    server = MotionProgram(cell, abb)
    return [robot_endpoint(cell, server), logger_endpoint(cell, server), *stream], [
        web_endpoint(cell, abb, "robot-rws")
    ]


def _fail(error: SimulatorError, status: int) -> int:
    sys.stderr.write(f"{error}\n")
    return status


if __name__ == "__main__":
    sys.exit(main())
