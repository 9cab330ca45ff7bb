"""`python -m truepose_simulators` as whoever starts it sees it."""

import json
import os
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from tests.helpers.ports import free_block

# Starting costs an interpreter and numpy; a busy machine may take ten times as long as a quiet one.
START_S = 10.0
# 1,200 configurations in well under 25 s, their approach moves and drivers included.
BUDGET_PER_CONFIGURATION_S = 25.0 / 1200


# Scripts count on the order: a newer endpoint comes behind the older ones and takes no port of theirs.
ANNOUNCED = [
    ("tracker", "emscon"),
    ("robot", "open_abb"),
    ("robot-log", "open_abb_log"),
    ("clock", "clock"),
    ("truth", "truth"),
    ("ballbar", "nd28x"),
    ("ballbar", "hid"),
    ("ballbar", "usb_itn"),
    ("hands", "hands"),
    ("faults", "faults"),
    ("robot-rws", "rws"),
]


class Simulators:
    """One started cell."""

    def __init__(self, *arguments):
        self.process = subprocess.Popen(
            [sys.executable, "-m", "truepose_simulators", *arguments],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        self.announced = [json.loads(self.process.stdout.readline()) for _ in ANNOUNCED]

    def connect(self, device):
        return self.connect_to(next(entry for entry in self.announced if entry["device"] == device))

    def connect_to(self, entry):
        connection = socket.create_connection((entry["host"], entry["port"]), timeout=START_S)
        connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        return connection

    def stop(self, number=signal.SIGTERM):
        self.process.send_signal(number)
        out, err = self.process.communicate(timeout=START_S)
        return self.process.returncode, out, err


@pytest.fixture
def start():
    started = []

    def begin(*arguments):
        started.append(Simulators(*arguments))
        return started[-1]

    yield begin
    for cell in started:
        if cell.process.poll() is None:
            cell.process.kill()
        cell.process.communicate()


def run(*arguments):
    return subprocess.run(
        [sys.executable, "-m", "truepose_simulators", *arguments],
        capture_output=True,
        text=True,
        timeout=START_S,
        check=False,
    )


def ask_truth(connection, **request):
    connection.sendall(json.dumps(request).encode() + b"\n")
    with connection.makefile("rb") as stream:
        return json.loads(stream.readline())


def test_every_endpoint_is_announced_on_a_line_of_its_own(start):
    cell = start("--pace", "0")

    assert [(entry["device"], entry["protocol"]) for entry in cell.announced] == ANNOUNCED
    assert {entry["host"] for entry in cell.announced} == {"127.0.0.1"}
    for entry in cell.announced:
        cell.connect_to(entry).close()


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupted_cell_ends_cleanly_even_with_clients(start, number):
    cell = start("irb120-clean", "--pace", "1")
    clients = [cell.connect_to(entry) for entry in cell.announced]

    status, out, err = cell.stop(number)

    assert (status, out, err) == (0, "", "")
    for client in clients:
        client.close()


def test_ports_follow_each_other_from_the_port_base(start):
    base = free_block(len(ANNOUNCED))

    cell = start("--pace", "0", "--port-base", str(base))

    assert [entry["port"] for entry in cell.announced] == [base + offset for offset in range(len(ANNOUNCED))]


def test_a_port_in_use_is_one_sentence_and_status_3():
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]

        result = run("--port-base", str(port))

    assert result.returncode == 3
    assert result.stderr.count("\n") == 1
    assert f"127.0.0.1:{port}" in result.stderr
    assert "choose another port" in result.stderr


@pytest.mark.parametrize("port_base", ["65534", "70000"])
def test_ports_beyond_the_last_are_one_sentence_and_status_3(port_base):
    result = run("--port-base", port_base)

    assert result.returncode == 3
    assert result.stderr.count("\n") == 1


def test_an_unknown_scenario_is_one_sentence_and_status_2():
    result = run("irb6600")

    assert result.returncode == 2
    assert result.stderr.count("\n") == 1
    assert "irb120-tilted" in result.stderr


def test_a_file_of_faults_with_a_mistake_is_one_sentence_with_its_line_and_status_2(tmp_path):
    file = tmp_path / "morning.toml"
    file.write_text('[[fault]]\nkind = "smr_missing"\nnest = 9\n')

    done = run("irb120-clean", "--faults", str(file))

    assert done.returncode == 2
    assert done.stderr == f'{file}, line 3: key "nest" must be 1 to 3, not 9\n'
    assert done.stdout == ""


