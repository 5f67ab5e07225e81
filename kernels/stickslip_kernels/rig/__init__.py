"""Rigs: the same contact on a belt whose speed changes, in segments of constant acceleration."""
