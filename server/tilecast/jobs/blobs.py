"""Large bytes by key: scenes, assets, what is kept of a job's tiles, finished images. obstore reaches the place by URL.

Keys:
    scenes/{sha256}.json            the scene as it was submitted
    assets/{sha256}                 an uploaded file
    jobs/{id}/tiles/{index}-{n}     a tile with n sample ranges: everything needed to go on
    jobs/{id}/pixels.npy            the finished image, float32 [height, width, 3]
    jobs/{id}/variance.npy          of the finished image's pixels, the same
    jobs/{id}/first-hits.npy        what the camera sees first, float32 [height, width, 7], where somebody asked for it
    jobs/{id}/thumbnail.png
    database                        the name of the database that tells of all these
    uploads/{random}                an asset on its way in, not yet verified
"""

import hashlib
import io
import os
import secrets
from collections.abc import AsyncIterator, Iterator, Sequence
from contextlib import suppress
from pathlib import Path
from urllib.parse import unquote, urlsplit

import numpy as np
import obstore
from obstore.store import from_url

from tilecast.jobs.faults import CannotStart


class Mismatch(ValueError):
    """The bytes that came are not those that the name promises. `actual` is their SHA-256."""

    def __init__(self, actual: str):
        super().__init__(f"the bytes that came have the SHA-256 {actual}")
        self.actual = actual


class TooLarge(ValueError):
    """More bytes came than the limit allows."""


class Blobs:
    """A place for blobs: `file:///folder`, `s3://bucket/prefix`, or whatever else obstore reaches."""

    def __init__(self, url: str):
        self.url = url
        # A store on this machine: known so that writes can be forced to the disk.
        self.folder = Path(unquote(urlsplit(url).path)) if url.startswith("file:") else None
        options = {"mkdir": True, "automatic_cleanup": True} if self.folder else {}
        try:
            self._store = from_url(url, **options)
        except Exception as error:  # obstore's own and pyo3's, depending on what is wrong
            raise cannot_keep(url, error) from None

    def put(self, key: str, data: bytes, *, durable: bool = True) -> None:
        """Store `data` whole or not at all. `durable`: it outlives a power cut once this returns."""
        obstore.put(self._store, key, data)
        if durable:
            self._flush(key)

    def get(self, key: str) -> bytes:
        """The bytes under `key`. Raises `FileNotFoundError`."""
        return bytes(obstore.get(self._store, key).bytes())

    def put_array(self, key: str, array: np.ndarray, *, durable: bool = True) -> None:
        """Store an array as an NPY file: a header, then its numbers row by row. Otherwise as `put`."""
        out = io.BytesIO()
        np.save(out, array)
        self.put(key, out.getvalue(), durable=durable)

    def get_array(self, key: str) -> np.ndarray:
        """What `put_array` stored. Raises `FileNotFoundError`."""
        return np.load(io.BytesIO(self.get(key)), allow_pickle=False)

    def ranges(self, key: str, starts: Sequence[int], length: int) -> list[bytes]:
        """`length` bytes from each of `starts`. Raises `FileNotFoundError`."""
        parts = obstore.get_ranges(self._store, key, starts=starts, lengths=[length] * len(starts))
        return [bytes(part) for part in parts]

    def has(self, key: str) -> bool:
        try:
            obstore.head(self._store, key)
        except FileNotFoundError:
            return False
        return True

    def size(self, key: str) -> int:
        """Bytes under `key`. Raises `FileNotFoundError`."""
        return obstore.head(self._store, key)["size"]

    def delete(self, *keys: str) -> None:
        """Remove what is there of `keys`."""
        for key in keys:
            with suppress(FileNotFoundError):
                obstore.delete(self._store, key)

    def keys(self, prefix: str) -> Iterator[str]:
        for page in obstore.list(self._store, prefix):
            for blob in page:
                yield blob["path"]

    def folders(self, prefix: str) -> list[str]:
        """The names one level below `prefix`."""
        listing = obstore.list_with_delimiter(self._store, prefix)
        return [path.rsplit("/", 1)[-1] for path in listing["common_prefixes"]]

    def delete_all(self, prefix: str) -> None:
        """Remove everything below the folder `prefix`."""
        self.delete(*self.keys(prefix))
        if self.folder:
            self._remove_fragments(self.folder / prefix)

    async def upload(self, digest: str, chunks: AsyncIterator[bytes], limit: int) -> bool:
        """Store the asset `digest` (SHA-256, hex) from a stream, without holding it in memory.

        Returns whether it is new. Nothing is visible under its name before every byte was checked. Raises `Mismatch`
        where the bytes have another digest, and `TooLarge` beyond `limit` bytes.
        """
        key, upload = asset_key(digest), f"uploads/{secrets.token_hex(16)}"
        new = not self.has(key)
        hasher = hashlib.sha256()
        received = 0

        async def checked() -> AsyncIterator[bytes]:
            nonlocal received
            async for chunk in chunks:
                received += len(chunk)
                if received > limit:
                    raise TooLarge(f"an asset may have {limit:,} bytes at most")
                hasher.update(chunk)
                if chunk:
                    yield chunk

        try:
            await obstore.put_async(self._store, upload, checked())
            if hasher.hexdigest() != digest:
                raise Mismatch(hasher.hexdigest())
            self._flush(upload)
            await obstore.rename_async(self._store, upload, key)
            self._flush(key)
        except BaseException:
            self.delete(upload)
            raise
        return new

    def _flush(self, key: str) -> None:
        if self.folder is None:
            return
        path = self.folder / key
        for entry in (path, path.parent):
            descriptor = os.open(entry, os.O_RDONLY)
            try:
                os.fsync(descriptor)
            finally:
                os.close(descriptor)

    @staticmethod
    def _remove_fragments(folder: Path) -> None:
        # A local put writes "name#1" and renames it; a kill in between leaves the fragment, which no listing shows.
        if not folder.is_dir():
            return
        for path in sorted(folder.rglob("*"), reverse=True):
            with suppress(OSError):
                path.rmdir() if path.is_dir() else path.unlink()
        with suppress(OSError):
            folder.rmdir()


def cannot_keep(url: str, error: Exception) -> CannotStart:
    """What to say where the place cannot be used: one line."""
    return CannotStart(f"cannot keep blobs at {url}: {' '.join(str(error).splitlines()[0].split())[:300]}")


def scene_key(digest: str) -> str:
    return f"scenes/{digest}.json"


def database_key() -> str:
    return "database"


def asset_key(digest: str) -> str:
    return f"assets/{digest}"


def job_prefix(job: str) -> str:
    return f"jobs/{job}"


def tile_key(job: str, index: int, version: int) -> str:
    return f"jobs/{job}/tiles/{index}-{version}"


def pixels_key(job: str) -> str:
    return f"jobs/{job}/pixels.npy"


def variance_key(job: str) -> str:
    return f"{job_prefix(job)}/variance.npy"


def first_hits_key(job: str) -> str:
    return f"{job_prefix(job)}/first-hits.npy"


def thumbnail_key(job: str) -> str:
    return f"jobs/{job}/thumbnail.png"
