"""Reports: a result as one description, made into page, file, PDF and terminal text.

A kind has one file, or a folder where its subject is large: what it is of, which sections it shows, its
tables and its own figures. Its template of the same name lays the sections out. `report` makes pages of any
kind, `tables` shows the same rows on pages and terminals, `figures` has what several kinds draw.
"""
