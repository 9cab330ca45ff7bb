"""A campaign that a program has in memory: the keys of `campaign.json`, and tables of arrays by role."""

from collections.abc import Mapping
from typing import Final

from truepose.domain.measurement.campaign import Campaign
from truepose.exchange.campaigns.description import FORMAT, read_description
from truepose.exchange.campaigns.folder import with_tables
from truepose.exchange.document import Node
from truepose.exchange.tables.table import Arrays

_NAME: Final = "campaign"  # where errors place a key


def campaign_from_arrays(keys: Mapping[str, object], tables: Mapping[str, Arrays]) -> Campaign:
    """Return the campaign, checked as one from a folder is.

    Parameters
    ----------
    keys : mapping
        Those of `campaign.json` but `format` and `files`, with lists and plain numbers.
    tables : mapping of str to mapping of str to ndarray
        By role, such as `calibration`: columns of shape (n,) by their names in the file format.

    Raises
    ------
    InputFileError
        With the key, or with role, row and column.
    """
    document = {**keys, "format": FORMAT, "files": {role: role for role in tables}}
    return with_tables(read_description(Node(_NAME, document, (), lambda path: None)), tables.__getitem__)
