"""`python -m armdrive` is the command line."""

import sys

from armdrive.cli import main

sys.exit(main())
