"""Text of a reduced joint for MuJoCo, URDF and Modelica."""

from __future__ import annotations

import re
from collections.abc import Mapping

from gearplay.vocabulary.errors import InputError

IMPEDANCE = 1e-4
"""Least impedance of a limit in MuJoCo."""
_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,63}", re.ASCII)


def _checked(name: str) -> str:
    if not isinstance(name, str) or not _NAME.fullmatch(name):
        rule = "must be a letter, then letters, digits and underscores, 64 at most"
        raise InputError.of("name", name, rule, "Choose another")
    return name


def mujoco_text(joint: Mapping[str, float], name: str) -> str:
    """Return two nested bodies: the motor's hinge with its armature, and the play, a hinge with soft limits.

    A limit of MuJoCo with negative ``solref`` (s_1, s_2) and impedance d gives the relative acceleration
    a = (1 - d) a_0 - s_1 r - s_2 v, with a_0 that without the limit. The least d, 1e-4, makes it a spring and a damper; s_1 and
    s_2 are (1 - d) k / I and (1 - d) c / I with the inertia of both sides in series, I_1 I_2 / (I_1 + I_2). Without play the
    hinge is a spring.
    """
    name, half = _checked(name), joint["half_width"]
    small = 1e-3 * joint["inertia"]
    motor = max(joint["input_inertia"], 1.001 * small)
    per_inertia = (1.0 - IMPEDANCE) * (1.0 / joint["inertia"] + 1.0 / motor)
    soft = (joint["stiffness"] * per_inertia, joint["damping"] * per_inertia)
    if half > 0.0:
        play = (
            f'range="{-half:.9g} {half:.9g}" limited="true" '
            f'solreflimit="{-soft[0]:.9g} {-soft[1]:.9g}" solimplimit="{IMPEDANCE:g} {IMPEDANCE:g} 1e-6"'
        )
    else:
        play = f'stiffness="{joint["stiffness"]:.9g}" damping="{joint["damping"]:.9g}"'
    return f"""\
<!-- {name}: from gearplay; stiffness {joint["stiffness"]:.9g} N m/rad, damping {joint["damping"]:.9g} N m s/rad.
     Angles are in radians: compiler angle="radian". -->
<body name="{name}_motor">
  <joint name="{name}" type="hinge" axis="0 0 1" armature="{motor - small:.9g}" frictionloss="{joint["friction"]:.9g}"/>
  <inertial pos="0 0 0" mass="{small:.9g}" diaginertia="{small:.9g} {small:.9g} {small:.9g}"/>
  <body name="{name}_output">
    <joint name="{name}_backlash" type="hinge" axis="0 0 1" {play}/>
    <inertial pos="0 0 0" mass="1" diaginertia="{joint["inertia"]:.9g} {joint["inertia"]:.9g} {joint["inertia"]:.9g}"/>
  </body>
</body>
"""


def urdf_text(joint: Mapping[str, float], name: str) -> str:
    """Return the joint with its friction and damping, the rest as a comment."""
    name = _checked(name)
    return f"""\
<!-- {name}: URDF has no play and no stiffness of joints; those of the train at the output are
     backlash {2.0 * joint["half_width"]:.9g} rad, stiffness {joint["stiffness"]:.9g} N m/rad,
     damping {joint["damping"]:.9g} N m s/rad, inertia ahead of them {joint["input_inertia"]:.9g} kg m^2 -->
<joint name="{name}" type="continuous">
  <parent link="{name}_base"/>
  <child link="{name}_output"/>
  <axis xyz="0 0 1"/>
  <dynamics damping="0" friction="{joint["friction"]:.9g}"/>
</joint>
<link name="{name}_base"/>
<link name="{name}_output">
  <inertial>
    <mass value="1"/>
    <inertia ixx="{joint["inertia"]:.9g}" ixy="0" ixz="0" iyy="{joint["inertia"]:.9g}" iyz="0" izz="{joint["inertia"]:.9g}"/>
  </inertial>
</link>
"""


def modelica_text(joint: Mapping[str, float], name: str) -> str:
    """Return a model of the Modelica Standard Library: inertia, elasto-backlash, inertia, friction."""
    name = _checked(name)
    half = joint["half_width"]
    kind, play = ("ElastoBacklash", f", b={2.0 * half:.9g}") if half > 0.0 else ("SpringDamper", "")
    friction, last = "", "output_"
    if joint["friction"] > 0.0:
        kind_of_it = "Modelica.Mechanics.Rotational.Components.BearingFriction"
        friction, last = f"  {kind_of_it} friction(tau_pos=[0, {joint['friction']:.9g}]);\n", "friction"
    link = "  connect(output_.flange_b, friction.flange_a);\n" if friction else ""
    return f"""\
model {name} "Train reduced to one joint, at its output, by gearplay"
  Modelica.Mechanics.Rotational.Interfaces.Flange_a flange_a "input, in the coordinate of the output";
  Modelica.Mechanics.Rotational.Interfaces.Flange_b flange_b "output";
  Modelica.Mechanics.Rotational.Components.Inertia input_(J={joint["input_inertia"]:.9g});
  Modelica.Mechanics.Rotational.Components.{kind} train(c={joint["stiffness"]:.9g}, d={joint["damping"]:.9g}{play});
  Modelica.Mechanics.Rotational.Components.Inertia output_(J={joint["inertia"]:.9g});
{friction}equation
  connect(flange_a, input_.flange_a);
  connect(input_.flange_b, train.flange_a);
  connect(train.flange_b, output_.flange_a);
{link}  connect({last}.flange_b, flange_b);
end {name};
"""
