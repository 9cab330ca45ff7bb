"""A camera on a serial line: started again, taken to another speed, or refused with a sentence."""

import pytest

from truepose_drivers.errors import ConfigurationError, ConnectFailedError, ConnectionLostError
from truepose_drivers.ndi_polaris.driver import PLUGIN
from truepose_drivers.ndi_polaris.protocol import OKAY, RESET, encode_reply, error_text
from truepose_drivers.ndi_polaris.serial_line import CameraLine

STARTED, AGREED = encode_reply(RESET), encode_reply(OKAY)


class ScriptedLine:
    """Answers a break and a request with what it is told to; notes everything."""

    address = "COM7"

    def __init__(self, after_break=STARTED, after_request=AGREED):
        self.after_break, self.after_request = after_break, after_request
        self.is_open = False
        self.done = []
        self._waiting = []

    async def open(self):
        self.is_open = True

    async def close(self):
        self.is_open = False

    async def send_break(self):
        self.done.append("break")
        self._say(self.after_break)

    async def set_baud(self, baud):
        self.done.append(baud)

    async def send(self, data):
        self.done.append(data)
        self._say(self.after_request)

    async def receive(self, timeout_s):
        return self._waiting.pop(0) if self._waiting else None

    def _say(self, data):
        self._waiting += [data[k : k + 4] for k in range(0, len(data), 4)]


async def test_a_break_starts_it_again_and_comm_takes_it_to_115200_baud():
    line = ScriptedLine()

    await CameraLine(line).open()

    asked, request, baud = line.done
    assert (asked, baud) == ("break", 115_200)
    assert request.startswith(b"COMM:50000")
    assert line.is_open


async def test_what_it_sent_at_another_speed_is_passed_over():
    line = ScriptedLine(after_break=b"\x00\xfe\xc4\xa5rubbish\r" + encode_reply(RESET))

    await CameraLine(line).open()

    assert line.done[-1] == 115_200


@pytest.mark.parametrize(
    ("line", "said"),
    [
        (ScriptedLine(after_break=b""), "did not start again"),
        (ScriptedLine(after_break=b"\x55" * 5000), "did not start again"),
        (ScriptedLine(after_request=b""), "did not agree"),
        (ScriptedLine(after_request=encode_reply(error_text(0x06))), "did not agree"),
    ],
)
async def test_a_camera_that_does_not_answer_as_one_is_not_connected(line, said):
    with pytest.raises(ConnectFailedError, match=f"COM7 {said}"):
        await CameraLine(line).open()

    assert not line.is_open
    assert 115_200 not in line.done


async def test_a_port_that_goes_away_meanwhile_is_a_failed_connection():
    line = ScriptedLine()

    async def pulled():
        raise ConnectionLostError("port COM7 was disconnected: check cable and adapter, then connect again")

    line.send_break = pulled

    with pytest.raises(ConnectFailedError, match="was disconnected"):
        await CameraLine(line).open()


def test_the_cell_file_says_serial_or_host(tmp_path):
    definition = tmp_path / "a.rom"
    definition.write_bytes(b"artefact")

    assert not PLUGIN.open({"serial": "/dev/ttyUSB0", "tool_file": str(definition)}, None).connected
    with pytest.raises(ConfigurationError, match="host"):
        PLUGIN.open({"tool_file": str(definition)}, None)
