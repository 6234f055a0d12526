"""`python -m oitbench`."""

from oitbench.cli import main

main()
