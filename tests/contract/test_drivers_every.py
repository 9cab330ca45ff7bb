"""What every registered driver promises over a socket; the rest is asked by the contract suite."""

import socket

import pytest

from tests.contract.benches import NEEDED, registry
from truepose_drivers.errors import ConnectFailedError

PORTED = sorted(name for name in registry().names() if "port" in registry().plugin(name).options)


@pytest.mark.parametrize("name", PORTED)
async def test_nobody_at_the_address_is_said_with_address_and_remedy(name):
    with socket.socket() as silent:
        silent.bind(("127.0.0.1", 0))
        port = silent.getsockname()[1]
        driver = registry().open(name, {"host": "127.0.0.1", "port": port, **NEEDED.get(name, {})})
        ask = driver.now_s if registry().plugin(name).kind == "clock" else driver.connect

        with pytest.raises(ConnectFailedError, match=rf"127\.0\.0\.1:{port}.*check"):
            await ask()
