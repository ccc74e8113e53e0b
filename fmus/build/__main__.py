"""`python -m aeroslosh.fmus.build [--out dist/fmus] [component ...]`."""

import sys

from .archive import main

sys.exit(main())
