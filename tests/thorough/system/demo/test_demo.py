"""The demo as a user runs it: real processes, real sockets, a small number of configurations."""

import contextlib
import json
import os
import signal
import sqlite3
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from tests.helpers.checkout import CHECKOUT
from tests.system.processes_left import descendants, named, running_after
from tests.thorough.integration.deployment.images import environment, install
from truepose.demo.command import DemoSize, run_demo
from truepose.exchange.campaigns.folder import read_campaign
from truepose.exchange.models.file import read_model
from truepose.exchange.results.identification import identification_document
from truepose.identification import identify, predict
from truepose.storage.engine.sqlite_file import ServiceLock

SCENARIO = "irb120-tilted"
SMALL = DemoSize(calibration=25, validation=40)
STATISTICS = {"n", "mean_mm", "rms_mm", "sd_mm", "max_mm", "noise_mm"}

pytestmark = pytest.mark.skipif(
    not Path("/proc/self/stat").exists(), reason="processes are looked for in /proc"
)


# On two idle cores it takes ten seconds; no machine is so busy.
DEMO_S = 900.0


def of_size(calibration, validation):
    """Arguments of an interpreter for a small demo; the folder comes behind them."""
    size = f"DemoSize({calibration}, {validation})"
    return (
        "-c",
        "import sys; from pathlib import Path; from truepose.demo.command import DemoSize, run_demo; "
        f"raise SystemExit(run_demo(Path(sys.argv[1]), 5, {SCENARIO!r}, {size}))",
    )


class FinishedDemo:
    def __init__(self, out, status, printed):
        self.out = out
        self.status = status
        self.printed = printed
        self.result = json.loads((out / "result.json").read_text())


@pytest.fixture(scope="module")
def python(tmp_path_factory):
    """The interpreter of a clean environment into which a wheel of this checkout was installed."""
    return install(CHECKOUT, tmp_path_factory.mktemp("installed")) / "python"


@pytest.fixture(scope="module")
def broken_off(tmp_path_factory):
    """A demo whose cell was killed while the service measured: its folder, its status, what it said."""
    out = tmp_path_factory.mktemp("demo")
    with started_demo(out, of_size(30, 5)) as process:
        read_until(process, "measuring calibration")
        until_something_is_measured(out / "sessions.sqlite3")
        (cell,) = named(descendants(process.pid), "--pace")
        os.kill(cell, signal.SIGKILL)
        said = process.communicate(timeout=60)[1]
    return out, process.returncode, said


@pytest.fixture(scope="module")
def demo(python, broken_off):
    """A demo of what was installed, in the folder that another one has left."""
    out, *_ = broken_off
    command = [str(python), *of_size(25, 40), str(out)]
    done = subprocess.run(
        command, cwd=out, env=environment(), capture_output=True, text=True, check=False, timeout=DEMO_S
    )
    assert (out / "result.json").exists(), done.stderr
    return FinishedDemo(out, done.returncode, done.stdout)


def test_a_cell_that_dies_in_the_middle_is_said_and_its_folder_can_be_used_again(broken_off, demo):
    _, status, said = broken_off

    assert status == 3
    assert "Session 1 is awaiting confirmation" in said
    assert demo.status == 0


def test_a_demo_identifies_validates_and_leaves_everything_it_promises(demo):
    assert demo.status == 0
    assert demo.result["identification"]["status"] == "converged"
    assert demo.result["validation"]["pass"] is True
    assert demo.result["diagnosis"]["verdict"] == "consistent"
    assert demo.result["wall_s"] > 0
    assert {"report.html", "diagnosis.html", "result.json", "model.json", "campaign"} <= set(
        os.listdir(demo.out)
    )


def test_the_documents_hold_the_promised_blocks(demo):
    identification, truth = demo.result["identification"], demo.result["truth"]
    blocks = [
        *identification["statistics"]["validation"].values(),
        *identification["statistics"]["calibration"].values(),
        *demo.result["validation"]["distance"].values(),
        truth["validation_true_error"],
    ]

    assert all(set(block) >= STATISTICS for block in blocks)
    assert identification["counts"]["configurations"] == 25
    assert identification["counts"]["observations"] == 3 * (25 + 5)  # five are visited again
    assert truth["validation_true_error"]["n"] == 40
    assert [p["name"] for p in truth["parameters"]] == [p["name"] for p in identification["parameters"]]


def test_the_true_error_is_what_the_model_says_of_itself(demo):
    readings = read_campaign(demo.out / "campaign").validation
    _, stated_mm = predict(read_model(demo.out / "model.json"), readings.stops, readings.nest)

    expected_mm = np.sqrt(3 * np.mean(stated_mm**2))

    # One plant gives one draw of 31 parameters, but 25 configurations mix a dozen independent directions of
    # them: the ratio scatters by about 1 / sqrt(2 * 12) = 20 %, of which four are allowed upwards.
    assert demo.result["truth"]["validation_true_error"]["rms_mm"] < 1.8 * expected_mm


