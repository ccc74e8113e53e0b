"""`python -m aeroslosh`: the command line."""

from .master.cli import main

main()
