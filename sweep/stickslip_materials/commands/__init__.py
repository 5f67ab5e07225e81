"""The commands of measured friction: `fit`, `points`, `compare`."""
