"""The long run: `python tests/fuzz/run.py --cases 100000 csv log toml xml json`; `--help` says more."""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

from hypothesis import HealthCheck, Phase, given, seed, settings

# The tests' own helpers, as pytest finds them.
sys.path.insert(0, str(Path(__file__).parents[1] / "helpers"))

from changes import Plan
from fuzz_formats import FORMATS
from verdict import BrokenError

# Hypothesis remembers what it tried; beyond some thousand examples that takes longer than the cases.
BATCH = 1000
Cause = tuple[str, str]


class Run:
    """What of one format was read, refused and found; the smallest file of every cause is kept."""

    def __init__(self, name: str, folder_of_faults: Path, case: Path) -> None:
        self.name, self.folder_of_faults, self.case = name, folder_of_faults, case
        self.format = FORMATS[name]
        self.outcomes: Counter[str] = Counter()
        self.causes: dict[Cause, str] = {}
        self.times: Counter[Cause] = Counter()
        self._plan: Plan | None = None
        self._shrinking = False

    def batch(self, number: int, cases: int) -> None:
        """Try so many cases; the same number draws the same ones."""

        @seed(number)
        @settings(
            max_examples=cases,
            database=None,
            deadline=None,
            phases=(Phase.generate, Phase.shrink),
            suppress_health_check=list(HealthCheck),
            report_multiple_bugs=False,
        )
        @given(self.format.cases)
        def held(plan: Plan) -> None:
            self._hold(plan)

        before = Counter(self.outcomes), Counter(self.times)
        while True:
            self._shrinking = False
            self.outcomes, self.times = map(Counter, before)
            try:
                return held()
            except BrokenError as error:  # shrunk; the rest of the batch is tried again without it
                self._keep(error)

    def _hold(self, plan: Plan) -> None:
        self._plan = plan
        self.format.write(plan, self.case)
        try:
            outcome = "read" if self.format.judged(self.case) else "refused"
        except BrokenError as error:
            self.times[error.cause] += not self._shrinking
            if error.cause not in self.causes:
                if error.cause[0] == "TooSlowError":
                    self._keep(error)  # shrinking would take as long for every attempt
                else:
                    self._shrinking = True
                    raise
            outcome = "broken"
        self.outcomes[outcome] += not self._shrinking

    def _keep(self, error: BrokenError) -> None:
        """Note a cause and keep the file at hand: after shrinking, Hypothesis ends with the smallest."""
        number = len(self.causes) + 1
        path = self.folder_of_faults / f"{self.name}-{number}.{self.name}"
        path.write_bytes(self.case.read_bytes())
        self.causes[error.cause] = error.detail
        print(f"{self.name}: {error.cause[0]} at {error.cause[1]}, kept in {path}", flush=True)
        print(f"    {self._plan}", flush=True)
        print(f"    {error.detail[:300]!r}", flush=True)


def run(name: str, cases: int, first: int, folder_of_faults: Path) -> bool:
    """Run one format, saying how far it is; whether nothing was found."""
    memory, started = Path("/dev/shm"), time.monotonic()
    with tempfile.TemporaryDirectory(dir=memory if memory.is_dir() else None) as folder:
        fuzzing = Run(name, folder_of_faults, Path(folder) / f"case.{name}")
        for start in range(0, cases, BATCH):
            fuzzing.batch(first + start // BATCH, min(BATCH, cases - start))
            counts = ", ".join(f"{count} {outcome}" for outcome, count in fuzzing.outcomes.items())
            tried = sum(fuzzing.outcomes.values())
            rate = tried / (time.monotonic() - started)
            print(f"{name}: {tried} of {cases} cases, {rate:.0f}/s: {counts}", flush=True)
    for cause, times in fuzzing.times.most_common():
        print(f"{name}: {times} x {cause[0]} at {cause[1]}")
    return not fuzzing.causes


def main() -> None:
    parser = argparse.ArgumentParser(description="Read many changed files; see tests/fuzz/verdict.py.")
    parser.add_argument("formats", nargs="*", choices=[*FORMATS, []], help="all by default")
    parser.add_argument("--cases", type=int, default=100_000, help="of each format")
    parser.add_argument("--first", type=int, default=0, help="number of the first batch of 1000")
    parser.add_argument("--found", type=Path, help="folder for files that break the property")
    arguments = parser.parse_args()
    folder_of_faults = arguments.found or Path(tempfile.mkdtemp(prefix="gd-analyze-fuzz-"))
    folder_of_faults.mkdir(parents=True, exist_ok=True)
    sound = [
        run(name, arguments.cases, arguments.first, folder_of_faults) for name in arguments.formats or FORMATS
    ]
    sys.exit(0 if all(sound) else 1)


if __name__ == "__main__":
    main()