def test_alignment_takes_away_what_the_tracker_registration_was_off_by(demo):
    truth = demo.result["truth"]

    # A rigid motion fitted by least squares can only lower the sum of squares.
    assert truth["validation_true_error_aligned"]["rms_mm"] <= truth["validation_true_error"]["rms_mm"]


def test_every_parameter_lies_near_its_true_value(demo):
    for parameter in demo.result["truth"]["parameters"]:
        # 31 normal deviates beyond five standard uncertainties: 2e-5
        off = parameter["identified"] - parameter["true"]
        assert abs(off) < 5 * parameter["standard_uncertainty"], parameter["name"]


def test_the_campaign_left_behind_gives_the_same_identification(demo):
    campaign = read_campaign(demo.out / "campaign")

    again = identification_document(identify(campaign), campaign.robot.name)

    # A folder carries 1e-5 mm of readings that scatter by 0.02 mm: a two-thousandth of their noise.
    measured = demo.result["identification"]["parameters"]
    for one, other in zip(again["parameters"], measured, strict=True):
        assert abs(one["value"] - other["value"]) < 1e-3 * other["standard_uncertainty"], other["name"]


def test_the_report_states_who_measured_what_under_which_load(demo):
    report = (demo.out / "report.html").read_text()

    assert "Leica" in report
    assert "robot controller" in report
    assert "2.7 kg at (50, 25, 100) mm" in report
    assert f"Scenario {SCENARIO}, seed 5." in report


def test_the_diagnosis_is_the_service_s_and_the_report_beside_it_shows_it(demo):
    found = demo.result["diagnosis"]
    page = (demo.out / "diagnosis.html").read_text()

    assert found["findings"] == []
    assert found["held_out"] == "validation"
    assert found["after"]["n"] == 40
    assert found["message"] in page
    assert f"scenario {SCENARIO}, seed 5" in page
    assert 'href="diagnosis.html"' in (demo.out / "report.html").read_text()
    assert f"Diagnosis: {found['message']}" in demo.printed


def test_the_tables_show_errors_and_parameters(demo):
    assert "after rigid alignment" in demo.printed
    assert "theta_6" in demo.printed
    assert "Identified and validated." in demo.printed


def test_no_process_is_left(demo):
    assert named(descendants(1), str(demo.out)) == []  # who is left alone goes to the first of all


def test_an_unknown_scenario_is_one_sentence_that_lists_the_known_ones(tmp_path, capsys):
    status = run_demo(tmp_path, 0, "irb120-nonsense", SMALL)

    assert status == 2
    assert 'no scenario "irb120-nonsense"' in capsys.readouterr().err


def test_a_second_demo_in_the_same_folder_is_refused(tmp_path, capsys):
    lock = ServiceLock(tmp_path / "sessions.sqlite3")

    status = run_demo(tmp_path, 0, SCENARIO, SMALL)

    lock.release()
    assert status == 3
    assert "in use by another truepose service" in capsys.readouterr().err


AS_TYPED = ("-m", "truepose", "demo", "--seed", "6", "--out")


@contextlib.contextmanager
def started_demo(out, program=AS_TYPED):
    """A demo as a process, whose standard error can be waited for."""
    # Whoever runs the tests in the background has SIGINT ignored, and children inherit that.
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    command = [sys.executable, *program, str(out)]
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    signal.signal(signal.SIGINT, before)
    try:
        yield process
    finally:
        process.kill()
        process.wait()
        process.stderr.close()


def read_until(process, words):
    """Read its standard error up to a line with `words`."""
    for line in process.stderr:
        if words in line:
            return
    raise AssertionError(f"the demo ended without saying {words!r}")


def test_ctrl_c_ends_every_process_and_says_what_was_kept(tmp_path):
    with started_demo(tmp_path) as process:
        read_until(process, "choosing calibration")
        children = descendants(process.pid)
        process.send_signal(signal.SIGINT)
        said = process.communicate(timeout=30)[1]

    assert process.returncode == 130
    assert "Interrupted while choosing calibration configurations" in said
    assert "sessions.sqlite3" in said
    assert "Traceback" not in said
    assert len(children) >= 2  # the service and its cell
    assert running_after(children, wait_s=0) == []


def test_a_demo_that_is_killed_leaves_no_process(tmp_path):
    with started_demo(tmp_path) as process:
        read_until(process, "choosing calibration")
        children = descendants(process.pid)
        process.kill()
        process.wait()

        assert len(children) >= 2  # the service and its cell
        # The service notices at once, and gives what it does up to ten seconds to end in order.
        assert running_after(children, wait_s=20) == []


def until_something_is_measured(database):
    with contextlib.closing(sqlite3.connect(f"file:{database}?mode=ro", uri=True)) as found:
        while found.execute("SELECT count(*) FROM readings").fetchone() == (0,):
            time.sleep(0.01)
