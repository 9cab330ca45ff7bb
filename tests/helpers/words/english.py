"""English words in texts of another language."""

import re

# Of each English sentence at least one of these is a part, and of no French one.
FUNCTION_WORDS = set(
    re.findall(
        r"\w+",
        """
    the of and is are was were with without by that which what from this these than it its not no nothing has
    have be been they them there where when how all each every other more
""",
    )
)
NOUNS = set(
    re.findall(
        r"\w+",
        """
    joint joints link links nest nests tool load time direction torque mounting mountings range line
    wave curve jump drift settling sign group reading readings shift error order mean speed length share turn
""",
    )
)
TITLES = ("Annals of Statistics", "An Introduction to the Bootstrap")


def english_in(text, words=FUNCTION_WORDS):
    """Return the English words of a text, titles of English works aside."""
    for title in TITLES:
        text = text.replace(title, "")
    # Keys of tables and names of effects keep their spelling between backquotes and in brackets.
    return sorted(words & set(re.findall(r"[a-zà-ÿ]+", re.sub(r"`\w+`|<[^>]*>", "", text.lower()))))
