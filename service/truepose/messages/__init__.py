"""The catalogue of what people read: translations by language and domain, and what fills them in.

To add a sentence, give it a key in the domain that it belongs to (`en/LC_MESSAGES/<domain>.po`) and in the
same file of each other language; `message(key, ...)` says it. To add a language, copy the folder `en`, give
it the language's ISO 639-1 code, set `Language` and `Plural-Forms` in the header of each file, and
translate each `msgstr`. `names.po` has what the names of documents ("joint 2", "backlash") are called, in
the forms that the language needs as `msgctxt`. `tests/unit/service/messages` shows what is missing.

A blank says how it is filled in: numbers by Python's formats (`{share:.1e}`), names in one of their forms
(`{joint:of}`; `{joint:The}` begins a sentence), effects by their names (`{effect:cause}`), lists by the way
in which `list.*` joins them (`{rivals:or}`), a sentence without its full stop (`{sentence:open}`).

A quantity states the unit that it is kept in, and is shown in the reader's: `{off_mm:.3f mm}` with the word
for that unit, `{low_mm:.3f (mm)} to {high_mm:.3f mm}` where the word stands behind another number. `{mm}` is
the word alone, as at the head of a column; `{20:°C}` a quantity that a text states itself.

The value `n` is a count: a text that has plural forms is said in the form for it.
"""
