"""Kinds of words in a command: how they are checked and completed, and the options that verbs share."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, TypeVar

import click
from click.shell_completion import CompletionItem

import gd_analyze as gd
from gd_analyze.cli.other_words import in_place_of
from gd_analyze.errors import UsageError
from gd_analyze.files import shipped
from gd_analyze.text import LARGEST, LEVEL_NAMES
from gd_analyze.units import UNITS, Quantity

if TYPE_CHECKING:
    from gd_analyze.robots.parts import Link
    from gd_analyze.robots.uncertainty import StatedUncertainty

F = TypeVar("F", bound=Callable[..., Any])


def command_line() -> str:
    """What the user typed, as it can be pasted into a shell again."""
    return str(click.get_current_context().find_root().obj or "")


class NameOrFile(click.ParamType[str]):
    """A shipped name or a path, completed as both."""

    def __init__(self, name: str, kind: str, suffix: str) -> None:
        self.name = name
        self._kind, self._suffix = kind, suffix

    def path_of(self, word: str) -> Path:
        """Path of what a word names."""
        return shipped(self._kind, self._suffix).get(word, Path(word))

    def shell_complete(
        self, ctx: click.Context, param: click.Parameter | None, incomplete: str
    ) -> list[CompletionItem]:
        """Offer shipped names, and let the shell complete files."""
        names = [CompletionItem(n) for n in shipped(self._kind, self._suffix) if n.startswith(incomplete)]
        # The files come first: bash's script forgets what stood before the request for them.
        return [CompletionItem(incomplete, type="file"), *names]


class OutputPath(click.Path):
    """A file or folder to write."""

    def __init__(self) -> None:
        super().__init__(path_type=Path)

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Refuse the empty name, which would mean the current folder."""
        if value == "":
            self.fail("the name is empty", param, ctx)
        return super().convert(value, param, ctx)


class NameList(click.ParamType[tuple[str, ...]]):
    """Some of a few names, comma-separated."""

    name = "list"

    def __init__(
        self, names: tuple[str, ...], kind: str, said_for: Mapping[str, str] = MappingProxyType({})
    ) -> None:
        self.names, self._kind, self._said_for = names, kind, said_for

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> tuple[str, ...]:
        """Split and check; every name counts once. `said_for` has what to give in place of other words."""
        chosen = [entry.strip().lower() for entry in str(value).split(",")]
        for entry in chosen:
            if entry not in self.names:
                option = param.opts[0] if param is not None else None
                help_of_verb = f"see `{ctx.command_path} --help`" if ctx is not None else None
                raise UsageError(
                    f"there is no {self._kind} {entry!r}",
                    where=option,
                    expected=f"some of {', '.join(self.names)}",
                    next_step=in_place_of(entry, self.names, self._said_for) or help_of_verb,
                )
        return tuple(name for name in self.names if name in chosen)

    def shell_complete(
        self, ctx: click.Context, param: click.Parameter, incomplete: str
    ) -> list[CompletionItem]:
        """Offer the names that may follow the last comma."""
        earlier, comma, last = incomplete.rpartition(",")
        candidates = [name for name in self.names if name.startswith(last) and name not in earlier.split(",")]
        return [CompletionItem(earlier + comma + name) for name in candidates]


