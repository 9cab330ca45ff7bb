"""Certificates of the cell that end soon, or have ended: said before somebody measures on them."""

from collections.abc import Iterator
from datetime import date

from truepose.domain.cell.certificates import judged_papers
from truepose.domain.cell.description import Cell
from truepose.domain.sentences import Text, said
from truepose.operation.certificates import papers_of_cell


def expiry_warnings(cell: Cell, today: date) -> Iterator[Text]:
    """Yield a sentence for each certificate that ends within thirty days, or has ended."""
    for one in judged_papers(papers_of_cell(cell), today):
        if one.standing == "ends soon":
            left = (date.fromisoformat(one.paper.expires) - today).days
            yield said("certificate.ends_soon", what=one.paper.called, day=one.paper.expires, days=left)
        elif one.standing == "expired":
            yield one.fault
