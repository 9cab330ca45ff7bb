"""Campaigns on request: one line in, one status out."""

import io
import json

import pytest

from truepose_simulators.recording.__main__ import main
from truepose_simulators.recording.on_request import serve


class FakeRecorder:
    """Notes what it is asked for and answers with a status."""

    def __init__(self, status=0):
        self.asked = []
        self.status = status

    def __call__(self, arguments):
        self.asked.append(arguments)
        return self.status


def answers(text, recorder):
    said = io.StringIO()
    serve(io.StringIO(text), said, recorder)
    return said.getvalue()


def test_every_line_is_recorded_and_answered_in_turn():
    recorder = FakeRecorder()

    said = answers('["irb120-clean", "--out", "a"]\n["irb120-clean", "--out", "b"]\n', recorder)

    assert recorder.asked == [["irb120-clean", "--out", "a"], ["irb120-clean", "--out", "b"]]
    assert said == "0\n0\n"


def test_a_refused_recording_does_not_end_the_others():
    assert answers('["one"]\n["two"]\n', FakeRecorder(status=2)) == "2\n2\n"


@pytest.mark.parametrize(
    ("line", "sentence"),
    [
        ("irb120-clean", "a request is a JSON list of arguments"),
        ('"irb120-clean"', "a request is a JSON list of strings"),
        ('["irb120-clean", 3]', "a request is a JSON list of strings"),
        ("", "a request is a JSON list of arguments"),
    ],
)
def test_a_line_that_is_no_request_is_refused_in_a_sentence(line, sentence, capsys):
    recorder = FakeRecorder()

    assert answers(line + "\n", recorder) == "2\n"
    assert sentence in capsys.readouterr().err
    assert recorder.asked == []


def test_arguments_that_the_command_refuses_are_refused(capsys):
    assert answers(json.dumps(["irb120-clean", "--seed", "minus one"]) + "\n", main) == "2\n"
    assert "--seed" in capsys.readouterr().err


def test_a_recorded_campaign_lies_in_its_folder(tmp_path):
    sizes = ["--configurations", "5", "--validation", "0", "--reference-every", "0"]

    assert answers(json.dumps(["irb120-clean", "--out", str(tmp_path), *sizes]) + "\n", main) == "0\n"
    assert json.loads((tmp_path / "campaign.json").read_text())["simulated"] is True
