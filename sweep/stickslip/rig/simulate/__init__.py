"""Simulated rigs: configurations with a drive in, records and tables of features out."""
