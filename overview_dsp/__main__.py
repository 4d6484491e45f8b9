"""`python -m overview_dsp` is `overview`."""

from overview_dsp.cli import main

main()
