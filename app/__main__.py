"""`python -m lensbench.app` is the command `lensbench`."""

import sys

from lensbench.app.cli import main

sys.exit(main())
