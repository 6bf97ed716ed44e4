"""`python -m tilecast`: the command line."""

from .cli import main

main()
