"""`tilecast schema`: the scene format as JSON Schema."""

from __future__ import annotations

import json

import typer


def schema() -> None:
    """Print the JSON Schema of a scene."""
    from ..scene import schema_json
    typer.echo(json.dumps(schema_json(), indent=2))
