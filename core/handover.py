"""What a forked child hands to its parent: what both had before the fork goes as a reference.

A fit holds the takes that it is of, and effects with hooks that no pickle can hold. What was there
when the child was forked is the same to both: it goes as a number and comes back as the very same
object. A function that was made since goes as its code, which both have, and what it encloses.
"""

import io
import pickle
import sys
from collections.abc import Iterable
from dataclasses import fields, is_dataclass
from functools import cached_property, lru_cache, partial
from importlib import import_module
from types import CellType, CodeType, FunctionType, MethodType

import numpy as np

PACKAGE = __name__.rpartition(".")[0]
KEPT = CodeType, FunctionType, np.ndarray


class Known:
    """All that is reached from the `roots`, and from the modules of this package, as it is now.

    Code, functions, arrays and frozen nouns go as references: nobody changes these any more.
    """

    def __init__(self, roots: Iterable):
        loaded = frozenset(filter(_is_ours, list(sys.modules)))
        objects, seen = _of_the_package(loaded)
        self.objects = dict(objects)
        _reached(roots, self.objects, dict(seen))

    def packed(self, result) -> bytes:
        """The result, as it travels. Raises what `pickle` does."""
        file = io.BytesIO()
        _Pickler(file, self.objects).dump(result)
        return file.getvalue()

    def unpacked(self, sent: bytes):
        """The result again."""
        return _Unpickler(io.BytesIO(sent), self.objects).load()


@lru_cache(maxsize=1)
def _of_the_package(loaded: frozenset) -> tuple[dict, dict]:
    """What is reached from these modules, by what it is known by: it stays as it is. To look again
    would take longer than many a job.
    """
    objects, seen = {}, {}
    _reached([vars(sys.modules[name]) for name in loaded], objects, seen)
    return objects, seen


def _reached(roots: Iterable, objects: dict, seen: dict) -> None:
    """Put all that is reached from the roots into `seen`, of that what goes as a reference into
    `objects`.
    """
    todo = [*roots]
    while todo:
        one = todo.pop()
        if id(one) in seen:
            continue
        seen[id(one)] = one
        if isinstance(one, KEPT) or (_is_noun(one) and one.__dataclass_params__.frozen):
            objects[id(one)] = one
        todo += _made_of(one)


def _is_ours(name: str) -> bool:
    return name == PACKAGE or name.startswith(PACKAGE + ".")


def _is_noun(one) -> bool:
    return is_dataclass(one) and not isinstance(one, type)


def _made_of(one) -> Iterable:
    """What an object is made of, as far as something may be in it that does not pickle."""
    if isinstance(one, FunctionType):
        defaults = *(one.__defaults__ or ()), *(one.__kwdefaults__ or {}).values()
        return one.__code__, *defaults, *_enclosed(one)
    if isinstance(one, CodeType):
        return [part for part in one.co_consts if isinstance(part, CodeType)]
    if isinstance(one, partial):
        return one.func, *one.args, *one.keywords.values()
    if isinstance(one, MethodType):
        return one.__self__, one.__func__
    if isinstance(one, staticmethod | classmethod):
        return (one.__func__,)
    if isinstance(one, property | cached_property):
        return (one.fget if isinstance(one, property) else one.func,)
    if isinstance(one, type):
        return vars(one).values() if _is_ours(one.__module__) else ()
    if isinstance(one, dict):
        return [*one, *one.values()]
    if isinstance(one, list | tuple | set | frozenset):
        return one
    return [getattr(one, field.name) for field in fields(one)] if _is_noun(one) else ()


def _enclosed(function: FunctionType) -> list:
    """What its cells hold; one that is not filled yet holds nothing."""
    return [cell.cell_contents for cell in function.__closure__ or () if cell != CellType()]


class _Pickler(pickle.Pickler):
    def __init__(self, file, objects: dict):
        super().__init__(file, pickle.HIGHEST_PROTOCOL)
        self.objects = objects

    def persistent_id(self, one):
        return id(one) if id(one) in self.objects else None

    def reducer_override(self, one):
        if not isinstance(one, FunctionType) or "<" not in one.__qualname__:
            return NotImplemented
        said = one.__code__, one.__module__, one.__defaults__, one.__kwdefaults__
        return _function, (*said, tuple(cell.cell_contents for cell in one.__closure__ or ()))


def _function(code: CodeType, module: str, defaults, by_name, enclosed: tuple) -> FunctionType:
    cells = tuple(CellType(one) for one in enclosed)
    made = FunctionType(code, vars(import_module(module)), code.co_name, defaults, cells)
    made.__kwdefaults__ = by_name
    return made


class _Unpickler(pickle.Unpickler):
    def __init__(self, file, objects: dict):
        super().__init__(file)
        self.objects = objects

    def persistent_load(self, pid):
        return self.objects[pid]
