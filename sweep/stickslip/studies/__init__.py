"""Studies, what a run may compute beside a map: each a package, and what they share (`study.py`)."""
