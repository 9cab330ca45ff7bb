"""Which branch of the arm a program asks for, in the words of its format.

ABB's confdata ends with cfx (0 to 7): 4 for a wrist behind axis 1, 2 for a wrist behind the lower arm, 1
for a negative joint 5. Behind axis 1 the lower arm leans backwards, so that a wrist behind it is one with the
elbow up. What FANUC's F and N, KUKA's S and Staubli's words mean for an arm its table does not tell.
"""

import re
from typing import Final

from truepose.kinematics.inverse import BRANCH_NAMES

_CONFDATA: Final = re.compile(r"-?\d+, -?\d+, -?\d+, ([0-7])")


def branch_of_words(words: str) -> int | None:
    """Return the branch, as `kinematics.inverse` numbers them; None where it is not understood."""
    if words in BRANCH_NAMES:
        return BRANCH_NAMES.index(words)
    found = _CONFDATA.fullmatch(words)
    if found is None:
        return None
    cfx = int(found[1])
    back, behind_lower_arm, negative = cfx >> 2, (cfx >> 1) & 1, cfx & 1
    return 4 * back + 2 * (behind_lower_arm ^ back) + negative
