"""Several voices side by side, a vector register's number of one each."""