def test_the_same_seed_gives_the_same_cell_and_another_another(start):
    plants = []
    for seed in ("5", "5", "6"):
        with start("lrmate-tilted", "--seed", seed, "--pace", "0").connect("truth") as truth:
            plants.append(ask_truth(truth, op="plant"))

    assert plants[0] == plants[1]
    assert plants[0]["links"] != plants[2]["links"]
    assert plants[0]["robot"] == "lrmate200ic"


def test_the_truth_of_a_thousand_configurations_fits_one_line(start):
    joints = np.random.default_rng(1).uniform(-1, 1, (1000, 6))

    with start("--pace", "0").connect("truth") as truth:
        reply = ask_truth(truth, op="positions", joints_rad=joints.tolist(), nests=[2] * 1000)

    assert np.array(reply["positions_mm"]).shape == (1000, 3)


def test_a_wait_of_an_hour_costs_no_wall_time_at_pace_0(start):
    cell = start("--pace", "0")
    with cell.connect("clock") as clock:  # which waits for no answer as long as an hour
        clock.sendall(b'{"op": "sleep", "s": 3600}\n{"op": "now"}\n')
        with clock.makefile("rb") as stream:
            replies = [json.loads(stream.readline()) for _ in range(2)]

    assert replies == [{"now_s": 3600.0}, {"now_s": 3600.0}]


def test_real_time_passes_at_pace_1(start):
    cell = start()
    with cell.connect("clock") as clock, clock.makefile("rb") as stream:
        begun_s = time.monotonic()

        clock.sendall(b'{"op": "now"}\n{"op": "sleep", "s": 0.3}\n')
        before, after = (json.loads(stream.readline())["now_s"] for _ in range(2))

    assert time.monotonic() - begun_s >= 0.29
    assert after - before >= 0.29


def test_a_robot_moves_and_all_devices_see_it_in_one_time(start):
    cell = start("--pace", "0")
    with cell.connect("robot") as robot, cell.connect("clock") as clock, clock.makefile("rb") as stream:
        robot.sendall(b"8 1000 90 #")
        assert robot.recv(100) == b"8 1 "
        robot.sendall(b"2 90 0 0 0 0 0 #")
        assert robot.recv(100) == b"2 1 "

        clock.sendall(b'{"op": "now"}\n')

        # 90 deg at 90 deg/s: one second of cell time.
        assert json.loads(stream.readline())["now_s"] == pytest.approx(1.0, rel=1e-9)


def cpu_s(pid):
    """Seconds of processor that a process has had: a busy machine does not make them more."""
    user, system = Path(f"/proc/{pid}/stat").read_text(encoding="utf-8").rpartition(")")[2].split()[11:13]
    return (int(user) + int(system)) / os.sysconf("SC_CLK_TCK")


@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="a process is asked of in /proc")
def test_a_visit_of_a_configuration_costs_a_small_part_of_its_budget(start):
    cell = start("--pace", "0")
    rng = np.random.default_rng(1)
    targets = rng.uniform([-90, 0, -80, -150, -90, -180], [90, 90, 50, 150, 90, 180], (50, 6))
    with cell.connect("robot") as robot:
        begun_s = cpu_s(cell.process.pid)
        for target in targets:
            for stop in (target - 5.0, target):
                robot.sendall(f"2 {' '.join(f'{angle:.5f}' for angle in stop)} #".encode())
                assert robot.recv(100) == b"2 1 "
        per_visit_s = (cpu_s(cell.process.pid) - begun_s) / len(targets)

    assert per_visit_s < BUDGET_PER_CONFIGURATION_S


def test_a_cell_that_was_killed_stands_where_it_stood(start, tmp_path):
    arguments = ("lrmate-clean", "--seed", "4", "--pace", "1", "--state", str(tmp_path / "cell.json"))
    cell = start(*arguments)
    with cell.connect("hands") as hands:
        for deed in ({"action": "place_base", "placement": 1}, {"action": "calibrator", "bars": "base"}):
            assert ask_truth(hands, op="do", **deed) == {"ok": True}
    with cell.connect("clock") as clock:
        before_s = ask_truth(clock, op="now")["now_s"]
    cell.process.kill()

    again = start(*arguments)
    with again.connect("clock") as clock:
        after_s = ask_truth(clock, op="now")["now_s"]
    with again.connect("ballbar") as counter:
        counter.sendall(b"\x1bA0200\r")
        shown = counter.recv(100)

    assert after_s >= before_s - 5.0  # of the last deed on, seconds ago at most on a busy machine
    assert shown[:1] == b"\x02"  # a value: the bar still lies on its calibrator
