"""What becomes files: renders, plots and exports."""
