"""Write the TypeScript types of the page's requests and replies: ``python typescript.py``.

They are made from the description of the interface (OpenAPI), which comes from the dataclasses of
the replies. The written file is committed, because the build of the page has Node but not the
dependencies of motiondb; a test compares it with the description.
"""

from __future__ import annotations

import json
import tempfile
from pathlib import Path
from typing import Any

TYPES = Path(__file__).parent / "src" / "api" / "types.ts"
HEAD = "/** Types of requests and replies, written by ../../typescript.py. Times in seconds. */\n"
METHODS = {"get": "Got", "post": "Posted", "put": "Put", "delete": "Deleted"}
"""The interfaces of the replies to each method."""
_PLAIN = {"string": "string", "number": "number", "integer": "number", "boolean": "boolean"}

Schema = dict[str, Any]


def type_of(schema: Schema) -> str:
    """Return a schema as a type.

    >>> type_of({"anyOf": [{"type": "array", "items": {"type": "integer"}}, {"type": "null"}]})
    'number[] | null'
    """
    if "$ref" in schema:
        return str(schema["$ref"]).rpartition("/")[2]
    if "anyOf" in schema:
        return " | ".join(type_of(part) for part in schema["anyOf"])
    if "const" in schema or "enum" in schema:
        values = schema.get("enum", [schema.get("const")])
        return " | ".join(json.dumps(value) for value in values)
    kind = schema.get("type")
    if kind == "array" and "prefixItems" in schema:
        return f"[{', '.join(type_of(item) for item in schema['prefixItems'])}]"
    if kind == "array":
        item = type_of(schema["items"])
        return f"({item})[]" if " | " in item else f"{item}[]"
    if kind == "object":
        values = schema.get("additionalProperties")
        return f"Record<string, {type_of(values) if isinstance(values, dict) else 'unknown'}>"
    return "null" if kind == "null" else _PLAIN.get(str(kind), "unknown")


def interface(name: str, schema: Schema) -> str:
    """Return an object as an interface.

    Replies have all of their fields. Requests may lack those with a default.
    """
    is_request = name.endswith("Body") or name == "Part"
    required = schema.get("required", ()) if is_request else schema.get("properties", {})
    fields = "".join(
        f"  {key}{'' if key in required else '?'}: {type_of(field)};\n"
        for key, field in schema.get("properties", {}).items()
    )
    return f"export interface {name} {{\n{fields}}}\n"


def types_of(description: Schema) -> str:
    """Return the types of a description of the interface."""
    schemas = description["components"]["schemas"]
    parts = [interface(name, schema) for name, schema in sorted(schemas.items())]
    asked = [
        interface(name, {"properties": replies(method, description)})
        for method, name in METHODS.items()
    ]
    return "\n".join([HEAD, *parts, *asked])


def replies(method: str, description: Schema) -> Schema:
    """Return the replies to a method, by the paths that are asked."""
    return {
        f'"{path}"': reply["content"]["application/json"]["schema"]
        for path, asked in sorted(description["paths"].items())
        for code, reply in asked.get(method, {}).get("responses", {}).items()
        if code[0] == "2" and "application/json" in reply.get("content", {})
    }


def describe() -> Schema:
    """Return the description of the interface."""
    from motiondb.page.app import make_application
    from motiondb.page.settings import PageSettings

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder)
        application = make_application(PageSettings(path / "none.duckdb", warm=False), path, path)
        description: Schema = application.openapi()
        application.state.page.close()
    return description


if __name__ == "__main__":
    TYPES.write_text(types_of(describe()), encoding="utf-8")
