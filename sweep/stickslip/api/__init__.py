"""The Python calls."""
