"""Zip files in memory."""

import io
import zipfile


def zipped(members, method=zipfile.ZIP_DEFLATED):
    """Return the bytes of an archive of pairs of name and content; a name may come twice."""
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", method) as archive:
        for name, content in members:
            archive.writestr(name, content)
    return stream.getvalue()