class Parsed(click.ParamType[Any]):
    """A value of the library, read from its text, whose errors are the library's: a budget, a margin."""

    def __init__(self, name: str, parse: Callable[[str], Any]) -> None:
        self.name, self._parse = name, parse

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Parse a text."""
        return self._parse(value) if isinstance(value, str) else value


def parse_budget(text: str) -> gd.types.Budget:
    """Read a budget."""
    from gd_analyze.simplification.budget import Budget

    return Budget.parse(text)


def parse_margin(text: str) -> gd.types.Margin:
    """Read a margin."""
    from gd_analyze.motions.margin import Margin

    return Margin.parse(text)


class Amount(click.ParamType[float]):
    """A number above 0 in SI, alone or with a unit of one kind: 5, 5Hz.

    Without a unit it must be of usual size, as it is probably in another unit else.
    """

    name = "number"

    def __init__(self, kind: str = "", least: float = 0.0, most: float = LARGEST) -> None:
        self._kind, self._least, self._most = kind, least, most

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        """Read it; click's own range lets nan and inf pass."""
        si = Quantity.si_of(value, self._kind)
        if si is None or not 0.0 < si <= LARGEST:
            unit = f", or with a unit such as {next(iter(UNITS[self._kind]))}" if self._kind else ""
            self.fail(f"{value!r} is not a number above 0 and up to {LARGEST:g}{unit}", param, ctx)
        bare = Quantity.read(value)
        if bare is not None and not bare.kind and not self._least <= si <= self._most:
            unit = next(iter(UNITS[self._kind])) if self._kind else ""
            hint = f": write {value}{unit} if it is meant" if unit else ""
            usual = f"{self._least:g} to {self._most:g} {unit}".rstrip()
            self.fail(f"{value} is not within {usual}{hint}", param, ctx)
        return si


class ShareAmount(click.ParamType[float]):
    """A share of 0 to 1, written 1% or 0.01."""

    name = "share"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        """Read it."""
        si = Quantity.si_of(value, "share")
        if si is None or not 0.0 <= si <= 1.0:
            self.fail(f"{value!r} is not a share of 0 to 1, such as 1% or 0.01", param, ctx)
        return si


def _uncertainty_in(text: str) -> StatedUncertainty:
    from gd_analyze.robots.uncertainty import StatedUncertainty

    return StatedUncertainty.parse(text)


def _payload_in(text: str) -> Link:
    from gd_analyze.robots.payload import parse_payload

    return parse_payload(text)


ROBOT = NameOrFile("robot", "robots", ".toml")
TRAJECTORY = NameOrFile("trajectory", "trajectories", ".csv")
FILE = click.Path(path_type=Path)


def together(*options: Callable[[F], F]) -> Callable[[F], F]:
    """Several options as one decorator, in the order of the help."""

    def decorate(function: F) -> F:
        for option in reversed(options):
            function = option(function)
        return function

    return decorate


def number(
    name: str, default: int | None, words: str, least: int = 0, most: int | None = None
) -> Callable[[F], F]:
    """An option that takes a whole number."""
    kind = click.IntRange(least, most)
    return click.option(name, type=kind, default=default, metavar="NUMBER", help=words)


def digits(words: str) -> Callable[[F], F]:
    """--digits, three by default; a double has no more than seventeen."""
    return click.option("--digits", type=click.IntRange(1, 17), default=3, help=words)


def out(words: str) -> Callable[[F], F]:
    """--out, a file or a folder."""
    return click.option("-o", "--out", type=OutputPath(), help=words)


def folder(
    words: str, names: tuple[str, ...] = ("html", "pdf", "json"), option: str = "--out"
) -> Callable[[F], F]:
    """--out or another option, a folder; --overwrite; --format, some of the files a verb writes there."""
    help_of_overwrite = "Replace another run in that folder."
    help_of_format = "Files to write, comma-separated."
    all_names = ",".join(names)
    kind = NameList(names, "format")
    folder_option = out(words) if option == "--out" else click.option(option, type=OutputPath(), help=words)
    return together(
        folder_option,
        click.option("--overwrite", is_flag=True, help=help_of_overwrite),
        click.option(
            "--format", "formats", type=kind, default=all_names, metavar="LIST", help=help_of_format
        ),
    )


# None where it is not given.
margin = click.option(
    "--margin",
    type=Parsed("margin", parse_margin),
    metavar="LIST",
    help="How far from the motion a bound holds: position of revolute and prismatic joints, shares of peak "
    "velocity and acceleration; those not named keep their default.  [default: 1deg,1mm,qd=2%,qdd=5%]",
)

# MODEL, a model.json.
model = click.argument("model", type=FILE, help="A model.json that gd-analyze wrote.")


_TRAJECTORY_WORDS = "CSV file, log (options: `gd-analyze columns --help`), shipped trajectory, "
DRAWN = "Without one, states are drawn within the arm's limits."


