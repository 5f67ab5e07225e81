"""What every test shares: pictures never open a window."""

import os

os.environ.setdefault("MPLBACKEND", "Agg")
