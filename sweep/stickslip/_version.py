"""The version, at its one home: the build and the code both read it here."""

__version__ = "0.2.0"
