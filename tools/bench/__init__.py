"""The engine beside other ways to do the same work, and its cost as the work grows.

`python -m tools.bench` in a clone of the project; `overview bench` measures the engine alone.
"""
