"""Whether controllers arrive where corrected programs send them.

`python -m tests.studies.correction.arriving --n 5000` draws targets of each language over the whole work
space, half of them at singularities, at borders of turns and at limits, has them corrected by models that
are off by some millimetres and tenths of a degree, and runs each corrected file by a controller of another
make (the `drawn_programs` of the helpers). Of each language it says how many targets were corrected, how
many of these lead the controller to other joints than were solved, and why the rest was left alone; then the
same for targets drawn evenly. Ends with 1 where one goes elsewhere.
"""

import sys

from tests.helpers.exchange.drawn_programs import LANGUAGES, tried
from tests.studies.running import study_options


def main(arguments=None):
    """Print a line per language and draw."""
    given = study_options(__doc__, arguments, n=5000, seed=1, size=(1.0, "of the errors"))
    elsewhere = 0
    for name, language in LANGUAGES.items():
        for hard in (True, False):
            count = tried(language, given.n, given.seed, given.size, hard=hard)
            elsewhere += count.elsewhere
            alone = ", ".join(f"{why} {many}" for why, many in sorted(count.alone.items()))
            sys.stdout.write(
                f"{name:9} {'hard' if hard else 'even'}: {count.drawn} drawn, {count.corrected} corrected, "
                f"{count.elsewhere} elsewhere; left alone: {alone or 'none'}\n"
            )
    return 1 if elsewhere else 0


if __name__ == "__main__":
    sys.exit(main())
