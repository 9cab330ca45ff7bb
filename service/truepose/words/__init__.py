"""The catalogue of words for people: one folder of texts a language, and what fills them in.

To add a language, copy the folder `en`, give it the ISO 639-1 code of the language, and translate what stands
to the right of the colons; `names.json` says what the names of documents ("joint 2", "backlash") are called.
`tests/unit/service/words` says what is missing.
"""
