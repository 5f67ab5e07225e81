"""Evaluation of records: stick phases, drops, the table of features, and the risk model fitted to numbers."""
