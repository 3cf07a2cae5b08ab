"""`python -m gomboc_cad` is the command line."""

from gomboc_cad.cli import main

main()
