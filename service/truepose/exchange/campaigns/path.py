"""A campaign wherever it lies: a folder, or the zip of one."""

from pathlib import Path

from truepose.domain.measurement.campaign import Campaign
from truepose.exchange.campaigns.folder import read_campaign
from truepose.exchange.campaigns.zip_file import read_campaign_zip
from truepose.exchange.input_file import read_bytes


def read_campaign_at(path: Path) -> Campaign:
    """Read a campaign folder or the zip of one; raises InputFileError."""
    if path.suffix.lower() == ".zip" and not path.is_dir():
        return read_campaign_zip(read_bytes(path), path.name)
    return read_campaign(path)
