"""What all documents of results share: what `--json` prints, the REST API shows and its schema describes."""

from typing import Annotated, TypeAlias

from pydantic import BeforeValidator, ConfigDict

from truepose.domain.sentences import Sentence
from truepose.exchange.json_text import Json
from truepose.exchange.outgoing import Outgoing
from truepose.words.catalogue import english


def _in_english(value: object) -> object:
    return english(value) if isinstance(value, Sentence) else value


Spoken: TypeAlias = Annotated[
    str, BeforeValidator(_in_english)
]  # documents are in English, whoever reads them


class Document(Outgoing):
    """A document of the command line; keys may be added to it, never renamed."""

    model_config = ConfigDict(extra="allow")

    def printed(self) -> dict[str, Json]:
        """Return the document as JSON has it; keys that were not given are absent."""
        return self.model_dump(mode="json", by_alias=True, exclude_unset=True)
