"""Files as they come: archives, texts, workbooks, and the sheets in them."""
