"""The page at /docs: every call, from the OpenAPI document. Without a script: a usual viewer would load its own from other
hosts, into a page that may change everything here."""

from html import escape

from fastapi import FastAPI
from fastapi.responses import HTMLResponse

_PAGE = """<!doctype html>
<html lang="en"><meta charset="utf-8"><meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="color-scheme" content="light dark"><title>{title}: HTTP interface</title>
<link rel="icon" href="/web/icon.svg"><link rel="stylesheet" href="/web/base.css">
<main><h1>{title}: HTTP interface</h1>
<p>{about}</p>
<p>For programs: <a href="/openapi.json">OpenAPI</a>, with all models, and the <a href="/v1/schema">JSON Schema</a> of a
scene. <a href="/">The jobs.</a></p>
{calls}</main></html>"""


def add_description(app: FastAPI) -> None:
    """Answer /docs."""

    @app.get("/docs", include_in_schema=False)
    def describe() -> HTMLResponse:
        document = app.openapi()
        calls = "".join(
            _call(method, path, call) for path, methods in document["paths"].items() for method, call in methods.items()
        )
        about = _paragraphs(document["info"].get("description", ""))
        return HTMLResponse(_PAGE.format(title=escape(app.title), about=about, calls=calls))


def _call(method: str, path: str, call: dict) -> str:
    taken = "".join(
        f"<li><code>{escape(each['name'])}</code> ({escape(each['in'])}{', required' if each.get('required') else ''}) "
        f"{escape(each.get('description', ''))}</li>"
        for each in call.get("parameters", [])
    )
    body = call.get("requestBody", {})
    if body:
        taken += f"<li>body: {escape(', '.join(body['content']))} {escape(body.get('description', ''))}</li>"
    given = "".join(
        f"<li>{escape(status)}: {escape(answer.get('description', ''))} {escape(', '.join(answer.get('content', {})))}</li>"
        for status, answer in call["responses"].items()
    )
    return (
        f"<section><h2><code>{method.upper()} {escape(path)}</code></h2><p>{_paragraphs(call.get('description', ''))}</p>"
        f"<h3>Takes</h3><ul>{taken or '<li>nothing more</li>'}</ul><h3>Answers</h3><ul>{given}</ul></section>\n"
    )


def _paragraphs(text: str) -> str:
    return escape(text).replace("\n\n", "</p><p>")
