"""`python -m lensbench.app` is the command `lensbench`."""

import sys

from lensbench.app.command.main import main

sys.exit(main())
