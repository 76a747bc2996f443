"""Large neighbourhood search for an arrangement with fewer operations, as extraction alone stops too early.

Some neighbouring variables are inlined, terms are rewritten at random in ways that cost nothing, and
extraction starts again from there. A result with more operations is undone.
"""

from __future__ import annotations

from collections.abc import Mapping
from random import Random

from gd_analyze.operations.extraction import extract
from gd_analyze.operations.sums import Sums, multiplications, over, times, without

# These settings of a try are the best of those tested on models of the built-in arms. Accepting more
# operations for some time gained nothing.

# Numbers of variables to inline, one of which is drawn.
_INLINED = (1, 1, 2, 2, 3, 4, 6)
# Largest random gains in the following extraction, operations, one of which is drawn.
_NOISES = (0.3, 0.9, 1.5)
# Probability that all variables to inline are neighbours of the first.
_NEIGHBOURS_PROBABILITY = 0.7
# Probability of each way to rewrite terms.
_REWRITING_PROBABILITY = 0.5
# Tries per operation without gain, after which the search stops.
_PATIENCE_PER_OPERATION = 5


def rearrange(sums: Sums, tries: int, circles: Mapping[int, int], seed: int = 0) -> None:
    """Search an arrangement of extracted sums with fewer operations; the sums are changed in place.

    `circles` maps inputs to partners whose squares add up to 1: a cosine and the sine of its angle.
    """
    random = Random(seed)
    least, patience = sums.operations, 0
    sums.mark()
    for _ in range(tries):
        patience += 1
        if patience > _PATIENCE_PER_OPERATION * least:
            return
        _put_back(sums, random)
        for rewrite in (_rescale_term, _rescale_variable, _fold, _use_circle):
            if random.random() < _REWRITING_PROBABILITY:
                sums.tidy()
                rewrite(sums, circles, random)
        extract(sums, random, random.choice(_NOISES))
        if sums.operations <= least:
            patience = patience if sums.operations == least else 0
            least = sums.operations
            sums.mark()
        else:
            sums.undo()


def _put_back(sums: Sums, random: Random) -> None:
    """Inline some variables, most often neighbours that share a sum."""
    defined = sums.defined
    if not defined:
        return
    first, count = random.choice(defined), random.choice(_INLINED)
    near = {first, *(x for m in sums.terms[first] for x in m)}
    for user in sums.users[first]:
        near |= {user, *(x for m in sums.terms[user] for x in m)}
    pool = defined
    if random.random() < _NEIGHBOURS_PROBABILITY:
        pool = [v for v in defined if v in near]
    for v in dict.fromkeys([first, *random.sample(pool, min(count - 1, len(pool)))]):
        sums.inline(v)


def _use_circle(sums: Sums, circles: Mapping[int, int], random: Random) -> None:
    """Replace the x^2 of one term by 1 - y^2."""
    squares = [
        (v, m, x)
        for v, terms in sums.terms.items()
        for m in terms
        for x in dict.fromkeys(m)
        if x in circles and m.count(x) > 1
    ]
    if squares:
        v, m, x = random.choice(squares)
        c = sums.terms[v][m]
        cofactor = without(without(m, x), x)
        sums.put(v, m, 0.0)
        sums.add(v, cofactor, c)
        sums.add(v, times(cofactor, (circles[x], circles[x])), -c)


def _fold(sums: Sums, _: Mapping[int, int], random: Random) -> None:
    """Replace w x + c y by w v + (c - w) y where v = x + y is defined; at best no remainder is left."""
    several = [v for v, terms in sums.terms.items() if len(terms) > 1]
    if not several:
        return
    v = random.choice(several)
    inside = dict(sums.terms[v])
    shortest = min(inside, key=len)
    # A sum that contains all terms of v cannot be part of v, so definitions stay acyclic.
    places = []
    for user in dict.fromkeys(user for m in inside for x in m for user in sums.users[x]):
        for m in sums.terms[user]:
            beside = over(m, shortest)
            if beside is None or user == v:
                continue
            if all(times(beside, inner) in sums.terms[user] for inner in inside):
                places.append((user, beside))
    if places:
        user, beside = random.choice(places)
        gone = random.choice(list(inside))
        w = sums.magnitude(sums.terms[user][times(beside, gone)] / inside[gone])
        if v < 0:
            output, v = v, sums.define(inside)
            for m in inside:
                sums.put(output, m, 0.0)
            sums.put(output, (v,), 1.0)
        for m, c in inside.items():
            sums.add(user, times(beside, m), -sums.magnitude(w * c))
        sums.add(user, times(beside, (v,)), w)


def _rescale_term(sums: Sums, _: Mapping[int, int], random: Random) -> None:
    """Replace a term c x .. by (c / d) v .. where v = d x is defined: (c / d) v .. may already exist."""
    uses = []
    for v in sums.defined:
        if len(sums.terms[v]) == 1:
            ((product, d),) = sums.terms[v].items()
            if abs(d) == 1.0:
                continue
            for user in sums.users[product[0]]:
                if user == v:
                    continue
                for m, c in sums.terms[user].items():
                    beside = over(m, product) if abs(c) != 1.0 else None
                    if beside is not None:
                        uses.append((v, d, user, m, beside))
    if uses:
        v, d, user, m, beside = random.choice(uses)
        c = sums.terms[user][m]
        sums.put(user, m, 0.0)
        sums.add(user, times(beside, (v,)), sums.magnitude(c / d))


def _rescale_variable(sums: Sums, _: Mapping[int, int], random: Random) -> None:
    """Define a variable with another factor where that costs nothing."""
    defined = sums.defined
    if not defined:
        return
    v = random.choice(defined)
    inside = list(sums.terms[v].items())
    uses = [(user, m, c) for user in sums.users[v] for m, c in sums.terms[user].items() if v in m]
    if any(m.count(v) > 1 for _, m, _ in uses):
        return
    magnitude = sums.magnitude

    def cost(factor: float) -> int:
        within = sum(multiplications(m, magnitude(c * factor)) for m, c in inside)
        return within + sum(multiplications(m, magnitude(c / factor)) for _, m, c in uses)

    factors = {abs(1.0 / c) for _, c in inside} | {abs(c) for _, _, c in uses}
    free = [factor for factor in sorted(factors - {1.0}) if cost(factor) <= cost(1.0)]
    if free:
        factor = random.choice(free)
        for m, c in inside:
            sums.put(v, m, magnitude(c * factor))
        for user, m, c in uses:
            sums.put(user, m, magnitude(c / factor))
