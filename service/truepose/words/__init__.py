"""The catalogue of words for people: one folder of texts a language, and what fills them in.

To add a language, copy the folder `en`, give it the ISO 639-1 code of the language, and translate what stands
to the right of the colons; `names.json` says what the names of documents ("joint 2", "backlash") are called,
as in `fr`. `tests/unit/service/words` says what is missing.

A blank says how it is filled in: numbers by Python's formats (`{share:.1e}`), names in one of their forms
(`{joint:of}`; `{joint:The}` begins a sentence), effects by their names (`{effect:cause}`), lists by the way
in which `list.*` joins them (`{rivals:or}`), a sentence without its full stop (`{sentence:open}`).
"""
