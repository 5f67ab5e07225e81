"""What every test shares."""

import os

from hypothesis import settings

os.environ.setdefault("MPLBACKEND", "Agg")  # pictures never open a window
settings.register_profile("here", deadline=None)  # the first example of a kernel loads compiled code
settings.load_profile("here")
