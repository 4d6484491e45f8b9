"""Series: from the columns of a table to a curve, its gaps and its events."""
