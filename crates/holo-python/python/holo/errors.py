"""Exceptions and warnings of this package. The messages are those of the command line `holo`."""


class Error(Exception):
    """The work failed: a file is damaged or missing, a disk is full."""


class UsageError(Error, ValueError):
    """The arguments ask for something that cannot be."""


class OutOfMemoryError(Error, MemoryError):
    """There is not enough memory; the message says how much is needed, where that is known."""


class HoloWarning(UserWarning):
    """A result is probably not what was wanted, such as an image in which nothing is hit."""


Error.__module__ = UsageError.__module__ = OutOfMemoryError.__module__ = HoloWarning.__module__ = "holo"
