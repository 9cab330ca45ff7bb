"""`python -m truepose` is the `truepose` command."""

import sys

from truepose.cli import main

if __name__ == "__main__":
    sys.exit(main())
