"""Changes to nested dicts and lists that leave the rest as it is; what was given is not touched."""

from __future__ import annotations

from collections.abc import Callable
from random import Random
from typing import Any

from hostile_values import leaf, number, text

Tree = Any
Path = tuple[Any, ...]

# 30 joints are more than any arm; with hundreds a case takes seconds for good reasons.
MOST_REPEATED = 30


def changed_at(tree: Tree, path: Path, change: Callable[[Tree], Tree]) -> Tree:
    """A tree with what stands at a path replaced by what `change` makes of it."""
    if not path:
        return change(tree)
    copy = dict(tree) if isinstance(tree, dict) else list(tree)
    copy[path[0]] = changed_at(tree[path[0]], path[1:], change)
    return copy


def at(tree: Tree, path: Path) -> Tree:
    for key in path:
        tree = tree[key]
    return tree


def some_path(random: Random, tree: Tree) -> Path:
    """A place in a tree: a walk from its root, that mostly goes on to a leaf."""
    path: list[Any] = []
    while isinstance(tree, dict | list) and tree and (not path or random.randrange(8)):
        path.append(random.choice(list(tree)) if isinstance(tree, dict) else random.randrange(len(tree)))
        tree = tree[path[-1]]
    return tuple(path)


def _somewhere(change: Callable[[Random, Tree, Path], Tree]) -> Callable[[Random, Tree], Tree]:
    """The same change at some place; a tree without any becomes a leaf."""

    def changed(random: Random, tree: Tree) -> Tree:
        path = some_path(random, tree)
        return change(random, tree, path) if path else leaf(random)

    return changed


def _replace(random: Random, tree: Tree, path: Path) -> Tree:
    return changed_at(tree, path, lambda _: leaf(random))


def _renumber(random: Random, tree: Tree, path: Path) -> Tree:
    """Another number where one was, so that what checks kinds lets it pass."""
    return changed_at(tree, path, lambda old: _with_numbers(old, lambda _: number(random)))


def _scale(random: Random, tree: Tree, path: Path) -> Tree:
    """The same numbers in another unit, with another sign, or a little off."""
    factor = random.choice([-1, 0, 1000, 1e-3, 57.29577951308232, 1e150, 1e-150, 1 + 1e-9, 1.01])
    return changed_at(tree, path, lambda old: _with_numbers(old, lambda x: float(x) * factor))


def _with_numbers(tree: Tree, change: Callable[[Any], Any]) -> Tree:
    if isinstance(tree, list):
        return [_with_numbers(item, change) for item in tree]
    if isinstance(tree, dict):
        return {key: _with_numbers(item, change) for key, item in tree.items()}
    if isinstance(tree, bool) or not isinstance(tree, int | float) or abs(tree) > 1e150:
        return tree
    return change(tree)


def _remove(random: Random, tree: Tree, path: Path) -> Tree:
    def without(container: Tree) -> Tree:
        if isinstance(container, dict):
            return {key: value for key, value in container.items() if key != path[-1]}
        return container[: path[-1]] + container[path[-1] + 1 :]

    return changed_at(tree, path[:-1], without)


def _repeat(random: Random, tree: Tree, path: Path) -> Tree:
    """An item of a list once more or many times; of a dict, under another name."""
    times, name = random.choice([2, 2, 2, 7, MOST_REPEATED]), text(random)

    def with_more(container: Tree) -> Tree:
        if isinstance(container, dict):
            return container | {name: container[path[-1]]}
        return container[: path[-1]] + [container[path[-1]]] * times + container[path[-1] + 1 :]

    return changed_at(tree, path[:-1], with_more)


def _rename(random: Random, tree: Tree, path: Path) -> Tree:
    key = path[-1]
    if not isinstance(key, str):
        return _swap(random, tree, path)
    near = [key.upper(), *(key + end for end in ("s", "_deg", "_mm")), key[:-1], key.removesuffix("_deg")]
    name = random.choice([*near, text(random)])

    def renamed(old: Tree) -> Tree:
        return {(name if k == key else k): value for k, value in old.items()}

    return changed_at(tree, path[:-1], renamed)


def _swap(random: Random, tree: Tree, path: Path) -> Tree:
    """The values of two neighbours exchanged."""
    container = at(tree, path[:-1])
    neighbour = random.choice(list(container) if isinstance(container, dict) else range(len(container)))
    value, new_value = container[path[-1]], container[neighbour]
    return changed_at(changed_at(tree, path, lambda _: new_value), (*path[:-1], neighbour), lambda _: value)


def _graft(random: Random, tree: Tree, path: Path) -> Tree:
    """What stands somewhere else, here."""
    return changed_at(tree, path, lambda _: at(tree, some_path(random, tree)))


def _wrap(random: Random, tree: Tree, path: Path) -> Tree:
    depth, key = random.choice([1, 1, 2, 30]), random.randrange(2)

    def nested(value: Tree) -> Tree:
        for _ in range(depth):
            value = {"a": value} if key else [value]
        return value

    return changed_at(tree, path, nested)


TREE_CHANGES = {
    change.__name__.lstrip("_"): _somewhere(change)
    for change in (_replace, _renumber, _scale, _remove, _repeat, _rename, _swap, _graft, _wrap)
}
