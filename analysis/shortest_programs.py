"""The exact programs of the shipped arms, in the fewest operations that a long search finds.

The torque is rearranged from the recursion, with other random choices each time, and the best again and again; with
drives from what was found without. D, h and c follow from it, and are rearranged likewise.
Writes `data/programs/`; takes some minutes an arm: `python analysis/shortest_programs.py [ARM ...]`.
"""

from __future__ import annotations

import json
import sys

from gd_analyze.files import data_folder, write_text
from gd_analyze.operations.program import Program, fewest, plain_program
from gd_analyze.operations.sharing import rewritten
from gd_analyze.operations.trace import Trace
from gd_analyze.robots.catalogue import load_arm
from gd_analyze.simplification.exact import ExactForm, functions_to_rewrite, shipped_name

# Those whose programs a second or two do not find.
ARMS = ("puma560", "stanford")
# How much longer than usual each rearrangement goes on, and how many there are of either kind.
LONGER, ROUNDS = 10, 12


def shortest(start: Program, name: str) -> Program:
    """Search for a program of fewer operations."""
    starts = [rewritten(start, LONGER, seed) for seed in range(ROUNDS)]
    best = fewest(starts)
    for seed in range(ROUNDS, 2 * ROUNDS):
        best = rewritten(best, LONGER, seed)
        print(name, seed, best.count, flush=True)
    return best


def driven(links: Program, form: ExactForm) -> Program:
    """Add the torque of the drives' inertia to that of the links."""
    trace, inertia = Trace(), form.drive_inertia
    assert inertia is not None
    of = links.folded(trace, {})
    qdd = trace.inputs("qdd", len(inertia))[:, 0]
    return Program.of(trace, [of(x) + d * a for x, d, a in zip(links.outputs, inertia, qdd, strict=True)])


def main() -> None:
    """Search those of the arms named, or of all."""
    for name in sys.argv[1:] or ARMS:
        arm = load_arm(name)
        torque = ExactForm(arm).recursion
        for drives in sorted({False, arm.counts_drives(None)}):
            form = ExactForm(arm, drives)
            torque = shortest(driven(torque, form) if drives else torque, shipped_name(form))
            functions = functions_to_rewrite(form, torque)._asdict()
            programs = {"torque": torque} | {
                quantity: shortest(program, f"{shipped_name(form)}, {quantity}")
                for quantity, program in functions.items()
            }
            plain = {quantity: plain_program(program) for quantity, program in programs.items()}
            write_text(data_folder("programs") / f"{shipped_name(form)}.json", json.dumps(plain) + "\n")


if __name__ == "__main__":
    main()
