"""How the generators write a scene: beside the others, one member or instance a line."""

import json
from pathlib import Path

FOLDER = Path(__file__).resolve().parent.parent


def _lines(value, indent: int, depth: int) -> str:
    numbers = isinstance(value, list) and value and isinstance(value[0], list)  # vertices, faces, matrices
    if depth == 0 or numbers or not isinstance(value, (dict, list)) or not value:
        return json.dumps(value, separators=(",", ":") if numbers else None)
    pad = " " * (indent + 2)
    if isinstance(value, dict):
        items = [f"{json.dumps(key)}: {_lines(item, indent + 2, depth - 1)}" for key, item in value.items()]
        return "{\n" + ",\n".join(pad + item for item in items) + "\n" + " " * indent + "}"
    items = [_lines(item, indent + 2, depth - 1) for item in value]
    return "[\n" + ",\n".join(pad + item for item in items) + "\n" + " " * indent + "]"


def write(name: str, scene: dict) -> None:
    path = FOLDER / f"{name}.json"
    text = "{\n" + ",\n".join(
        f"  {json.dumps(key)}: {_lines(value, 2, 4 if key == 'objects' else 1 if key in ('materials', 'scene', 'lights') else 0)}"
        for key, value in scene.items()) + "\n}\n"
    path.write_text(text)
    print(path)