def trajectory(without: str = "") -> Callable[[F], F]:
    """TRAJECTORY, which may be left out where `without` says what happens then."""
    words = f"{_TRAJECTORY_WORDS}or - for standard input. {without}".rstrip()
    return click.argument("trajectory", type=TRAJECTORY, required=not without, help=words)


def trajectories(without: str = "", several: str = "the budget holds on each") -> Callable[[F], F]:
    """TRAJECTORY..., one or several; optional where `without` says what happens then."""
    words = f"{_TRAJECTORY_WORDS}- for standard input, or a folder of these; {several}. {without}"
    return click.argument(
        "trajectories",
        type=TRAJECTORY,
        nargs=-1,
        required=not without,
        metavar="[TRAJECTORY]..." if without else "TRAJECTORY...",
        help=words.rstrip(),
    )


payload = click.option(
    "--payload",
    type=Parsed("payload", _payload_in),
    metavar="LIST",
    help="Load at the end effector: mass,x,y,z[,ixx,iyy,izz[,ixy,ixz,iyz]] in kg, m and kg m^2, in the frame "
    "of --tip, or else of the last link; inertia about the centre of mass.",
)

drives = click.option(
    "--drives/--no-drives",
    default=None,
    help="Include the drives' inertia, or take the links alone.  [default: included where there are drives]",
)

states = together(
    number("--states", 4000, "Number of states to draw if there is no trajectory.", 1, 1_000_000),
    number("--seed", 0, "Seed of these states."),
)


def share(name: str, default: str, words: str) -> Callable[[F], F]:
    """An option that takes a share."""
    return click.option(
        name, metavar="SHARE", type=ShareAmount(), default=default, show_default=True, help=words
    )


dominance = together(
    share(
        "--dominance",
        "10%",
        "A part counts if dropping it changes the element by more than this share of its peak.",
    ),
    click.option(
        "--uncertainty",
        type=Parsed("uncertainty", _uncertainty_in),
        metavar="LIST",
        help="Standard uncertainties of all links, for the probability of verdicts: "
        "mass=5%,com=2mm,inertia=10%.  [default: those of the arm file]",
    ),
)

top = number("--top", 0, "Rows of the ranking to print.")

BUDGET = (
    "Allowed torque error: 1% (of each joint's peak torque), 0.5% limit, 10% friction, uncertainty, log, or "
    '0.5 (N m); the larger of several joined by "or"; for all joints, or one per joint, comma-separated.'
)


def budget(words: str = BUDGET) -> Callable[[F], F]:
    """--budget."""
    kind = Parsed("budget", parse_budget)
    return click.option("--budget", type=kind, default="1%", metavar="LIST", help=words)


def named_budget() -> Callable[[F], F]:
    """--budget of the main job, which also tries the named ones."""
    words = BUDGET.removesuffix("  [default: 1%]")
    default = "1%, or the first of the named budgets whose model can be read"
    kind = Parsed("budget", parse_budget)
    return click.option(
        "--budget", type=kind, default=None, metavar="LIST", help=f"{words}  [default: {default}]"
    )


def level(names: Sequence[str] = tuple(LEVEL_NAMES)) -> Callable[[F], F]:
    """--level, by default the first of the names."""
    words = [f"{name}: {LEVEL_NAMES[name]}" for name in names]
    return click.option("--level", type=click.Choice(names), default=names[0], help=f"{'; '.join(words)}.")


verdicts = click.option(
    "--verdicts",
    type=click.Choice(("own", "text")),
    default="own",
    show_default=True,
    help="With --level element: whose verdicts say which part of an element is kept, those over the states "
    "(own) or [FGL87]'s (text).",
)
seconds = click.option(
    "--seconds",
    type=Amount("time", most=86_400.0),
    default=30.0,
    show_default=True,
    metavar="TIME",
    help="Processor time of the search; then the best model that holds is the answer, or the exact torque.",
)
at_set_points = click.option(
    "--at-set-points",
    is_flag=True,
    help="Keep the budget at the set points, or at the states drawn, only.",
)
