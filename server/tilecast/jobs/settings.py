"""Settings of the service: from `TILECAST_...` in the environment, or from the command line, which wins."""

import os
from pathlib import Path
from typing import Annotated

import limits
from pydantic import AfterValidator, Field
from pydantic_settings import BaseSettings, SettingsConfigDict


def default_folder() -> Path:
    """Where a user's data go by the XDG convention."""
    base = os.environ.get("XDG_DATA_HOME") or "~/.local/share"
    return Path(base).expanduser() / "tilecast"


def _rate(text: str) -> str:
    limits.parse(text)  # raises ValueError
    return text


class Settings(BaseSettings):
    """Everything that can be set, with what is set where nobody says otherwise."""

    model_config = SettingsConfigDict(env_prefix="TILECAST_", use_attribute_docstrings=True)

    host: str = "127.0.0.1"
    """Address to listen on. There are no passwords: open it to trusted networks only."""
    port: int = Field(8000, ge=0, le=65535)
    data: Path = Field(default_factory=default_folder)
    """Folder for everything that has to outlive the server."""
    database: str | None = None
    """SQLAlchemy URL; by default SQLite in the data folder. postgresql+psycopg://user:password@host/name"""
    blobs: str | None = None
    """Place of the large files; by default in the data folder. s3://bucket/prefix"""
    scheduler: str | None = Field(None, pattern=r"^[a-z]+://.+")
    """Address of a running Dask scheduler, tcp://host:8786; by default a cluster on this machine."""
    threads: int | None = Field(None, ge=1, le=1024)
    """Threads of the cluster on this machine; by default one a core."""
    scenes: Path | None = None
    """Folder of the example scenes that the page offers; by default those that came with Tilecast."""
    user_header: str | None = None
    """Header in which a trusted proxy names the user; by default a user is an address."""
    callbacks: bool = True
    """Whether jobs may name an address to be told when they end."""

    max_body: int = Field(16 * 2**20, ge=1)
    """Bytes of a request's body. Large meshes belong into assets."""
    max_asset: int = Field(512 * 2**20, ge=1)
    """Bytes of an asset."""
    max_pixels: int = Field(2**25, ge=1)
    """Pixels of an image; 8K just fits."""
    max_samples: int = Field(2**16, ge=1)
    """Samples of a pixel."""
    max_depth: int = Field(1024, ge=1)
    """Segments of a light path."""
    max_triangles: int = Field(20_000_000, ge=1)
    """Triangles that a scene loads, before instances multiply them."""
    max_jobs: int = Field(100, ge=1)
    """Jobs of one user that have not ended."""
    max_submissions: Annotated[str, AfterValidator(_rate)] = "600/minute"
    """Submissions of one user in a window of time."""
    check_seconds: float = Field(10.0, ge=0)
    """How long a submission waits for its scene to be compiled before it is accepted without."""
    stuck_seconds: float = Field(30.0, ge=0)
    """How long a chunk may go on whose job was paused or has ended, before its worker process is restarted."""

    @property
    def database_url(self) -> str:
        return self.database or f"sqlite:///{self.data.absolute() / 'tilecast.db'}"

    @property
    def blobs_url(self) -> str:
        return self.blobs or (self.data.absolute() / "blobs").as_uri()
