"""The one family of errors: each message names the thing, what it is and needs, what to do."""


class CoreError(Exception):
    """Anything that the user can mend. Its text is one readable line."""


class DataError(CoreError):
    """A noun was built from numbers that cannot be one."""


class CaseError(CoreError):
    """A case file, or a file that it names, cannot be read as the contract says."""


class MeshError(CoreError):
    """A surface that cannot be made solid, or a tetrahedralization that failed."""


class RecordingError(CoreError):
    """A recording or a video that cannot carry the question asked of it."""


class Cancelled(CoreError):
    """The user asked to stop. Nothing was written."""
