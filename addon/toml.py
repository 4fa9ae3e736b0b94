"""A case as TOML text: tables, lists of tables, inline tables; nothing else occurs in one."""

import json


def dump(fields: dict) -> str:
    """Plain fields first, then tables and lists of tables in the order given."""
    plain = {k: v for k, v in fields.items() if not _is_table(v) and not _is_tables(v)}
    parts = ["".join(f"{key} = {_value(value)}\n" for key, value in plain.items())]
    for key, value in fields.items():
        if _is_table(value):
            parts.append(_table(f"[{key}]", value))
        elif _is_tables(value):
            parts.extend(_table(f"[[{key}]]", one) for one in value)
    return "\n".join(parts)


def _table(head: str, fields: dict) -> str:
    return "\n".join([head, *(f"{key} = {_value(value)}" for key, value in fields.items()), ""])


def _value(value) -> str:
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{key} = {_value(one)}" for key, one in value.items()) + " }"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(_value(one) for one in value) + "]"
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, bool):
        return "true" if value else "false"
    return repr(value)


def _is_table(value) -> bool:
    return isinstance(value, dict)


def _is_tables(value) -> bool:
    return isinstance(value, list) and bool(value) and all(isinstance(one, dict) for one in value)
