"""MJCF of random arms that use what the format allows: classes of defaults, shapes, compiler settings."""

from __future__ import annotations

from collections.abc import Set

import numpy as np
from hypothesis import strategies as st

FEATURES = (
    "radian", "eulerseq", "shell", "classes", "childclass", "density", "sizes of a default", "fromto",
    "inertia from shapes", "groups", "settotalmass", "boundmass", "boundinertia", "balanceinertia",
    "reference", "two joints", "slide", "fixed bodies", "full inertia", "actuators", "gravity",
    "turned default", "later compiler", "massless bodies", "joint default", "turned shapes", "turned bodies",
    "stated inertia", "default of shapes", "later default", "gear of a default",
)  # fmt: skip


@st.composite
def mjcf_arms(draw: st.DrawFn) -> str:
    """A file of one chain; features are drawn, numbers come from a seed that is drawn as well."""
    features = draw(st.sets(st.sampled_from(FEATURES)))
    return mjcf_arm(features, np.random.default_rng(draw(st.integers(0, 2**32 - 1))))


def mjcf_arm(features: Set[str], rng: np.random.Generator) -> str:
    """A file of one chain that has the given features."""
    return _Writer(features, rng).file()


class _Writer:
    """Elements with random numbers."""

    def __init__(self, features: Set[str], rng: np.random.Generator) -> None:
        self.features, self.rng = features, rng
        self.joints: list[str] = []

    def numbers(self, count: int, low: float, high: float) -> str:
        """Numbers of three digits, so that no angle is near a right one."""
        return " ".join(f"{value:.3g}" for value in self.rng.uniform(low, high, count))

    def some(self, *words: str) -> str:
        return str(self.rng.choice(words))

    def turned(self) -> str:
        angle = 1.3 if self.has("radian") and not self.has("later compiler") else 80.0
        kind = self.some("quat", "euler", "axisangle", "xyaxes", "zaxis")
        if kind == "euler":
            return f'euler="{self.numbers(3, -angle, angle)}"'
        if kind == "axisangle":
            return f'axisangle="{self.numbers(3, 0.2, 1)} {self.numbers(1, 0.1, angle)}"'
        count = {"quat": 4, "xyaxes": 6, "zaxis": 3}[kind]
        return f'{kind}="{self.numbers(count, -1, 1)}"'

    def has(self, feature: str) -> bool:
        return feature in self.features

    def file(self) -> str:
        settings = {
            "angle": self.has("radian") and "radian",
            "eulerseq": self.has("eulerseq") and "".join(self.rng.choice(list("xyzXYZ"), 3)),
            "inertiafromgeom": self.has("inertia from shapes") and "true",
            "inertiagrouprange": self.has("groups") and "1 3",
            "settotalmass": self.has("settotalmass") and self.numbers(1, 1, 9),
            "boundmass": self.has("boundmass") and self.numbers(1, 0.1, 2),
            "boundinertia": self.has("boundinertia") and self.numbers(1, 0.01, 0.1),
            "balanceinertia": self.has("balanceinertia") and "true",
        }
        stated = " ".join(f'{key}="{value}"' for key, value in settings.items() if value)
        compilers = [f"<compiler {stated}/>"]
        if self.has("later compiler"):
            compilers.append('<compiler angle="degree" meshdir="assets"/>')
        option = (
            f'<option gravity="{self.numbers(3, -9, 9)}" timestep="0.001"/>' if self.has("gravity") else ""
        )
        body = self.body(int(self.rng.integers(1, 4)))
        actuators = ""
        if self.has("actuators"):
            kinds = [self.some("motor", "position", "general") for _ in self.joints]
            gears = ['gear="7"' if self.rng.random() < 0.5 else "" for _ in self.joints]
            actuators = "".join(
                f'<{kind} joint="{joint}" {gear} armature="0.0{k + 1}"/>'
                for k, (kind, joint, gear) in enumerate(zip(kinds, self.joints, gears, strict=True))
            )
        return "\n".join(
            ["<mujoco>", *compilers, option, *self.defaults(), f"<worldbody>{body}</worldbody>",
             f"<actuator>{actuators}</actuator>", "</mujoco>"]
        )  # fmt: skip

    def defaults(self) -> list[str]:
        """Defaults of class main and of "a" and "b", one within the other."""
        shape = 'type="box" size="0.04 0.07 0.11"' if self.has("sizes of a default") else ""
        density = 'density="500"' if self.has("density") else ""
        mass = 'mass="0.7"' if self.has("default of shapes") else ""
        turn = 'quat="1 0.3 0.2 0.1"' if self.has("turned default") else ""
        group = 'group="2"' if self.has("groups") and self.rng.random() < 0.5 else ""
        joint = (
            '<joint armature="0.02" pos="0.01 0.02 0.03" axis="1 0 2"/>' if self.has("joint default") else ""
        )
        gear = '<motor gear="3"/>' if self.has("gear of a default") else ""
        main = f"<geom {shape} {density} {group}/>{joint}{gear}"
        inner = f'<default class="b"><geom {mass} {turn}/></default>'
        outer = f'<default class="a"><geom mass="0" rgba="1 0 0 1"/><joint damping="1"/>{inner}</default>'
        if self.has("later default"):
            return [f"<default>{main}</default>", f'<default class="main">{outer}</default>']
        return [f"<default>{main}{outer}</default>"]

    def body(self, count: int) -> str:
        """A chain of bodies, each within the one before, and fixed ones beside them."""
        name, inner = f"body{count}", self.body(count - 1) if count > 1 else ""
        joints = "".join(self.joint(f"{name}_{k}") for k in range(2 if self.has("two joints") else 1))
        beside = ""
        if self.has("fixed bodies"):
            mass = "" if self.has("massless bodies") else self.mass()
            beside = (
                f'<body name="{name}_beside" pos="{self.numbers(3, -0.3, 0.3)}" {self.turned()}>{mass}</body>'
            )
        turned = self.turned() if self.has("turned bodies") else ""
        childclass = f'childclass="{self.some("a", "b")}"' if self.has("childclass") else ""
        return (
            f'<body name="{name}" pos="{self.numbers(3, -0.4, 0.4)}" {turned} {childclass}>'
            f"{joints}{self.mass(least=True)}{beside}{inner}</body>"
        )

    def joint(self, name: str) -> str:
        self.joints.append(name)
        kind = 'type="slide"' if self.has("slide") and self.rng.random() < 0.5 else ""
        reference = f'ref="{self.numbers(1, -0.5, 0.5)}"' if self.has("reference") else ""
        axis = f'axis="{self.numbers(3, -1, 1)}"' if self.rng.random() < 0.7 else ""
        place = f'pos="{self.numbers(3, -0.1, 0.1)}"' if self.rng.random() < 0.5 else ""
        of_class = self.of_class()
        return f'<joint name="{name}" {kind} {axis} {place} {reference} {of_class} range="-1 2"/>'

    def of_class(self) -> str:
        return f'class="{self.some("main", "a", "b")}"' if self.has("classes") else ""

    def mass(self, least: bool = False) -> str:
        """Shapes, or a stated inertia; at `least` some mass, as MuJoCo wants of bodies that move."""
        shapes = "".join(self.shape() for _ in range(int(self.rng.integers(0, 4))))
        if not least and not self.has("stated inertia"):
            return shapes
        frame = f'pos="{self.numbers(3, -0.2, 0.2)}" mass="{self.numbers(1, 0.5, 3)}"'
        if self.has("full inertia"):
            inertia = 'fullinertia="0.03 0.04 0.05 0.001 -0.002 0.003"'
        else:
            inertia = f'diaginertia="0.03 0.04 0.05" {self.turned()}'
        if self.has("balanceinertia"):
            inertia = 'diaginertia="0.01 0.02 0.05"'
        # Without <inertial> the shapes may all be of class "a", which weighs nothing.
        place = self.numbers(3, 0, 0.2)
        sphere = f'<geom class="main" type="sphere" size="0.05" mass="0.4" group="1" pos="{place}"/>'
        return shapes + (f"<inertial {frame} {inertia}/>" if self.has("stated inertia") else sphere)

    def shape(self) -> str:
        kind = self.some("sphere", "capsule", "cylinder", "ellipsoid", "box")
        shell = 'shellinertia="true"' if self.has("shell") and kind != "ellipsoid" else ""
        group = f'group="{self.rng.integers(0, 5)}"' if self.has("groups") else ""
        weighs = self.some(
            "", "", f'mass="{self.numbers(1, 0.1, 2)}"', f'density="{self.numbers(1, 100, 3000)}"'
        )
        sizes = {"sphere": 1, "capsule": 2, "cylinder": 2}.get(kind, 3)
        if self.has("sizes of a default"):
            sizes = int(self.rng.integers(1, sizes + 1))
        place = f'pos="{self.numbers(3, -0.2, 0.2)}" {self.turned() if self.has("turned shapes") else ""}'
        of_class = self.of_class()
        if self.has("fromto") and kind != "sphere" and not self.has("turned default"):
            sizes, place = 1, f'fromto="{self.numbers(6, -0.2, 0.2)}"'
        kind = "" if self.has("sizes of a default") and "fromto" not in place else f'type="{kind}"'
        size = f'size="{self.numbers(sizes, 0.02, 0.12)}"'
        return f"<geom {kind} {size} {place} {weighs} {shell} {group} {of_class}/>"
