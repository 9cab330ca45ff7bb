"""XML that somebody brings, read through the handlers of a parser."""

from typing import NoReturn
from xml.parsers import expat

from truepose.exchange.errors import UnreadableFileError


def read_xml(parser: expat.XMLParserType, file: str, data: bytes, otherwise: str) -> None:
    """Have a parser read a whole document.

    Parameters
    ----------
    parser : expat parser
        With its handlers, which raise neither LookupError nor ValueError: the parser itself raises these, of
        an encoding that it does not know.
    file : str
        Its name, for sentences.
    data : bytes
    otherwise : str
        What is said of a file that is no XML, before the reason.

    Raises
    ------
    UnreadableFileError
        It is no XML, is cut off, or declares a document type: entities of one could grow without end or name
        files of the machine.
    """

    def refuse_document_type(*_declared: object) -> NoReturn:
        sentence = "the file declares a document type, which is not supported; remove the <!DOCTYPE"
        raise UnreadableFileError(sentence, file=file, line=parser.CurrentLineNumber)

    parser.StartDoctypeDeclHandler = refuse_document_type
    try:
        parser.Parse(data, True)
    except expat.ExpatError as error:
        reason = expat.ErrorString(error.code)
        raise UnreadableFileError(f"{otherwise} ({reason})", file=file, line=error.lineno) from error
    except (LookupError, ValueError) as error:
        reason = "its encoding is not known; save it as UTF-8"
        raise UnreadableFileError(f"{otherwise} ({reason})", file=file, line=1) from error
