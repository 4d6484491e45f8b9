"""Command `python -m overview_dsp`, the same as `overview`."""

from overview_dsp.cli import main

main()
