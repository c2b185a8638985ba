"""The exceptions: one for each error enum of the Rust rooms, with their messages."""


class GtfdiError(Exception):
    """Anything that this package refuses."""


class DimensionError(GtfdiError, ValueError):
    """Sizes disagree.

    Attributes
    ----------
    what : str
        What was measured, for example ``rows of B``.
    expected, found : int
        The size that fits and the size found.
    """

    what: str
    expected: int
    found: int


class DataError(GtfdiError, ValueError):
    """A record cannot be built or used."""


class ArrayTypeError(GtfdiError, TypeError):
    """An array of something else than real numbers."""


class OptionError(GtfdiError, ValueError):
    """An option is out of its range, or options exclude each other."""


class ModelError(GtfdiError, ValueError):
    """A state-space model cannot be built or used."""


class IdentError(GtfdiError, ValueError):
    """A model cannot be identified, realised or applied."""


class DesignError(GtfdiError, ValueError):
    """A generator, a threshold or a bank cannot be made or used."""


class StepError(GtfdiError, ValueError):
    """The online detector refuses a sample; its state is as it was before."""


class PlantError(GtfdiError, ValueError):
    """A scenario cannot be simulated."""


class LogError(GtfdiError):
    """A file cannot be read or written."""


class PickleError(GtfdiError, ValueError):
    """A pickle is of another version of this package, or its bytes are broken."""
