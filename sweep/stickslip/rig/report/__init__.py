"""Plots of records and of test matrices, and the report page."""
