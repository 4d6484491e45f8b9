"""Series: tables of times and values (CSV, JSON, Parquet) into timelines with events by rule."""
