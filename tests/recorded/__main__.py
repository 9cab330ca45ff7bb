"""Takes down anew what commands, replies, pages and wires say (`make behaviour`); git shows the changes."""

import asyncio
import shutil
import tempfile
from pathlib import Path

import pytest

from tests.helpers.web.pages import leave_pictures_empty
from tests.recorded import commands, day, wires
from tests.recorded.transcript import KEPT


def main():
    """Take everything down."""
    with pytest.MonkeyPatch.context() as patch:
        leave_pictures_empty(patch)
        taken = [*wires.listen(), _in_a_folder(commands.type_all)]
        for spend in day.DAYS:
            taken += _in_a_folder(lambda folder, spend=spend: asyncio.run(spend(folder)))
    shutil.rmtree(KEPT, ignore_errors=True)  # what nothing says any more goes
    for transcript in taken:
        transcript.keep()


def _in_a_folder(do):
    with tempfile.TemporaryDirectory() as folder:
        return do(Path(folder))


if __name__ == "__main__":
    main()
