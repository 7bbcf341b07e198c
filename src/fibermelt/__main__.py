"""``python -m fibermelt``: the command line."""

from fibermelt.cli import main

main()
