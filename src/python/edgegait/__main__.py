"""`python -m edgegait`: the command."""

from ._main import main

main()
