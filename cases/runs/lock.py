"""One writer a run folder: a lock of the operating system, which dies with its process.

Reading commands take no lock. A file system without locks is used as it is.
"""

from __future__ import annotations

import errno
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO

from filelock import lock_descriptor, unlock_descriptor

from .folder import LOCK, FolderError

NO_LOCKS = (errno.ENOSYS, errno.ENOLCK, errno.EOPNOTSUPP)


@contextmanager
def locked(folder: Path) -> Iterator[None]:
    """Be the only process that writes into a folder.

    Raises
    ------
    FolderError
        Another process writes there; with its id.
    OSError
        A folder that cannot be written to.
    """
    with open(folder / LOCK, "a+b", buffering=0) as file:
        if not _take(file):
            raise FolderError(
                f"{folder} is being written by process {_owner(file)}; wait for its end, or stop it"
            )
        file.truncate(0)
        file.write(f" {os.getpid()}".encode())  # Windows keeps others from the first byte
        try:
            yield
        finally:
            file.truncate(0)
            unlock_descriptor(file.fileno())


def _take(file: BinaryIO) -> bool:
    try:
        return lock_descriptor(file.fileno(), blocking=False)
    except OSError as error:
        if error.errno in NO_LOCKS:
            return True
        raise


def _owner(file: BinaryIO) -> str:
    file.seek(1)
    return file.read().decode(errors="replace") or "unknown"
