"""Files that are written whole or not at all."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from .errors import CaseError


@contextmanager
def written_whole(path: str | Path) -> Iterator[Path]:
    """A path beside `path` to write to; renamed to it at the end, removed after any break.

    It keeps the suffix, which tells some writers the format. Raises CaseError where the folder is
    missing or may not be written to, or `path` cannot be replaced.
    """
    path = Path(path)
    draft = path.with_name(f".{os.getpid()}.{path.name}")
    try:
        draft.open("wb").close()
    except OSError as error:
        raise CaseError(
            f"{path}: cannot be written ({error.strerror}). Give a file in a folder that exists "
            "and may be written to."
        ) from error
    try:
        yield draft
        _put(draft, path)
    finally:
        draft.unlink(missing_ok=True)


def _put(draft: Path, path: Path) -> None:
    try:
        os.replace(draft, path)
    except OSError as error:
        raise CaseError(
            f"{path}: cannot be replaced ({error.strerror}). Close what holds it open, or name "
            "another file."
        ) from error
