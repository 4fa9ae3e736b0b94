"""Arrays and pictures as text, so that they live in the .blend with the object."""

import base64
import io
import zlib

import numpy as np

from ..core.errors import DataError


def pack(**arrays: np.ndarray) -> str:
    """Named arrays as one text."""
    file = io.BytesIO()
    np.savez(file, **arrays)
    return pack_bytes(file.getvalue())


def unpack(text: str) -> dict[str, np.ndarray]:
    """What `pack` was given. Raises DataError for a text that is not one."""
    try:
        with np.load(io.BytesIO(unpack_bytes(text)), allow_pickle=False) as file:
            return {name: file[name] for name in file.files}
    except (OSError, ValueError, EOFError) as error:
        raise DataError(f"The object's kept data are broken ({error}). Calibrate again.") from error


def pack_bytes(data: bytes) -> str:
    return base64.b64encode(zlib.compress(data, 1)).decode("ascii")


def unpack_bytes(text: str) -> bytes:
    """Raises DataError for a text that is not one."""
    try:
        return zlib.decompress(base64.b64decode(text.encode("ascii"), validate=True))
    except (ValueError, zlib.error) as error:
        raise DataError(f"The object's kept data are broken ({error}). Calibrate again.") from error
