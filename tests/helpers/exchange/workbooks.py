"""Workbooks as spreadsheets write them, made by hand: the reader must not be tested by its own library."""

from xml.sax.saxutils import escape

from tests.helpers.exchange.archives import zipped

_MAIN = "http://schemas.openxmlformats.org/spreadsheetml/2006/main"
_RELATED = "http://schemas.openxmlformats.org/officeDocument/2006/relationships"
_PACKAGE = "http://schemas.openxmlformats.org/package/2006/relationships"
_HEAD = '<?xml version="1.0" encoding="UTF-8" standalone="yes"?>\n'
STYLES = (
    f'<styleSheet xmlns="{_MAIN}"><numFmts count="2">'
    '<numFmt numFmtId="164" formatCode="yyyy\\-mm\\-dd hh:mm"/>'
    '<numFmt numFmtId="165" formatCode="0.000&quot; mm (day)&quot;"/></numFmts>'
    '<cellStyleXfs count="1"><xf numFmtId="14"/></cellStyleXfs>'
    '<cellXfs count="4"><xf numFmtId="0"/><xf numFmtId="14"/>'
    '<xf numFmtId="164"/><xf numFmtId="165"/></cellXfs>'
    "</styleSheet>"
)


def letters(number):
    """Return what a column is called."""
    return "" if not number else letters((number - 1) // 26) + chr(ord("A") + (number - 1) % 26)


def sheet_of(rows, texts):
    """Return a sheet; words go to the book's texts, whatever begins with `<c` is taken as it is."""
    lines = []
    for number, row in enumerate(rows, start=1):
        cells = [cell(value, f"{letters(k)}{number}", texts) for k, value in enumerate(row, start=1)]
        lines.append(f'<row r="{number}">{"".join(cells)}</row>')
    return f'<worksheet xmlns="{_MAIN}"><sheetData>{"".join(lines)}</sheetData></worksheet>'


def cell(value, place, texts):
    if value is None:
        return ""
    if isinstance(value, str) and value.startswith("<c"):
        return value.replace("<c", f'<c r="{place}"', 1)
    if isinstance(value, str):
        texts.append(value)
        return f'<c r="{place}" t="s"><v>{len(texts) - 1}</v></c>'
    return f'<c r="{place}"><v>{value!r}</v></c>'


def workbook(sheets, target="worksheets/sheet{}.xml", state="visible", head="", also=None):
    """Return a workbook of sheets by their titles; the first one may be hidden."""
    texts = []
    parts = {
        f"xl/worksheets/sheet{k}.xml": sheet_of(rows, texts) for k, rows in enumerate(sheets.values(), 1)
    }
    listed = "".join(
        f'<sheet name="{escape(title)}" r:id="rId{k}" state="{state if k == 1 else "visible"}"/>'
        for k, title in enumerate(sheets, 1)
    )
    related = "".join(
        f'<Relationship Id="rId{k}" Target="{target.format(k)}"/>' for k in range(1, len(sheets) + 1)
    )
    parts |= {
        "[Content_Types].xml": "<Types/>",
        "xl/workbook.xml": f'<workbook xmlns="{_MAIN}" xmlns:r="{_RELATED}">{head}'
        + f"<sheets>{listed}</sheets></workbook>",
        "xl/_rels/workbook.xml.rels": f'<Relationships xmlns="{_PACKAGE}">{related}</Relationships>',
        "xl/sharedStrings.xml": f'<sst xmlns="{_MAIN}">'
        + "".join(f"<si><t>{escape(text)}</t></si>" for text in texts)
        + "</sst>",
        "xl/styles.xml": STYLES,
        **(also or {}),
    }
    return zipped((name, text if text.startswith("<?xml") else _HEAD + text) for name, text in parts.items())
