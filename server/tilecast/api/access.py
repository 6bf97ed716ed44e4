"""What the calls find at hand: the manager, the user; and who may change anything."""

from typing import Annotated

from fastapi import Depends, Request

from tilecast.api.problems import Problem
from tilecast.jobs import manager as jobs


def _manager(request: Request) -> jobs.Manager:
    return request.app.state.manager


def _user(request: Request) -> str:
    """Who asks: the name that a trusted proxy gave, or the address. Decides limits and fairness, and nothing else."""
    header = request.app.state.settings.user_header
    name = request.headers.get(header) if header else None
    return (name or (request.client.host if request.client else "local"))[:255]


def same_site(request: Request) -> None:
    """Refuse what a page of another site makes a browser send: there are no passwords that would stop it."""
    if request.headers.get("sec-fetch-site") in ("cross-site", "same-site"):
        raise Problem("Another site", "cross-site", "Pages of other sites may not change anything here.", 403)


Manager = Annotated[jobs.Manager, Depends(_manager)]
User = Annotated[str, Depends(_user)]
